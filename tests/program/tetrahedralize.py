#!/usr/bin/python3
"""scripts/tetrahedralize on spheres and boxes, whole and with faults: the mesh is sound, fills the surface, has good angles; what
cannot be meshed is named. TetGen's part is tested where TetGen is installed."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

SOURCE = pathlib.Path(os.environ.get("UNIBODY_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))


def sphere(rings=24):
    """Radius 1; triangles of a globe, counterclockwise from the outside."""
    points = [(0, 0, 1), (0, 0, -1)]
    for polar in np.pi * np.arange(1, rings) / rings:
        for turn in np.pi * np.arange(2 * rings) / rings:
            points.append((np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)))
    at = lambda i, j: 2 + i * 2 * rings + j % (2 * rings)
    triangles = []
    for j in range(2 * rings):
        triangles += [(0, at(0, j), at(0, j + 1)), (1, at(rings - 2, j + 1), at(rings - 2, j))]
        for i in range(rings - 2):
            triangles += [(at(i, j), at(i + 1, j), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i, j + 1))]
    return np.array(points, float), np.array(triangles)


def box():
    """2 x 1 x 1 from the origin on."""
    points = np.array([(2 * (k & 1), k >> 1 & 1, k >> 2) for k in range(8)], float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return points, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def read_msh(path):
    lines = path.read_text().split("\n")
    start, count = lines.index("$Nodes") + 2, int(lines[lines.index("$Nodes") + 1])
    nodes = np.array([line.split()[1:] for line in lines[start:start + count]], float)
    start, count = lines.index("$Elements") + 2, int(lines[lines.index("$Elements") + 1])
    return nodes, np.array([line.split()[-4:] for line in lines[start:start + count]], int) - 1


def edge_matrices(nodes, tets):
    return nodes[tets[:, 1:]] - nodes[tets[:, :1]]


def angles(nodes, tets):
    """Dihedral angles in degrees: of each edge, between the other two corners as seen along it."""
    result = []
    for i, j, k, l in (0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1):
        p, q, r, s = (nodes[tets[:, m]] for m in (i, j, k, l))
        axis = (q - p) / np.linalg.norm(q - p, axis=1)[:, None]
        u, v = ((x - p) - np.einsum("ij,ij->i", x - p, axis)[:, None] * axis for x in (r, s))
        cosine = np.einsum("ij,ij->i", u, v) / (np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1))
        result.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return np.array(result)


class Tetrahedralize(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def run_script(self, points, triangles, *options):
        surface, out = self.folder / "surface.obj", self.folder / "out.msh"
        surface.write_text("".join("v %.17g %.17g %.17g\n" % tuple(p) for p in points) +
                           "".join("f %d %d %d\n" % tuple(t + 1) for t in triangles))
        words = [SOURCE / "scripts" / "tetrahedralize", surface, out, *options]
        done = subprocess.run(words, text=True, capture_output=True, check=False)
        return done, out

    def mesh(self, points, triangles, *options):
        done, out = self.run_script(points, triangles, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        nodes, tets = read_msh(out)
        self.assertEqual(len(nodes), len(np.unique(tets)))
        faces = np.sort(np.concatenate([np.delete(tets, k, axis=1) for k in range(4)]), axis=1)
        counts = np.unique(faces, axis=0, return_counts=True)[1]
        self.assertLessEqual(counts.max(), 2)
        volumes = np.linalg.det(edge_matrices(nodes, tets)) / 6
        self.assertGreater(volumes.min(), 0)
        return nodes, tets, volumes.sum(), done.stdout

    def test_a_sphere_is_filled_with_tets_of_bounded_angles(self):
        for tets in 500, 5000:
            nodes, mesh, volume, _ = self.mesh(*sphere(), "--tets", str(tets))
            self.assertLess(abs(len(mesh) / tets - 1), 0.3 if tets < 1000 else 0.1)  # a symmetric lattice grows by leaps
            side = (12 * volume / len(mesh)) ** (1 / 3)  # of the cubes, whose sides are the lattice's longest edges
            # regular flat faces of edges a lie a^2 / 8 below the sphere on average; the volume loses three times as much
            self.assertLess(abs(volume / (4 * np.pi / 3) - 1), 3 / 8 * side ** 2 + 0.01)
            self.assertLess(np.linalg.norm(nodes, axis=1).max(), 1 + 0.05 * side)
            found = angles(nodes, mesh)
            self.assertGreater(found.min(), 10.7)  # the bounds that are proven for flat surfaces
            self.assertLess(found.max(), 164.8)

    def test_holes_double_triangles_and_orientation_do_no_harm(self):
        points, triangles = sphere()
        whole = self.mesh(points, triangles, "--size", "0.2")[2]
        low = points[triangles][:, :, 2].max(axis=1) < -0.95  # a hole at the bottom, 0.3 wide
        torn = np.concatenate([triangles[~low], triangles[100:103]])
        _, _, volume, said = self.mesh(points, torn, "--size", "0.2")
        self.assertLess(abs(volume / whole - 1), 0.03)
        self.assertIn(" 48 open edges", said)
        self.assertNotIn(" 0 edges of three", said)
        self.assertAlmostEqual(self.mesh(points, triangles[:, ::-1], "--size", "0.2")[2], whole, places=9)

    def test_scale_and_parts(self):
        points, triangles = box()
        nodes, _, volume, _ = self.mesh(points, triangles, "--size", "0.05", "--scale", "0.5")
        self.assertLess(abs(volume / 0.25 - 1), 0.05)
        self.assertLess(np.abs(nodes - np.clip(nodes, 0, [1, 0.5, 0.5])).max(), 1e-9)
        two = np.concatenate([points, points + [0, 3, 0], 0.1 * points + [0, 0, 3]])
        said = self.mesh(two, np.concatenate([triangles, triangles + 8, triangles + 16]), "--size", "0.1")[3]
        self.assertIn("2 parts, volume", said)
        self.assertIn("dropped: 1 parts of less than 1 % of the volume", said)

    def test_what_cannot_be_meshed_is_named(self):
        points, triangles = box()
        twice = np.concatenate([triangles, triangles[:1]])
        for options, triangles_there, message in (
                (["--keep-surface"], triangles[1:], "not closed: 3 open edges (of one triangle) and 0 of three"),
                (["--keep-surface"], twice, "not closed: 0 open edges (of one triangle) and 3 of three"),
                ([], triangles[:2], "nothing lies inside the surface"),
                ([], triangles[:0], "no triangles in"),
                (["--size", "0.001"], triangles, "finer than 1/200 of the surface"),
                (["--size", "-1"], triangles, "--size must be > 0"),
                (["--tets", "10", "--size", "1"], triangles, "--tets goes neither with --size nor with --keep-surface")):
            done, out = self.run_script(points, triangles_there, *options)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(message, done.stderr)
            self.assertNotIn("Traceback", done.stderr)
            self.assertFalse(out.exists())

    @unittest.skipUnless(shutil.which("tetgen"), "no TetGen here")
    def test_tetgen_keeps_the_surface(self):
        points, triangles = sphere(12)
        nodes, tets, volume, _ = self.mesh(points, triangles, "--keep-surface", "--size", "0.4")
        exact = np.linalg.det(points[triangles]).sum() / 6
        self.assertAlmostEqual(volume / exact, 1, places=9)
        faces = np.sort(np.concatenate([np.delete(tets, k, axis=1) for k in range(4)]), axis=1)
        counts = np.unique(faces, axis=0, return_counts=True)[1]
        self.assertEqual((counts == 1).sum(), len(triangles))
        self.assertEqual(len(self.run_script(points, triangles, "--keep-surface", "--coarsen", "200")[0].stderr), 0)


if __name__ == "__main__":
    unittest.main()
