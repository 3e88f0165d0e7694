#!/usr/bin/python3
"""Writes a torus of tetrahedra as Gmsh's OUT.msh: a disc of rings of triangles, swept around z, each prism cut in three.

  torus.py OUT.msh [--radius R] [--tube T] [--rings N] [--sections M]     m; 6 N^2 triangles in each of M sections (18 N^2 M tets)
"""
import argparse
import sys

import numpy as np

sys.dont_write_bytecode = True
import tets as tetrahedra  # noqa: E402


def disc(rings):
    """The unit disc: node 0 its middle, then 6 k nodes on ring k; triangles between one ring and the next."""
    nodes, first, triangles = [[0.0, 0.0]], [0], []
    for k in range(1, rings + 1):
        first.append(len(nodes))
        angles = 2 * np.pi * np.arange(6 * k) / (6 * k)
        nodes += np.column_stack([np.cos(angles), np.sin(angles)]).dot(k / rings).tolist()

    def node(ring, n):
        return first[ring] + n % max(1, 6 * ring)

    for k in range(1, rings + 1):
        for sixth in range(6):
            for n in range(k):
                inner, outer = sixth * (k - 1) + n, sixth * k + n
                triangles.append([node(k - 1, inner), node(k, outer), node(k, outer + 1)])
                if n < k - 1:
                    triangles.append([node(k - 1, inner), node(k, outer + 1), node(k - 1, inner + 1)])
    return np.array(nodes), np.array(triangles)


def swept(nodes, triangles, radius, tube, sections):
    """The disc around z. The sides of prisms are cut from their lower node to the higher one of the next section: so neighbours agree."""
    angles = 2 * np.pi * np.arange(sections) / sections
    out, up = radius + tube * nodes[:, 0], tube * nodes[:, 1]
    places = [np.column_stack([out * np.cos(a), out * np.sin(a), up]) for a in angles]
    corners, cells = np.sort(triangles, axis=1), []
    for section in range(sections):
        a, b, c = (corners + section * len(nodes)).T
        d, e, f = (corners + (section + 1) % sections * len(nodes)).T
        cells += [np.column_stack(four) for four in ((a, b, c, f), (a, b, e, f), (a, d, e, f))]
    return np.concatenate(places), np.concatenate(cells)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", metavar="OUT.msh")
    parser.add_argument("--radius", type=float, default=0.3, help="of the circle in the tube's middle (0.3)")
    parser.add_argument("--tube", type=float, default=0.1, help="radius of the tube (0.1)")
    parser.add_argument("--rings", type=int, default=2, help="of triangles in the tube (2)")
    parser.add_argument("--sections", type=int, default=32, help="around z (32)")
    chosen = parser.parse_args()
    if not 0 < chosen.tube < chosen.radius or chosen.rings < 1 or chosen.sections < 3:
        parser.error("needs 0 < tube < radius, 1 ring and 3 sections at least")
    nodes, cells = swept(*disc(chosen.rings), chosen.radius, chosen.tube, chosen.sections)
    tetrahedra.write_msh(chosen.out, nodes, tetrahedra.oriented(nodes, cells))


if __name__ == "__main__":
    main()
