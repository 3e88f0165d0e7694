#!/usr/bin/python3
"""scripts/convex_pieces: the pieces are convex, cover the surface and keep its holes open; the program reads them."""
import os
import subprocess
import unittest

import h5py
import numpy as np

from unibody_runs import ProgramTest

TOOL = os.environ.get("UNIBODY_CONVEX_PIECES", "")
# An L of two blocks, 1 x 1 x 3 and 1 x 1 x 1 m.
ANGLE = """v 0 0 0\nv 2 0 0\nv 2 0 1\nv 1 0 1\nv 1 0 3\nv 0 0 3\nv 0 1 0\nv 2 1 0\nv 2 1 1\nv 1 1 1\nv 1 1 3\nv 0 1 3
f 1 2 3 4\nf 1 4 5 6\nf 10 9 8 7\nf 12 11 10 7\nf 1 7 8 2\nf 2 8 9 3\nf 3 9 10 4\nf 4 10 11 5\nf 5 11 12 6\nf 6 12 7 1\n"""


def torus(around, across, radius=0.1, tube=0.03):
    u, v = np.meshgrid(2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(across) / across, indexing="ij")
    nodes = np.stack([(radius + tube * np.cos(v)) * np.cos(u), (radius + tube * np.cos(v)) * np.sin(u), tube * np.sin(v)], -1).reshape(-1, 3)
    faces = [[(i + x) % around * across + (j + y) % across for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
             for i in range(around) for j in range(across)]
    text = "".join("v %.9g %.9g %.9g\n" % tuple(x) for x in nodes)
    return nodes, text + "".join(f"f {a + 1} {b + 1} {c + 1}\nf {a + 1} {c + 1} {d + 1}\n" for a, b, c, d in faces)


def pieces_of(path):
    """Of each object its nodes, and of its faces the outward unit normals and their distances from the origin."""
    nodes, pieces = [], []
    for line in path.read_text(encoding="ascii").splitlines():
        kind, *words = line.split()
        if kind == "o":
            pieces.append(([], []))
        elif kind == "v":
            nodes.append([float(word) for word in words])
            pieces[-1][0].append(nodes[-1])
        elif kind == "f":
            a, b, c = (np.array(nodes[int(word) - 1]) for word in words[:3])
            normal = np.cross(b - a, c - a)
            pieces[-1][1].append([*(normal / np.linalg.norm(normal)), a @ normal / np.linalg.norm(normal)])
    return [(np.array(nodes), np.array(planes)) for nodes, planes in pieces]


def beyond(planes, points):
    """m, by how much each point is outside of the solid behind the planes; negative inside."""
    return (points @ planes[:, :3].T - planes[:, 3]).max(1)


@unittest.skipUnless(TOOL, "the tool needs HACD, of Bullet's extra libraries")
class ConvexPieces(ProgramTest):
    def decompose(self, text, *options, code=0, name="surface.obj", out="pieces.obj"):
        (self.folder / name).write_text(text, encoding="ascii")
        done = subprocess.run([TOOL, str(self.folder / name), str(self.folder / out), *options], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stderr if code else pieces_of(self.folder / out)

    def test_two_blocks(self):
        pieces = self.decompose(ANGLE)
        self.assertEqual(len(pieces), 2)
        scene = "bodies: [{shape: {compound: {mesh: surface.obj, pieces_file: pieces.obj}}, density: 1000}]\ntime: {frames: 1}\n"
        self.good(self.scene(scene), "run")
        with h5py.File(self.folder / "run/frames.h5") as file:
            self.assertAlmostEqual(file["bodies/mass"][0], 4000, delta=1e-6)
            parts = file["shapes/compound_0/parts"][:]
            self.assertEqual(len(parts), 2)

    def test_pieces_are_convex_and_cover_the_surface(self):
        nodes, text = torus(48, 24)
        for concavity, least in (("0.1", 3), ("0.02", 8)):  # the hollow of a ring's hull is deeper than a tenth, of a third's no more
            with self.subTest(concavity=concavity):
                pieces = self.decompose(text, "--concavity", concavity)
                self.assertGreaterEqual(len(pieces), least)
                outside = np.full(len(nodes), np.inf)
                for corners, planes in pieces:
                    self.assertLess(beyond(planes, corners).max(), 1e-6)
                    outside = np.minimum(outside, beyond(planes, nodes))
                    self.assertGreater(beyond(planes, np.zeros((1, 3)))[0], 0.03)  # the middle of the hole is free
                self.assertLess(outside.max(), 0.02 * 0.38)  # pieces of few corners cut less than a fiftieth of the diagonal off

    def test_a_ball_falls_through_the_hole(self):
        """A ball of 4 cm through a ring that is 14 cm wide inside, which does not move."""
        _, text = torus(48, 24)
        self.decompose(text)
        self.good(self.scene("""
            time: {frame: 0.01, frames: 30}
            bodies:
              - {shape: {compound: {mesh: surface.obj, pieces_file: pieces.obj}}, motion: fixed}
              - {shape: {sphere: {radius: 0.04}}, mass: 1, position: [0, 0, 0.2]}
              - {shape: {sphere: {radius: 0.04}}, mass: 1, position: [0.1, 0, 0.2]}
        """), "run")
        with h5py.File(self.folder / "run/frames.h5") as file:
            heights = file["frames/000030/position"][:, 2]
        self.assertAlmostEqual(heights[1], 0.2 - 9.81 * 0.3**2 / 2, delta=9.81 * 0.3 * 0.01)  # free fall, by steps of 0.01 s
        self.assertGreater(heights[2], heights[1] + 0.05)  # the ring held this one up

    def test_refusals(self):
        self.assertIn("edges at holes", self.decompose(ANGLE[:ANGLE.rindex("f")], code=2))
        self.assertIn("does not end in .obj", self.decompose(ANGLE, code=2, out="pieces.stl"))
        self.assertIn("--concavity '-1'", self.decompose(ANGLE, "--concavity", "-1", code=2))
        self.assertIn("unknown option '--bogus'", self.decompose(ANGLE, "--bogus", code=2))
        self.assertFalse((self.folder / "pieces.obj").exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
