#!/usr/bin/python3
"""A run that ends when a column of its report passes a value: at the frame of free fall, on any number of ranks, and restarted."""
import json
import unittest

import h5py

from unibody_runs import ProgramTest, report, unibody

# After n frames a body of 2 kg that falls from rest has the speed 10 * 0.01 n.
FALL = """
    time: {frame: 0.01, frames: 100}
    gravity: [0, 0, -10]
    output: {every: 5, checkpoint_every: 0}
    bodies:
      - {name: a, shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, 100]}
      - {name: b, shape: {sphere: {radius: 0.1}}, mass: 2, position: [5, 0, 100], velocity: [0, 0, 1]}
    probes:
      - {name: gate, of: a, flow: {point: [0, 0, 99.8], normal: [0, 0, -1]}}
    events:
      - {do: end, when: {column: WHAT}}
"""


class Events(ProgramTest):
    def ended(self, name, frame, told):
        summary = json.loads((self.folder / name / "summary.json").read_text())
        self.assertEqual((summary["last_frame"], summary["status"]), (frame, "ended by the scene: " + told))
        self.assertEqual(float(report(self.folder / name / "report.csv")[1][-1][0]), frame)
        with h5py.File(self.folder / name / "checkpoint.h5") as file:
            self.assertEqual(file.attrs["frame"], frame)

    def test_the_frame_is_that_of_free_fall(self):
        # Of both: v_a = 0.1 n, v_b = 0.1 n - 1; their energy is 0.01 n^2 + (0.1 n - 1)^2, least at n = 5, and 1 at 0 and 10.
        for what, frame, told in (
                ("kinetic_energy, above: 1.1", 11, "kinetic_energy is above 1.1"),
                ("'kinetic_energy (J)', below: 0.521", 4, "kinetic_energy (J) is below 0.521"),
                ("kinetic_energy, below: 0.9, after: 0.045", 5, "kinetic_energy is below 0.9"),
                # 0.001 n (n + 1) / 2 m after n frames, past 0.2 m in the 20th.
                ("gate_count, above: 0.5", 20, "gate_count is above 0.5")):
            with self.subTest(what):
                scene = self.scene(FALL.replace("WHAT", what))
                states = set()
                for ranks in (1, 2, 3):
                    run = self.good(scene, "run", "-overwrite", ranks=ranks)
                    self.ended("run", frame, told)
                    self.assertIn(f"ended by the scene: {told}, after frame {frame}", run.out)
                    states.add(run.state)
                self.assertEqual(len(states), 1)

    def test_a_restart_ends_there_too(self):
        scene = self.scene(FALL.replace("WHAT", "kinetic_energy, above: 1.1"))
        straight = self.good(scene, "straight")
        self.good(scene, "part", "-set", "time.frames=7")
        self.assertEqual(self.good(scene, "part", "-restart", "auto").state, straight.state)
        self.ended("part", 11, "kinetic_energy is above 1.1")

    def test_without_the_event_it_goes_on(self):
        self.good(self.scene(FALL.replace("WHAT", "kinetic_energy, above: 1.0e+9")), "run")
        self.assertEqual(json.loads((self.folder / "run/summary.json").read_text())["last_frame"], 100)

    def test_bad_events(self):
        column = "expected a column of report.csv that is the same on any machine, as kinetic_energy"
        for what, message in (
                ("kinetic_enegy, above: 1", f"when.column': found kinetic_enegy (did you mean kinetic_energy?), {column}"),
                ("wall_solve, above: 1", f"when.column': found wall_solve, {column}"),
                ("kinetic_energy", "when.below': found nothing, expected a number, or above: one"),
                ("kinetic_energy, above: 1, below: 2", "when.above': found above beside below, expected only one of below and above"),
                ("kinetic_energy, above: much", "when.above': found much, expected a finite number (in the unit of the column)"),
                ("kinetic_energy, above: 1, after: -1", "when.after': found -1, expected a number >= 0 (s)")):
            for check in ((), ("-check",)):
                with self.subTest(what, check=check):
                    scene = self.scene(FALL.replace("WHAT", what))
                    run = unibody(scene, "-output", self.folder / "bad", *check)
                    self.assertEqual((run.code, len(run.message)), (2, 1), run.err)
                    self.assertIn(f"scene.yaml:11: key 'events[0].{message}", run.message[0])
                    self.assertFalse((self.folder / "bad").exists())


if __name__ == "__main__":
    unittest.main()
