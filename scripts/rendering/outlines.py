"""The surfaces of bodies as triangles: of each kind of shape once, at unit size, and then of many bodies by their states."""
import numpy as np

from bodies import BOX, CAPSULE, CYLINDER, DISC, HULL, MESH, PARTICLE, SPHERE, rotate


class Outline:
    """Corners and triangles, outward normals by the right hand. A corner of a body of size s is corners * scale(s) + shift * s[2],
    where the shift is that of a capsule's half along z."""

    def __init__(self, corners, triangles, shift=None):
        self.corners, self.triangles = np.asarray(corners, float), np.asarray(triangles, np.int64)
        self.shift = np.zeros(len(self.corners)) if shift is None else np.asarray(shift, float)

    def of_sizes(self, scale, half):
        """[bodies, corners, 3] in the bodies' axes. scale: [bodies, 3]; half (m): [bodies], how far a capsule's ends are out."""
        places = self.corners[None] * scale[:, None, :]
        places[..., 2] += self.shift[None] * half[:, None]
        return places


def box():
    corners = [[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return Outline(corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def rings(profile, facets, shift):
    """A solid of revolution about z. profile: (radius, z) from the lowest point on the axis to the highest one."""
    angle = 2 * np.pi * np.arange(facets) / facets
    corners, shifts, triangles = [[0, 0, profile[0][1]]], [shift[0]], []
    for (radius, z), move in zip(profile[1:-1], shift[1:-1]):
        corners += [[radius * c, radius * s, z] for c, s in zip(np.cos(angle), np.sin(angle))]
        shifts += [move] * facets
    corners.append([0, 0, profile[-1][1]])
    shifts.append(shift[-1])
    top, last = len(corners) - 1, 1 + facets * (len(profile) - 3)
    for k in range(facets):
        n = (k + 1) % facets
        triangles += [(0, 1 + n, 1 + k), (top, last + k, last + n)]
        for first in range(1, last, facets):
            triangles += [(first + k, first + n, first + facets + n), (first + k, first + facets + n, first + facets + k)]
    return Outline(corners, triangles, shifts)


def ball(facets):
    latitude = np.linspace(-np.pi / 2, np.pi / 2, facets // 2 + 1)
    return rings([(np.cos(a), np.sin(a)) for a in latitude], facets, [0] * len(latitude))


def rod(facets):
    return rings([(0, -1), (1, -1), (1, 1), (0, 1)], facets, [0] * 4)


def capsule(facets):
    quarter = np.linspace(0, np.pi / 2, facets // 4 + 1)
    lower = [(np.cos(a), -np.sin(a)) for a in quarter[::-1]]
    upper = [(np.cos(a), np.sin(a)) for a in quarter]
    return rings(lower + upper, facets, [-1] * len(lower) + [1] * len(upper))


def plate(facets):
    """A disc of a planar scene, in the plane of x and z."""
    angle = 2 * np.pi * np.arange(facets) / facets
    corners = [[0, 0, 0]] + [[c, 0, s] for c, s in zip(np.cos(angle), np.sin(angle))]
    return Outline(corners, [(0, 1 + (k + 1) % facets, 1 + k) for k in range(facets)])


class Outlines:
    """Of all bodies of a run but planes, cloths and threads. facets: around a circle, a multiple of 4."""

    def __init__(self, bodies, facets):
        self.bodies = bodies
        sphere = ball(facets)
        self.forms = {(SPHERE, -1): sphere, (PARTICLE, -1): sphere, (BOX, -1): box(), (CYLINDER, -1): rod(facets),
                      (CAPSULE, -1): capsule(facets), (DISC, -1): plate(facets)}
        for name in bodies.library:
            kind, number = name.split('_')
            if kind != 'compound':
                group = bodies.library[name]
                nodes = group['nodes'][:]
                form = Outline(nodes / np.abs(nodes[:, 0]).max(), group['triangles'][:])
                self.forms[HULL if kind == 'hull' else MESH, int(number)] = form

    def of(self, position, orientation, shown):
        """Yields, of each form: corners [n, corners, 3] (m, world axes), triangles, and the n bodies. Bodies that are absent, or not
        shown, are not among them. shown: true or false of each body."""
        pieces = self.bodies.pieces
        there = (np.isfinite(position).all(1) & shown)[pieces.body]
        for (kind, number), form in self.forms.items():
            chosen = np.flatnonzero(there & (pieces.kind == kind) & ((number < 0) | (pieces.number == number)))
            if not len(chosen):
                continue
            size, body = pieces.size[chosen], pieces.body[chosen]
            scale = size if kind in (BOX, CYLINDER) else np.repeat(size[:, :1], 3, axis=1)
            own = form.of_sizes(scale, size[:, 2] - size[:, 0])
            corners = own.shape[1]
            turns = np.repeat(pieces.turn[chosen], corners, axis=0)
            in_body = rotate(turns, own.reshape(-1, 3)) + np.repeat(pieces.place[chosen], corners, axis=0)
            world = rotate(np.repeat(orientation[body], corners, axis=0), in_body) + np.repeat(position[body], corners, axis=0)
            yield world.reshape(-1, corners, 3), form.triangles, body
