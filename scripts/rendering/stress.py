"""The stress in cloths of membranes, threads and solids: of the places of their nodes, now and when they were not stretched, and of the
elasticity that frames.h5 has of them. Cauchy's, in world axes, positive in tension; of elasticity alone, without what damps."""
import numpy as np
from strain import gradients_of, sides_of

LEAST_SHARE = 0.01  # as in src/constraints/tetrahedron_current_volume.hpp


def components(tensors):
    """xx, yy, zz, yz, xz, xy."""
    return tensors[:, [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]


def von_mises(stress):
    """Of components."""
    xx, yy, zz, yz, xz, xy = stress.T
    return np.sqrt(((xx - yy)**2 + (yy - zz)**2 + (zz - xx)**2) / 2 + 3 * (yz**2 + xz**2 + xy**2))


def pushed_forward(gradient, stress, ratio):
    """Cauchy's stress of the second Piola-Kirchhoff stress; ratio: of the volume now to that before. NaN of what is inside out."""
    return gradient @ stress @ np.swapaxes(gradient, 1, 2) / np.where(ratio > 0, ratio, np.nan)[:, None, None]


def of_tetrahedra(now, before, elasticity, energy_volume):
    """[cells, 4, 3] twice, Young's modulus (Pa) and Poisson's ratio [cells, 2]; St. Venant-Kirchhoff's law, or with energy_volume
    'current' that whose energy is weighed with the current volume."""
    modulus, poisson = elasticity.T[:, :, None, None]
    gradient = gradients_of(now, before)
    ratio, strain = np.linalg.det(gradient), (np.swapaxes(gradient, 1, 2) @ gradient - np.eye(3)) / 2
    trace = np.trace(strain, axis1=1, axis2=2)[:, None, None]
    second = modulus / (1 + poisson) * (strain + poisson / (1 - 2 * poisson) * trace * np.eye(3))
    if energy_volume != 'current':
        return components(pushed_forward(gradient, second, ratio))
    density = (strain * second).sum((1, 2)) / 2  # of the energy; it changes with the volume that weighs it
    weighed = pushed_forward(gradient, second * np.maximum(ratio, LEAST_SHARE)[:, None, None], ratio)
    return components(weighed + np.where(ratio > LEAST_SHARE, density, 0)[:, None, None] * np.eye(3))


def of_triangles(now, before, elasticity):
    """Plane stress of a membrane, over the thickness that it has at rest."""
    modulus, poisson = elasticity.T[:, :, None, None]
    along, other = np.swapaxes(sides_of(before), 0, 1)
    first = along / np.linalg.norm(along, axis=1)[:, None]
    second = other - (other * first).sum(1)[:, None] * first
    second /= np.linalg.norm(second, axis=1)[:, None]
    in_plane = sides_of(before) @ np.stack([first, second], 2)
    gradient = np.swapaxes(np.linalg.solve(in_plane, sides_of(now)), 1, 2)  # of places now by those in the plane before
    metric = np.swapaxes(gradient, 1, 2) @ gradient
    strain = (metric - np.eye(2)) / 2
    trace = np.trace(strain, axis1=1, axis2=2)[:, None, None]
    stress = modulus / (1 - poisson**2) * ((1 - poisson) * strain + poisson * trace * np.eye(2))
    return components(pushed_forward(gradient, stress, np.sqrt(np.linalg.det(metric))))


def of_segments(now, before, elasticity):
    """The force of a thread's segment over its section at rest."""
    sides = [sides_of(places)[:, 0] for places in (now, before)]
    lengths = [np.linalg.norm(side, axis=1) for side in sides]
    along = sides[0] / lengths[0][:, None]
    return components((elasticity[:, 0] * (lengths[0] / lengths[1] - 1))[:, None, None] * along[:, :, None] * along[:, None, :])


class Elastic:
    """A cloth, thread or solid of frames.h5, group: its own in /surfaces."""

    def __init__(self, group):
        self.cells = group['cells'][:]
        self.tetrahedra = group['tetrahedra'][:] if 'tetrahedra' in group else None
        self.elasticity = group['elasticity'][:].astype(float) if 'elasticity' in group else None
        self.energy_volume = group.attrs.get('energy_volume', b'rest').decode()
        self.inside = None  # of each cell of a solid's surface its tetrahedron

    def of_tetrahedra(self, now, before):
        """Places of all bodies; NaN where the law is not known."""
        if self.elasticity is None:
            return np.full((len(self.tetrahedra), 6), np.nan)
        return of_tetrahedra(now[self.tetrahedra], before[self.tetrahedra], self.elasticity, self.energy_volume)

    def of_cells(self, now, before):
        """Of a solid's surface that of the tetrahedra below it; NaN of what has no elasticity of its own, as cloths of links."""
        if self.elasticity is None:
            return np.full((len(self.cells), 6), np.nan)
        if self.tetrahedra is None:
            of = of_segments if self.cells.shape[1] == 2 else of_triangles
            return of(now[self.cells], before[self.cells], self.elasticity)
        if self.inside is None:
            self.inside = self.tetrahedra_below()
        below = self.tetrahedra[self.inside]
        return of_tetrahedra(now[below], before[below], self.elasticity[self.inside], self.energy_volume)

    def tetrahedra_below(self):
        faces = np.sort(np.concatenate([np.delete(self.tetrahedra, corner, 1) for corner in range(4)]), 1)
        cells = np.sort(self.cells, 1)
        _, same = np.unique(np.concatenate([faces, cells]), axis=0, return_inverse=True)
        face_of = np.full(same.max() + 1, -1)
        face_of[same[:len(faces)]] = np.arange(len(faces))
        return face_of[same[len(faces):]] % len(self.tetrahedra)
