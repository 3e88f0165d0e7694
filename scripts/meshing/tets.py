"""Tetrahedra: volumes, quality, parts, and the Gmsh file that holds them."""
import numpy as np

FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])  # opposite to each node, counterclockwise from the outside


def volumes(nodes, tets):
    a, b, c, d = (nodes[tets[:, k]] for k in range(4))
    return np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6


def oriented(nodes, tets):
    tets = tets.copy()
    inverted = volumes(nodes, tets) < 0
    tets[inverted] = tets[inverted][:, [0, 1, 3, 2]]
    return tets


def dihedral_angles(nodes, tets):
    """Degrees, six of each tet."""
    corners = nodes[tets]
    normals = [np.cross(corners[:, j] - corners[:, i], corners[:, k] - corners[:, i]) for i, j, k in FACES]
    normals = [n / np.linalg.norm(n, axis=1)[:, None] for n in normals]
    cosines = [-np.einsum("ij,ij->i", normals[i], normals[j]) for i in range(4) for j in range(i)]
    return np.degrees(np.arccos(np.clip(cosines, -1, 1))).T


def mean_ratios(nodes, tets):
    """1 for regular tets, 0 for flat ones."""
    squares = sum(((nodes[tets[:, i]] - nodes[tets[:, j]]) ** 2).sum(1) for i in range(4) for j in range(i))
    return 12 * (3 * np.abs(volumes(nodes, tets))) ** (2 / 3) / squares


def parts(tets):
    """Of each tet, the least tet that hangs together with it by faces."""
    faces = np.sort(tets[:, FACES], axis=2).reshape(-1, 3)
    order = np.lexsort(faces.T)
    same = (faces[order[1:]] == faces[order[:-1]]).all(axis=1)
    a, b = order[:-1][same] // 4, order[1:][same] // 4
    label = np.arange(len(tets))
    while True:
        low = np.minimum(label[a], label[b])
        before = label.copy()
        np.minimum.at(label, a, low)
        np.minimum.at(label, b, low)
        label = label[label]
        if (label == before).all():
            return label


def without_crumbs(nodes, tets, share=0.01):
    """Drops the parts of less than this share of the volume; returns the others and how many went."""
    label, volume = parts(tets), volumes(nodes, tets)
    size = np.bincount(label, volume, len(tets))
    small = size < share * volume.sum()
    return tets[~small[label]], int(((size > 0) & small).sum())


def write_msh(path, nodes, tets):
    """Gmsh 2.2, text; nodes of no tet are left out."""
    used, numbers = np.unique(tets, return_inverse=True)
    numbers = numbers.reshape(-1, 4) + 1
    with open(path, "w", encoding="ascii") as file:
        file.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(used)}\n")
        file.writelines("%d %.17g %.17g %.17g\n" % (k, *nodes[node]) for k, node in enumerate(used, 1))
        file.write(f"$EndNodes\n$Elements\n{len(tets)}\n")
        file.writelines("%d 4 2 1 1 %d %d %d %d\n" % (k, *tet) for k, tet in enumerate(numbers, 1))
        file.write("$EndElements\n")
