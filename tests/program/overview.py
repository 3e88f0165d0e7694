#!/usr/bin/python3
"""What a run tells before its first frame: the scene in numbers, and what in it is probably a mistake."""
import unittest

from unibody_runs import ProgramTest, unibody

SCENE = """
    title: some of each
    time: {frame: 0.01, frames: 20, substeps: 2}
    bodies:
      - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}
      - {name: paddle, shape: {box: {size: [1, 1, 1]}}, motion: kinematic, position: [5, 0, 2]}
      - {name: crate, shape: {box: {size: [0.2, 0.4, 0.6]}}, mass: 2, position: [0, 0, 0.3]}
      - {name: ball, shape: {sphere: {radius: 0.05}}, mass: 0.5, points: [[1, 0, 0.05], [2, 0, 0.05]]}
    threads:
      - {points: [[3, 0, 1], [4, 0, 1]], segments: 10, radius: 0.02, mass: 0.1}
    joints:
      - {type: ball, bodies: [crate, world], anchor: [0, 0, 0.6]}
"""


class Overview(ProgramTest):
    def check(self, text, *options, ranks=1, code=0):
        run = unibody(self.scene(text), "-check", "-output", self.folder / "none", *options, ranks=ranks)
        self.assertEqual(run.code, code, run.err)
        self.assertFalse((self.folder / "none").exists())
        return run

    def warnings(self, text, *options, ranks=1):
        prefix = "warning: "
        err = self.check(text, *options, ranks=ranks).err
        return [line[len(prefix):] for line in err.splitlines() if line.startswith(prefix)]

    def test_the_scene_in_numbers(self):
        for ranks in (1, 3):
            out = self.check(SCENE, ranks=ranks).out
            for line in ("scene.yaml: some of each",
                         "  bodies  3 dynamic (2 sphere, 1 box), 1 kinematic, 1 fixed; 11 nodes of cloths, threads and solids; 1 joint",
                         "  what moves  3.1 kg, from 0.04 m (thinnest) to 0.6 m (longest), between [-0.1, -0.2, 0] and [4.02, 0.2, 1.02] m",
                         f"  run  20 frames of 0.01 s, 2 steps each, on {ranks} rank{'s' if ranks > 1 else ''}; "):
                self.assertIn(line, out)
            self.assertIn("  plan  accelerated_jacobi, at most 50 iterations a step (up to 1000 iterations where they cost little), stages: position, tolerance ", out)
        self.assertEqual(self.warnings(SCENE), [])

    def test_a_coarse_level_where_there_is_something_for_it(self):
        cloth = "cloths: [{grid: {size: [1, 1], nodes: [9, 9]}, mass: 1, thickness: 0.01, links: {}}]"
        ball = "bodies: [{shape: {sphere: {radius: 1}}, mass: 1}]"
        coarse = ("-set", "solver.coarse=true")
        self.assertIn(", a coarse level of what touches nothing", self.check(cloth, *coarse).out)
        self.assertIn(", no coarse level, since there are no cloths, threads or solids", self.check(ball, *coarse).out)
        self.assertNotIn("coarse", self.check(cloth).out)

    def test_overlaps_at_the_start(self):
        text = """
            bodies:
              - {name: a, shape: {sphere: {radius: 0.1}}, mass: 1}
              - {name: b, shape: {sphere: {radius: 0.1}}, mass: 1, points: [[0.15, 0, 0], [0.345, 0, 0], [0.5449, 0, 0]]}
        """
        for ranks in (1, 2):
            self.assertEqual(self.warnings(text, ranks=ranks), [
                "2 pairs of bodies overlap at the start by more than 1 % of the smaller one's size, the deepest by 0.05 m: a (line 3) "
                "and b[0] (line 4); they will be pushed apart: move them, unless that is meant"])

    def test_bodies_behind_a_plane(self):
        text = """
            gravity: [0, 0, -9.81]
            bodies:
              - {name: silo, container: {size: [1, 1]}}
              - {name: bead, shape: {sphere: {radius: 0.05}}, mass: 1, points: [[0, 0, 0.2], [0.6, 0, 0.2], [0.8, 0, 0.5], [0, 0.44, 0.9]]}
              - {name: cellar, shape: {sphere: {radius: 0.05}}, mass: 1, position: [0.2, 0, -1]}
        """
        rule = "a plane is solid on the side that its normal leaves, and"
        for ranks in (1, 3):
            found = [w for w in self.warnings(text, ranks=ranks) if "behind" in w]
            self.assertEqual(found, [
                f"a body starts behind the plane silo[0] (line 4), cellar (line 6): {rule} it will be pushed out",
                f"2 bodies start behind the plane silo[2] (line 4), the first of them bead[1] (line 5): {rule} they will be pushed out"])

    def test_a_body_far_from_all_others(self):
        text = """
            bodies:
              - {shape: {plane: {normal: [0, 0, 1]}}}
              - {name: bead, lattice: {count: 400, columns: [10, 10], spacing: [0.1, 0.1, 0.1], height: 0.05}, shape: {sphere: {radius: 0.04}}, mass: 1}
              - {name: lost, shape: {sphere: {radius: 0.05}}, mass: 1, position: [AT, 0, 1]}
        """
        for ranks in (1, 3):
            found, = [w for w in self.warnings(text.replace("AT", "3000"), ranks=ranks) if "middle" in w]
            self.assertRegex(found, r"^lost \(line 5\) starts 2\.99e\+03 m from the middle of what moves, \d+ times as far as the mean: is its position meant\?$")
            self.assertEqual([w for w in self.warnings(text.replace("AT", "5"), ranks=ranks) if "middle" in w], [])

    def test_what_is_probably_another_unit_or_sign(self):
        ball = "bodies: [{shape: {sphere: {radius: %s}}, mass: 1}]"
        self.assertEqual(self.warnings("gravity: [0, 0, 9.81]\n" + ball % 1),
                         ["gravity points up (9.81 m/s^2 along z): most scenes have it along -z"])
        self.assertEqual(self.warnings(ball % 30),
                         ["all that moves is thicker than 50 m: lengths are in metres; are these in another unit?"])
        self.assertEqual(self.warnings("time: {frame: 0.0005}\n" + ball % 4e-5),
                         ["all that moves is smaller than 0.0001 m: lengths are in metres; are these in another unit?"])

    def test_steps_that_are_too_long(self):
        self.assertEqual(self.warnings("time: {frame: 0.1}\nbodies: [{shape: {sphere: {radius: 0.01}}, mass: 1}]"),
                         ["a step of 0.1 s lets a body fall by 0.0981 m, more than the smallest one's size of 0.02 m: more "
                          "time.substeps, or a shorter time.frame, would follow it"])

    def test_laws_without_effect(self):
        scene = """
            gravity: [0, 0, 0]
            materials: {{rubber: {{friction: 0.5, {law}}}, wood: {{friction: 0.5}}, dust: {{friction: 0.5, {law}}}}}
            bodies:
              - {{shape: {{{shape}}}, mass: 1, material: rubber}}
              - {{shape: {{box: {{size: [1, 1, 1]}}}}, motion: fixed, position: [3, 0, 0], material: {other}}}
              - {{shape: {{sphere: {{radius: 1}}}}, mass: 1, position: [9, 0, 0], material: dust}}
        """
        box, ball = "box: {size: [1, 1, 1]}", "sphere: {radius: 0.5}"
        for law, effect in (("elastic_modulus: 1.0e+3", "their contacts are rigid"),
                            ("surface_energy: 0.1", "they do not hold each other by it"),
                            ("liquid_volume: 1.0e-6", "no liquid bridges them")):
            with self.subTest(law=law):
                told = [f"{law.split(':')[0]} of rubber and rubber has no effect between two of their bodies neither of which is a sphere, "
                        f"a disc or a particle: its law needs a radius, and {effect}"]
                self.assertEqual(self.warnings(scene.format(law=law, shape=box, other="rubber"), ranks=2), told)
                self.assertEqual(self.warnings(scene.format(law=law, shape=box, other="wood")), [])  # the only one of its kind
                self.assertEqual(self.warnings(scene.format(law=law, shape=ball, other="rubber")), [])

    def test_ranks_without_work(self):
        self.assertEqual(self.warnings("bodies: [{shape: {sphere: {radius: 1}}, mass: 1}]", ranks=3),
                         ["3 ranks for 1 dynamic bodies: the others have nothing to do; fewer ranks are faster"])

    def test_strict_makes_a_warning_an_error(self):
        text = "gravity: [0, 0, 9.81]\nbodies: [{shape: {sphere: {radius: 1}}, mass: 1}]"
        run = self.check(text, "-strict", ranks=2, code=2)
        self.assertIn("option -strict: gravity points up (9.81 m/s^2 along z)", run.err)
        run = unibody(self.scene(text), "-strict", "-output", self.folder / "none")
        self.assertEqual(run.code, 2)
        self.assertFalse((self.folder / "none").exists())

    def test_a_run_tells_it_too(self):
        run = unibody(self.scene(SCENE), "-output", self.folder / "results")
        self.assertEqual(run.code, 0)
        self.assertIn("  bodies  3 dynamic (2 sphere, 1 box), 1 kinematic, 1 fixed;", run.out)


if __name__ == "__main__":
    unittest.main(verbosity=2)
