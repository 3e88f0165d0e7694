"""How cloths, threads and solids are stretched, from the places of their nodes now and when they were not."""
import numpy as np


def gram(sides):
    """Of the sides of cells [cells, sides, 3] the products of each with each."""
    return np.einsum('cik,cjk->cij', sides, sides)


def sides_of(places):
    return places[:, 1:] - places[:, :1]


def stretches_of(now, before):
    """Of segments and triangles [cells, corners, 3], by how much each is longer than it was: along the direction in which it is so most."""
    sides = [sides_of(places) for places in (now, before)]
    if now.shape[1] == 2:
        lengths = [np.linalg.norm(side[:, 0], axis=1) for side in sides]
        return lengths[0] / lengths[1]
    # The squares of the principal stretches are the eigenvalues of the metric now over that before.
    ratio = np.linalg.solve(gram(sides[1]), gram(sides[0]))
    half_trace, determinant = np.trace(ratio, axis1=1, axis2=2) / 2, np.linalg.det(ratio)
    return np.sqrt(half_trace + np.sqrt(np.maximum(half_trace**2 - determinant, 0)))


def gradients_of(now, before):
    """Of tetrahedra [cells, 4, 3], the derivatives dx/dX of places now by places before."""
    return np.swapaxes(np.linalg.solve(sides_of(before), sides_of(now)), 1, 2)  # sides now are sides before times its transpose


def strains_of(now, before):
    """Of tetrahedra [cells, 4, 3]: Green's strain, xx, yy, zz, yz, xz, xy in the axes in which they were before; the greatest
    magnitude of its principal values; and their volumes over those before."""
    gradient = gradients_of(now, before)
    strain = (np.swapaxes(gradient, 1, 2) @ gradient - np.eye(3)) / 2
    parts = strain[:, [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]
    return parts, np.abs(np.linalg.eigvalsh(strain)).max(1), np.linalg.det(gradient)
