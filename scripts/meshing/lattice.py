"""Tetrahedra of a body-centred cubic lattice, cut at a surface: isosurface stuffing (Labelle and Shewchuk 2007).

Works on any surface that has an inside and an outside by its winding number: holes are closed, self-crossings do not matter.
Nodes of the lattice near the surface are warped onto it, so that no cut comes close to a node; that bounds the angles of all tets.
"""
import numpy as np

ALPHA_LONG, ALPHA_SHORT = 0.24999, 0.41189  # of an edge: cuts nearer to its end warp that end (the paper's safe bounds)


def body_centred(low, high, side):
    """Nodes (corners and centres of cubes) and tets around a box."""
    count = np.ceil((high - low) / side).astype(int) + 2
    origin = (low + high - side * count) / 2
    shape = 2 * count + 1  # in half sides: corners are even, centres odd
    number = np.full(shape, -1)
    grid = np.indices(shape).reshape(3, -1)
    used = grid[:, np.all(grid % 2 == grid[:1] % 2, axis=0)]
    number[tuple(used)] = np.arange(used.shape[1])
    tets = []
    centres = used[:, used[0] % 2 == 1].T
    for axis in range(3):
        along, u, v = (np.eye(3, dtype=int)[(axis + k) % 3] for k in range(3))
        first = centres[centres[:, axis] + 2 < shape[axis]]
        ring = [u + v, v - u, -u - v, u - v]  # corners of the square between two neighbouring centres
        for k in range(4):
            four = [first, first + 2 * along, first + along + ring[k], first + along + ring[(k + 1) % 4]]
            tets.append(np.stack([number[tuple(x.T)] for x in four], axis=1))
    return origin + used.T * (side / 2), np.concatenate(tets)


def edges_of(tets):
    pairs = np.concatenate([tets[:, [i, j]] for i in range(4) for j in range(i + 1, 4)])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def signed_distances(nodes, edges, distance, side):
    """Positive inside. The winding number is asked near the surface alone: no edge crosses it farther away."""
    signed = np.linalg.norm(nodes - distance.nearest(nodes), axis=1)
    ask = signed < 1.01 * side
    near = np.flatnonzero(ask)
    sign = np.zeros(len(nodes))
    sign[near] = np.where(distance.inside(nodes[near]), 1, -1)
    far = edges[(~ask[edges]).any(axis=1)]  # neighbours on the same side
    while True:
        a, b = sign[far].T
        grown = np.concatenate([far[(a != 0) & (b == 0), 1], far[(a == 0) & (b != 0), 0]])
        if len(grown) == 0:
            break
        sign[grown] = np.concatenate([a[(a != 0) & (b == 0)], b[(a == 0) & (b != 0)]])
    return signed * np.where(sign == 0, -1, sign)


def warp(nodes, signed, edges, side):
    """Moves nodes onto cuts that are too near to them; returns the remaining cuts as {edge: place}."""
    a, b = edges.T
    crossing = np.flatnonzero(signed[a] * signed[b] < 0)
    a, b = a[crossing], b[crossing]
    along = signed[a] / (signed[a] - signed[b])
    places = nodes[a] + along[:, None] * (nodes[b] - nodes[a])
    length = np.linalg.norm(nodes[b] - nodes[a], axis=1)
    alpha = np.where(length > 0.95 * side, ALPHA_LONG, ALPHA_SHORT)
    violations = [(along[i] * length[i], a[i], b[i], i) for i in np.flatnonzero(along < alpha)]
    violations += [((1 - along[i]) * length[i], b[i], a[i], i) for i in np.flatnonzero(1 - along < alpha)]
    for _, node, other, i in sorted(violations):
        if signed[node] != 0 and signed[other] != 0:
            nodes[node], signed[node] = places[i], 0
    return {(a[i], b[i]): places[i] for i in range(len(a)) if signed[a[i]] * signed[b[i]] < 0}


def stuffed(distance, low, high, side):
    """Nodes and tets inside the surface, where `low` and `high` are the corners of its box."""
    nodes, tets = body_centred(low, high, side)
    edges = edges_of(tets)
    signed = signed_distances(nodes, edges, distance, side)
    tets = tets[(signed[tets] > 0).any(axis=1)]
    cuts = warp(nodes, signed, edges, side)
    number = {edge: len(nodes) + k for k, edge in enumerate(cuts)}
    nodes = np.concatenate([nodes, np.array(list(cuts.values())).reshape(-1, 3)])
    sign = np.sign(signed[tets])
    tets, sign = tets[(sign > 0).any(axis=1)], sign[(sign > 0).any(axis=1)]
    cut = (sign < 0).any(axis=1)
    parts = [part for tet, s in zip(tets[cut], sign[cut]) for part in clipped(tet, s, number)]
    return nodes, np.concatenate([tets[~cut], np.array(parts, int).reshape(-1, 4)])


def clipped(tet, sign, number):
    """The part of a tet on the side of its positive nodes, as tets. All quadrangles are cut from their lowest node, so that both
    tets at a face cut it in the same way; the lowest node of the part is the apex of its tets."""
    cut = {(i, j): number[min(tet[i], tet[j]), max(tet[i], tet[j])] for i in range(4) for j in range(4) if sign[i] > 0 > sign[j]}
    faces = [clipped_face([i for i in range(4) if i != k], tet, sign, cut) for k in range(4)]
    inside, outside = np.flatnonzero(sign > 0), np.flatnonzero(sign < 0)
    on = [tet[k] for k in np.flatnonzero(sign == 0)]
    if len(inside) == 2 and len(outside) == 2:
        (i, j), (k, l) = inside, outside
        faces.append([cut[i, k], cut[i, l], cut[j, l], cut[j, k]])
    else:
        faces.append(on + list(cut.values()))
    apex = min(node for face in faces for node in face)
    for face in faces:
        if len(face) >= 3 and apex not in face:
            turn = face.index(min(face))
            face = face[turn:] + face[:turn]
            for k in range(1, len(face) - 1):
                yield [apex, face[0], face[k], face[k + 1]]


def clipped_face(corners, tet, sign, cut):
    polygon = []
    for i, j in zip(corners, corners[1:] + corners[:1]):
        if sign[i] >= 0:
            polygon.append(tet[i])
        if sign[i] * sign[j] < 0:
            polygon.append(cut[(i, j) if sign[i] > 0 else (j, i)])
    return polygon
