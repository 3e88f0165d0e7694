#!/usr/bin/python3
"""Runs that ask for an accuracy: what they say of it, the same bits on any number of ranks and through a restart, -strict."""
import csv
import json
import unittest

from unibody_runs import ProgramTest, report, unibody

PILE = """
    time: {frame: 0.016, frames: 60}
    solver: {accuracy: film}
    output: {every: 0, checkpoint_every: 0}
    bodies:
      - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}
      - name: box
        pile: {count: 60, columns: [3, 3], seed: 5, mix: [{shape: {box: {size: [0.2, 0.16, 0.12]}}}]}
        density: 1000
        velocity: [0, 0, -2]
"""

# A chain hangs from its first link, and its last one weighs 200 times as much: many thousand iterations.
HEAVY = """
    time: {frame: 0.016, frames: 3}
    solver: {accuracy: reference, iterations: 60}
    output: {every: 0, checkpoint_every: -1}
    bodies:
      - name: chain
        shape: {box: {size: [0.09, 0.03, 0.03]}}
        mass: 0.1
        position: [0, 0, 4]
        chain: {count: 12, from: [0, 0, 0], to: [1.1, 0, 0], held: start, joint: {type: ball}, ball: {radius: 0.2, mass: 20}}
"""


class Accuracy(ProgramTest):
    def convergence(self, name):
        return json.loads((self.folder / name / "summary.json").read_text())["convergence"]

    def test_the_last_lines_are_what_the_report_says(self):
        scene = self.scene(PILE)
        run = self.good(scene, "run", ranks=1)
        with open(self.folder / "run/report.csv") as file:
            rows = list(csv.DictReader(file))
        allowed = 0.01 * 0.12
        offs = [max(float(row["estimated_error (m)"]), float(row["penetration_max (m)"])) for row in rows]
        held = sum(off <= allowed for off in offs)
        told = self.convergence("run")
        self.assertEqual((told["accuracy"], told["accuracy_asked"], told["frames_within_accuracy"]), (0.01, True, held))
        self.assertEqual(told["most_off (m)"], max(offs))
        self.assertEqual(told["most_off_frame"], 1 + offs.index(max(offs)))
        self.assertIn(f"accuracy 0.01 of the smallest moving body's size (1.20e-03 m) asked: held in "
                      f"{'all' if held == 60 else held} of 60 frames\n", run.out)
        self.assertIn("tolerance 0.0004 m for an accuracy of 0.01", run.out)
        self.assertGreater(held, 50)

    def test_a_number_is_what_its_name_means(self):
        scene = self.scene(PILE)
        named = self.good(scene, "named", "-set", "solver.accuracy=engineering", "-set", "time.frames=20").state
        self.assertEqual(self.good(scene, "number", "-set", "solver.accuracy=1e-3", "-set", "time.frames=20").state, named)
        self.assertNotEqual(self.good(scene, "film", "-set", "time.frames=20").state, named)

    def test_the_bits_are_those_of_any_ranks_and_of_a_run_in_parts(self):
        for solver in ("accelerated_jacobi", "gauss_seidel"):
            with self.subTest(solver):
                scene, chosen = self.scene(PILE), ["-set", f"solver.name={solver}", "-overwrite"]
                straight = self.good(scene, "one", *chosen, ranks=1)
                for ranks in (2, 3):
                    self.assertEqual(self.good(scene, "more", *chosen, ranks=ranks).state, straight.state)
                # The frame is no 25th one, and the steps before it were divided: what has been found must be in the checkpoint.
                self.good(scene, "part", *chosen, "-set", "time.frames=37", ranks=2)
                rest = unibody(scene, "-output", self.folder / "part", *chosen[:2], "-restart", "auto", ranks=3)
                self.assertEqual((rest.code, rest.state), (0, straight.state))
                self.assertEqual([row[3] for row in report(self.folder / "part/report.csv")[1]],
                                 [row[3] for row in report(self.folder / "one/report.csv")[1]])

    def test_what_is_not_held_is_said_and_stops_a_strict_run(self):
        scene = self.scene(HEAVY)
        run = self.good(scene, "run")
        self.assertEqual(self.convergence("run")["frames_within_accuracy"], 0)
        self.assertIn("asked: held in 0 of 3 frames\n", run.out)
        self.assertIn("in all of 3 frames the solve ended short of it", run.out)
        strict = unibody(scene, "-output", self.folder / "strict", "-strict")
        self.assertEqual(strict.code, 3)
        self.assertRegex(strict.err, r"option -strict: frame 1 has not converged: the error is estimated as \S+ m, the accuracy allows "
                                     r"a step 3.00e-07 m; farthest from solved: joints of chain")

    def test_what_doubles_cannot_tell_is_refused(self):
        scene = self.scene(PILE)
        for ranks in (1, 2):
            run = unibody(scene, "-output", self.folder / "none", "-set", "solver.accuracy=1e-13", ranks=ranks)
            self.assertEqual(run.code, 2)
            self.assertRegex(run.err, r"key 'solver.accuracy': found 1e-13, expected at least \S+e-1[23]: the smallest body that moves "
                                      r"measures 0.12 m, places reach \S+ m from the origin")
        self.assertFalse((self.folder / "none").exists())


if __name__ == "__main__":
    unittest.main()
