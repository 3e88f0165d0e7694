#!/usr/bin/python3
"""contacts.h5 and contacts.xdmf: the forces by which bodies move, the same bytes on any number of ranks, and through a restart."""
import os
import subprocess
import unittest
from xml.etree import ElementTree

import h5py
import numpy as np

from unibody_runs import ProgramTest, contents, report

SCENE = """
    time: {frame: 0.008, frames: 40, substeps: 2}
    output: {every: 0, contacts: 4, checkpoint_every: 10}
    materials: {stone: {friction: 0.4, restitution: 0.3}}
    bodies:
      - {name: walls, container: {size: [1, 1]}}
      - pile:
          count: 60
          columns: [3, 3]
          mix:
            - {shape: {sphere: {radius: 0.08}}, scale: [0.6, 1.4]}
            - {shape: {box: {size: [0.2, 0.15, 0.1]}}, scale: [0.5, 1.2]}
        density: 2600
        position: [0, 0, 0.2]
        velocity: [0, 0, -1]
    cloths:
      - {name: cloth, grid: {size: [0.5, 0.5], nodes: [9, 9]}, mass: 0.3, thickness: 0.01, position: [0, 0, 0.02]}
    probes:
      - {name: floor, force: {on: 'walls[0]'}}
      - {name: cloth, force: {on: cloth}}
"""


class Contacts(ProgramTest):
    def arrays(self, name):
        """Of each frame its time and arrays."""
        with h5py.File(self.folder / name / "contacts.h5") as file:
            return {int(n): (frame.attrs["time"], {key: frame[key][:] for key in frame}) for n, frame in file["frames"].items()}

    def test_forces_are_those_that_the_probes_tell(self):
        self.good(self.scene(SCENE), "run", "-set", "time.substeps=1", "-set", "output.contacts=1")
        header, rows = report(self.folder / "run/report.csv")
        frames = self.arrays("run")
        self.assertEqual(sorted(frames), list(range(1, 41)))
        most = 0
        for number, (time, arrays) in frames.items():
            row = dict(zip(header, rows[number - 1]))
            self.assertEqual(time, float(row["time (s)"]))
            forces, ids, shares = arrays["force"], arrays["ids"], arrays["shares"]
            np.testing.assert_allclose(arrays["normal_force"], (forces * arrays["normal"]).sum(axis=1), rtol=1e-12, atol=1e-12)
            np.testing.assert_allclose(np.where(shares > 0, shares, 0).sum(axis=1), 1, rtol=1e-12)
            np.testing.assert_allclose(shares.sum(axis=1), 0, atol=1e-12)
            self.assertEqual(arrays["lines"].ravel().tolist(), list(range(2 * len(ids))))
            sliding = np.linalg.norm(forces - arrays["normal_force"][:, None] * arrays["normal"], axis=1)
            scale = 1 + np.abs(forces).sum()
            self.assertLess((sliding - arrays["friction"] * arrays["normal_force"]).max(initial=0), 1e-6 * scale)
            for probe, of in (("floor", ids == 0), ("cloth", ids >= 65)):
                told = [float(row[f"{probe}_force_{axis} (N)"]) for axis in "xyz"]
                found = (np.where(of, shares, 0).sum(axis=1)[:, None] * forces).sum(axis=0)
                np.testing.assert_allclose(found, told, atol=1e-9 * scale)
                most = max(most, abs(found[2]))
        self.assertGreater(most, 100)
        # Of the bodies: each pair that pushes counts for both; grains of a pile touch some, and their stress is one of compression.
        arrays = frames[40][1]
        pairs = {tuple(ids[:2]) for ids in arrays["ids"] if 0 <= ids[0] < 65 and 0 <= ids[1] < 65}
        for body, coordination in zip(arrays["body_ids"], arrays["coordination"], strict=True):
            self.assertEqual(coordination, sum(body in pair for pair in pairs))
        self.assertTrue(set(arrays["body_ids"]) <= set(range(5, 65)) and len(arrays["body_ids"]) > 10)
        self.assertGreater(arrays["body_stress"][:, :3].sum(), 0)
        self.assertTrue((frames[40][1]["ids"] >= 65).any(), "nothing touches the cloth")

    def test_the_same_bytes_on_any_number_of_ranks_and_through_a_restart(self):
        scene = self.scene(SCENE)
        one = self.good(scene, "on_1", ranks=1)
        for ranks in (2, 3):
            with self.subTest(ranks=ranks):
                self.assertEqual(self.good(scene, f"on_{ranks}", "-partition", "random:5", ranks=ranks).state, one.state)
                for name in ("contacts.h5", "contacts.xdmf"):
                    self.assertEqual(contents(self.folder / f"on_{ranks}" / name), contents(self.folder / "on_1" / name))
        self.good(scene, "part", "-set", "time.frames=24")
        self.assertEqual(self.good(scene, "part", "-restart", "auto").state, one.state)
        self.assertEqual(contents(self.folder / "part/contacts.xdmf"), contents(self.folder / "on_1/contacts.xdmf"))
        part, straight = self.arrays("part"), self.arrays("on_1")
        self.assertEqual(sorted(part), list(range(4, 41, 4)))
        for number, (time, arrays) in straight.items():
            self.assertEqual(part[number][0], time)
            for key, values in arrays.items():
                np.testing.assert_array_equal(part[number][1][key], values)

    def test_readers_of_xdmf_find_every_array(self):
        self.good(self.scene(SCENE), "run")
        path = self.folder / "run/contacts.xdmf"
        frames = {number: values for number, values in self.arrays("run").items() if len(values[1]["ids"]) > 0}
        grids = ElementTree.parse(path).getroot().findall("./Domain/Grid/Grid")
        self.assertEqual([float(grid.find("Time").get("Value")) for grid in grids], [time for time, _ in frames.values()])
        with h5py.File(self.folder / "run/contacts.h5") as file:
            for item in (item for grid in grids for item in grid.iter("DataItem")):
                name, place = item.text.strip().split(":")
                self.assertEqual(name, "contacts.h5")
                self.assertEqual(file[place].shape, tuple(int(n) for n in item.get("Dimensions").split()), place)
        if not os.environ.get("UNIBODY_XDMF_POINTS"):
            self.skipTest("built without the XDMF library")
        done = subprocess.run([os.environ["UNIBODY_XDMF_POINTS"], path], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        read = [[float(word) for word in line.split()] for line in done.stdout.splitlines()]
        for grid, (time, arrays) in zip(read, frames.values(), strict=True):
            self.assertEqual(grid[:2], [time, len(arrays["ids"])])
            np.testing.assert_array_equal(np.reshape(grid[2:], (-1, 3)), arrays["places"])

    def test_nothing_is_written_unasked(self):
        self.good(self.scene(SCENE), "run", "-set", "output.contacts=0")
        self.assertFalse((self.folder / "run/contacts.h5").exists())


if __name__ == "__main__":
    unittest.main()
