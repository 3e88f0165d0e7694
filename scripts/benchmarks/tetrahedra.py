"""Meshes of tetrahedra for shapes that a block is not: a lattice of cells, each split in six, with its nodes moved into place."""
import itertools

import numpy as np


def lattice(cells, place, centre=(0, 0, 0)):
    """Places and tetrahedra of cells[0] x cells[1] x cells[2] cells, the node (i, j, k) at place(i, j, k), arrays of float.

    The diagonals of the cells start at the corner nearest to `centre`, so that a shape that is its own mirror image about a plane
    through it has a mesh that is so too.
    """
    count = np.array(cells) + 1
    i, j, k = (a.ravel(order='F') for a in np.indices(count))
    points = np.stack(place(i.astype(float), j.astype(float), k.astype(float)), axis=1)
    strides = np.array([1, count[0], count[0] * count[1]])
    cell = np.stack([a.ravel(order='F') for a in np.indices(cells)], axis=1)
    away = np.where(cell + .5 < np.array(centre), -1, 1)
    low = cell + (away < 0)
    tets = []
    for path in itertools.permutations(range(3)):
        corners = [low.copy()]
        for axis in path:
            corners.append(corners[-1].copy())
            corners[-1][:, axis] += away[:, axis]
        tets.append(np.stack([corner @ strides for corner in corners], axis=1))
    tets = np.concatenate(tets)
    edges = points[tets[:, 1:]] - points[tets[:, :1]]
    turned = np.linalg.det(edges) < 0
    tets[turned, 2:] = tets[turned, :1:-1]
    return points, tets


def membrane(cells):
    """Cook's membrane: 48 long, 44 high at the held end and 16 at the other, 1 thick. Its halves are mirror images, or it would
    bend out of its plane."""
    def place(i, j, k):
        x, t = 48 * i / cells, j / cells
        return x, (1 - t) * 44 * x / 48 + t * (44 + 16 * x / 48), k / 2
    return lattice([cells, cells, 2], place, (0, 0, 1))


def round_bar(across, along, radius, length):
    """A bar along z: a lattice of squares pressed into a circle."""
    def place(i, j, k):
        a, b = 2 * i / across - 1, 2 * j / across - 1
        # Squares become circles, evenly spaced along the axes and the diagonals alike.
        largest, norm = np.maximum(abs(a), abs(b)), np.hypot(a, b)
        grow = radius * np.divide(largest, norm, out=np.zeros_like(norm), where=norm > 0)
        return grow * a, grow * b, length * k / along
    return lattice([across, across, along], place, (across / 2, across / 2, 0))


def write_msh(path, points, tets):
    """Gmsh 2.2, text."""
    with open(path, 'w', encoding='ascii') as file:
        file.write(f'$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(points)}\n')
        file.writelines(f'{n} {x!r} {y!r} {z!r}\n' for n, (x, y, z) in enumerate(points.tolist(), 1))
        file.write(f'$EndNodes\n$Elements\n{len(tets)}\n')
        file.writelines(f'{n} 4 0 {a} {b} {c} {d}\n' for n, (a, b, c, d) in enumerate((tets + 1).tolist(), 1))
        file.write('$EndElements\n')
