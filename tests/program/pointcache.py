#!/usr/bin/python3
"""scripts/pointcache: the caches have the places of frames.h5, in the order of their meshes, at the times that their heads say."""
import struct
import subprocess
import unittest

import h5py
import numpy as np

from unibody_runs import SOURCE, ProgramTest

SCENE = """
    time: {frame: 0.02, frames: 10}
    output: {every: 2}
    bodies:
      - {shape: {sphere: {radius: 0.3}}, motion: fixed, position: [0, 0, -0.5]}
    cloths: [{name: sheet, grid: {size: [1, 1], nodes: [4, 5]}, mass: 1, thickness: 0.01, velocity: [1, 0, 0]}]
    threads: [{name: "../rope", points: [[0, -5, 0], [1, -5, 0]], segments: 5, radius: 0.01, mass: 0.1}]
    solids: [{block: {size: [0.6, 0.5, 0.9], cells: [2, 2, 3]}, density: 800, youngs_modulus: 1.0e+5, poissons_ratio: 0.3, thickness: 0.01, position: [3, 0, 0]}]
"""
NAMES = ("000_sheet", "001__rope", "002_solids_0_")


class PointCache(ProgramTest):
    def pointcache(self, name, *options, code=0):
        done = subprocess.run([str(SOURCE / "scripts/pointcache"), str(self.folder / name), *options], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stderr if code else done.stdout

    def run_of(self, text=SCENE):
        self.good(self.scene(text), "run")
        file = h5py.File(self.folder / "run/frames.h5")
        frames = [file["frames"][name] for name in sorted(file["frames"])]
        return file, np.array([f.attrs["time"] for f in frames]), np.array([f["position"][:] for f in frames])

    def mesh(self, path):
        lines = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
        return (np.array([[float(x) for x in line[1:]] for line in lines if line[0] == "v"]),
                np.array([[int(x) - 1 for x in line[1:]] for line in lines if line[0] in "fl"]))

    def test_places_and_meshes(self):
        file, times, places = self.run_of()
        self.pointcache("run")
        self.pointcache("run", "--format", "mdd")
        caches = self.folder / "run/caches"
        names = sorted({path.stem for path in caches.iterdir()})
        self.assertEqual(len(names), 3)
        self.assertEqual(tuple(names[:2]), NAMES[:2])
        for number, name in enumerate(names):
            cells = file[f"surfaces/00000{number}/cells"][:]
            points, corners = self.mesh(caches / f"{name}.obj")
            self.assertTrue(np.allclose(points[corners], places[0][cells], atol=1e-8), name)
            expected = places[:, np.unique(cells)].astype("f4")
            self.assertGreater(np.abs(expected[-1] - expected[0]).max(), 0.1)  # it moves
            data = (caches / f"{name}.pc2").read_bytes()
            self.assertEqual(struct.unpack("<12sii", data[:20]), (b"POINTCACHE2\0", 1, len(points)))
            start, step, samples = struct.unpack("<ffi", data[20:32])
            self.assertEqual((start, samples), (0, 6))
            self.assertAlmostEqual(step, 24 * 0.04, places=6)
            self.assertTrue((np.frombuffer(data[32:], "<f4").reshape(expected.shape) == expected).all(), name)
            data = (caches / f"{name}.mdd").read_bytes()
            self.assertEqual(struct.unpack(">ii", data[:8]), (6, len(points)))
            self.assertTrue((np.frombuffer(data[8:32], ">f4") == times.astype("f4")).all())
            self.assertTrue((np.frombuffer(data[32:], ">f4").reshape(expected.shape) == expected).all(), name)

    def test_refusals(self):
        self.assertIn("cannot read frames", self.pointcache("nothing", code=1))
        self.run_of("""
            time: {frames: 2}
            bodies: [{shape: {sphere: {radius: 0.3}}, mass: 1}]
        """)
        self.assertIn("has no cloth, thread or solid", self.pointcache("run", code=1))
        self.assertIn("--fps 0, expected a number above 0", self.pointcache("run", "--fps", "0", code=1))
        self.good(self.scene(SCENE), "uneven")
        with h5py.File(self.folder / "uneven/frames.h5", "r+") as file:
            file["frames/000004"].attrs["time"] = 0.09
        self.assertIn("are 0.03 s to 0.05 s apart, expected all alike", self.pointcache("uneven", code=1))


if __name__ == "__main__":
    unittest.main(verbosity=2)
