#!/usr/bin/python3
"""The tool that tells how far two runs are apart, on states that are known: free flight in steps of two lengths, whose difference
has a closed form, and files in which one body was moved by hand."""
import csv
import io
import math
import shutil
import unittest

import h5py
import numpy as np

from unibody_runs import SOURCE, ProgramTest, execute

TOOL = SOURCE / "scripts" / "trajectory_error"
STEP, GRAVITY, SPIN = 0.02, 9.81, 3.0

# Far apart, in free flight: body 1 spins about a principal axis. Body 0 has no mass and never counts.
FLIGHT = f"""
    time: {{frame: {STEP}, frames: 10}}
    output: {{every: 2}}
    gravity: [0, 0, -{GRAVITY}]
    bodies:
      - {{shape: {{box: {{size: [1, 1, 1]}}}}, motion: kinematic, velocity: [1, 0, 0], position: [0, 0, -50]}}
      - {{shape: {{box: {{size: [0.2, 0.3, 0.4]}}}}, mass: 2, angular_velocity: [0, 0, {SPIN}], velocity: [1, 2, 3]}}
      - {{shape: {{sphere: {{radius: 0.1}}}}, mass: 1, position: [9, 0, 0]}}
      - {{shape: {{sphere: {{radius: 0.1}}}}, mass: 5, position: [0, 9, 0]}}
"""


class TrajectoryErrorTest(ProgramTest):
    def compare(self, a, b, *options):
        run = execute([str(TOOL), str(self.folder / a), str(self.folder / b), *options], timeout=60)
        self.assertEqual(run.code, 0, run.err)
        lines = list(csv.reader(io.StringIO(run.out)))
        self.assertEqual(lines[0], ["frame", "time (s)", "rms (m)", "max (m)", "worst", "turn_rms (rad)", "turn_max (rad)", "distance (m)"])
        return [list(map(float, line)) for line in lines[1:]]

    def refused(self, a, b, *options, says):
        run = execute([str(TOOL), str(self.folder / a), str(self.folder / b), *options], timeout=60)
        self.assertEqual((run.code, run.out), (2, ""))
        self.assertEqual(len(run.err.splitlines()), 1, run.err)
        self.assertIn(says, run.err)

    def copy(self, name, to, change):
        """A copy of a run's frames, changed by hand."""
        (self.folder / to).mkdir()
        shutil.copy(self.folder / name / "frames.h5", self.folder / to / "frames.h5")
        with h5py.File(self.folder / to / "frames.h5", "r+") as file:
            change(file)

    def test_a_run_and_itself(self):
        self.good(self.scene(FLIGHT), "one", ranks=1)
        rows = self.compare("one", "one/frames.h5")
        self.assertEqual([row[0] for row in rows], [0, 2, 4, 6, 8, 10])
        for row in rows:
            self.assertAlmostEqual(row[1], STEP * row[0], delta=1e-12)
            self.assertEqual(row[2:4] + row[5:], [0] * 5)

    def test_free_flight_in_finer_steps(self):
        """Falling by g (T^2 + T h) / 2 in steps h, and turning by 2 atan(h w / 2) in each of them."""
        scene = self.scene(FLIGHT)
        self.good(scene, "coarse", ranks=1)
        self.good(scene, "fine", "-set", "time.substeps=8", ranks=1)
        for row in self.compare("coarse", "fine"):
            time, steps = STEP * row[0], row[0]
            drop = GRAVITY * time * (STEP - STEP / 8) / 2
            turn = abs(2 * steps * math.atan(STEP * SPIN / 2) - 2 * 8 * steps * math.atan(STEP * SPIN / 16))
            inertia = 2 * (0.2**2 + 0.3**2) / 12
            np.testing.assert_allclose(row[2:4] + row[5:], [drop, drop, turn / math.sqrt(3), turn,
                                                            math.sqrt((8 * drop**2 + inertia * turn**2) / 8)], rtol=1e-7, atol=1e-12)

    def test_frames_by_time(self):
        scene = self.scene(FLIGHT)
        self.good(scene, "coarse", ranks=1)
        self.good(scene, "fine", "-set", f"time.frame={STEP / 4}", "-set", "time.frames=40", "-set", "output.every=4", ranks=1)
        rows = self.compare("coarse", "fine", "--by-time")
        self.assertEqual([row[0] for row in rows], [0, 2, 4, 6, 8, 10])
        for row in rows:
            self.assertAlmostEqual(row[3], GRAVITY * STEP * row[0] * STEP * 3 / 8, delta=1e-12)
        self.refused("coarse", "fine", says="frame 4 is at 0.08 s and at 0.02 s (--by-time?)")

    def test_a_file_with_one_body_moved_and_others_in_another_order(self):
        self.good(self.scene(FLIGHT), "one", ranks=1)
        quarter = np.array([math.cos(math.pi / 8), 0, math.sin(math.pi / 8), 0])

        def move(file):
            order = [3, 1, 0, 2]
            for name in file["bodies"]:
                file["bodies"][name][...] = file["bodies"][name][()][order]
            for frame in file["frames"].values():
                for name in frame:
                    frame[name][...] = frame[name][()][order]
            last = file["frames/000010"]
            last["position"][3] += [0.3, 0, -0.4]  # body 2
            last["position"][2] += 100  # body 0, which has no mass
            last["orientation"][0] = -quarter  # body 3, whose inertia is 2/5 m r^2, turned by pi/4

        self.copy("one", "other", move)
        rows = self.compare("one", "other")
        for row in rows[:-1]:
            self.assertEqual(row[2:4] + row[5:], [0] * 5)
        energy = 1 * 0.25 + 0.4 * 5 * 0.01 * (math.pi / 4)**2
        np.testing.assert_allclose(rows[-1][2:], [0.5 / math.sqrt(3), 0.5, 2, math.pi / 4 / math.sqrt(3), math.pi / 4,
                                                  math.sqrt(energy / 8)], rtol=1e-7)
        self.assertEqual(self.compare("one", "other", "--frames", "last"), rows[-1:])
        self.assertEqual(self.compare("one", "other", "--frames", "4"), rows[2:3])

    def test_what_it_refuses(self):
        self.good(self.scene(FLIGHT), "one", ranks=1)
        self.good(self.scene(FLIGHT + "      - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 9]}\n"), "more", ranks=1)
        self.refused("one", "more", says="not of the same bodies: 4 and 5, 1 of them in one alone")
        self.refused("one", "nowhere", says="nowhere")
        self.refused("one", "one", "--frames", "3", says="found --frames 3")


if __name__ == "__main__":
    unittest.main(verbosity=2)
