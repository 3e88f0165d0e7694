#!/usr/bin/python3
"""States that stop being finite, or leave what can be computed with, while a scene runs."""
import shutil
import unittest

import h5py

from unibody_runs import ProgramTest, contents, unibody

GOOD = """\
title: a ball on the ground
time: {frames: 5}
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - shape: {sphere: {radius: 0.1}}
    mass: 1
    position: [0, 0, 0.3]
"""


class ImpossibleStates(ProgramTest):
    """A state that stops being finite while running: exit code 3, who and when, and the last checkpoint is whole."""

    def stops(self, text, *options, says=(), ranks=2):
        scene = self.scene(text)
        for n in (1, ranks):
            output = self.folder / f"results_{n}"
            run = unibody(scene, "-output", output, *options, ranks=n, timeout=60)
            self.assertEqual(run.code, 3, run.err + run.out)
            self.assertEqual(len(run.message), 1, run.err)
            for words in says:
                self.assertIn(words, run.message[0])
            self.assertIsNone(run.state)
            self.assertFalse((output / "summary.json").exists(), "there is no result to sum up")
        self.assertEqual(contents(self.folder / f"results_{ranks}/report.csv").count(b"\n"),
                         contents(self.folder / "results_1/report.csv").count(b"\n"))
        return run

    def test_a_force_too_large(self):
        self.stops(GOOD.replace("mass: 1", "mass: 1\n    name: ball\n    force: [1.0e308, 0, 0]").replace("mass: 1", "mass: 0.001"),
                   says=["frame 1", "body 1", "ball", "no constraint"])

    def test_beyond_all_places_and_speeds(self):
        """Finite, but nothing that a run is meant to come to."""
        for force, says in (("3.0e12", "faster than light"), ("3.0e40", "from the origin")):
            self.stops(GOOD.replace("mass: 1", f"mass: 1\n    name: ball\n    force: [{force}, 0, 0]"), says=["frame 1", "body 1 (ball)", says])
            shutil.rmtree(self.folder / "results_1"), shutil.rmtree(self.folder / "results_2")

    def test_a_report_that_overflows(self):
        """The state is finite, and its energy is not."""
        self.stops(GOOD.replace("mass: 1", "mass: 1.0e308\n    velocity: [0, 0, 100]"),
                   says=["frame 1", "the report's kinetic_energy (J)", "no longer finite"])

    PILE = """\
time: {frames: 40, substeps: 2}
output: {checkpoint_every: 1}
bodies:
  - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}
  - name: crate
    lattice: {count: 20, columns: [2, 2], spacing: [0.3, 0.3, 0.21], height: 0.1}
    shape: {box: {size: [0.2, 0.2, 0.2]}}
    mass: 1
  - {name: ram, shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 0.05, position: [0.5, 3, 0.1], force: FORCE}
"""

    def test_in_contact(self):
        self.stops(self.PILE.replace("FORCE", "[0, 1.0e308, 0]"),
                   says=["frame ", "body 21 (ram)", "contact with body 0 (ground)"])

    def test_in_a_cloth(self):
        self.stops("""
            wind: [1.0e200, 0, 0]
            cloths:
              - {name: sheet, grid: {size: [1, 1], nodes: [5, 5]}, mass: 1, thickness: 0.01, drag: 1, pins: [{node: [0, 0]}]}
            """, says=["frame ", "body 0 (sheet", "constraint: distance with body 1 (sheet"])

    def test_in_a_joint(self):
        self.stops("""
            bodies:
              - {name: arm, shape: {box: {size: [0.2, 0.1, 0.1]}}, mass: 0.001, position: [0.1, 0, 0], force: [1.0e308, 0, 0]}
            joints: [{type: ball, bodies: [arm, world], anchor: [0, 0, 0]}]
            """, says=["frame 1: ", "body 0 (arm)", "constraint: joint 0 (ball)"])

    def test_the_last_checkpoint_is_kept(self):
        """It is whole: from there the same happens again."""
        text = self.PILE.replace("FORCE", "[0, 0, 4.5e8]").replace("3, 0.1]", "3, 5]").replace("mass: 0.05", "mass: 1")
        run = self.stops(text, "-set", "time.frame=0.25", says=["frame ", "body 21 (ram)", "constraint"])
        frame = int(run.message[0].split("frame ")[1].split(",")[0].split(":")[0])
        self.assertGreater(frame, 1)
        for n in (1, 2):
            checkpoint = self.folder / f"results_{n}" / "checkpoint.h5"
            with h5py.File(checkpoint, "r") as file:
                self.assertEqual(file.attrs["frame"], frame - 1)
            self.assertFalse(checkpoint.with_suffix(".h5.part").exists())
            again = unibody(self.folder / "scene.yaml", "-output", self.folder / f"again_{n}", "-restart", checkpoint,
                            "-set", "time.frame=0.25", ranks=3 - n)
            self.assertEqual((again.code, again.message), (3, run.message))

    # A body that is nowhere must not be looked for contacts: this ended never.
    def test_from_one_step_to_the_next(self):
        text = self.PILE.replace("FORCE", "[0, 0, -1.0e9]").replace("mass: 0.05", "mass: 1.0e-300")
        self.stops(text, says=["frame 1, step 1 of 2: ", "body 21 (ram)"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
