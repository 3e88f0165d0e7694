#!/usr/bin/python3
"""-continue_from: a scene starts with the bodies of another scene's checkpoint, by name and number."""
import json
import unittest

import h5py

from unibody_runs import ProgramTest, tree, unibody

HEAD = """
    time: {frame: 0.01, frames: FRAMES}
    output: {every: 1}
    materials: {steel: {friction: 0.4}, wood: {friction: 0.3}}
"""
BALLS = """
      - name: balls
        lattice: {count: 60, columns: [4, 4], spacing: [0.11, 0.11, 0.11], height: 0.06, jitter: 0.004}
        shape: {sphere: {radius: 0.05}}
        mass: 0.5
        material: steel
"""
BED = HEAD.replace("FRAMES", "120") + """
    bodies:
      - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}
      - {name: walls, container: {size: [0.5, 0.5]}}
""" + BALLS + """
      - {name: lid, shape: {box: {size: [0.1, 0.1, 0.1]}}, motion: fixed, position: [0, 0, 3]}
"""
PRESS = HEAD.replace("FRAMES", "40") + """
    bodies:
      - {name: plate, shape: {box: {size: [0.3, 0.3, 0.04]}}, mass: 3, position: [0, 0, 0.9], material: wood}
      - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}
      - {name: walls, container: {size: [0.5, 0.5]}}
""" + BALLS

FREE = """
    gravity: [0, 0, 0]
    time: {frame: 0.01, frames: 20}
    bodies:
      - name: rods
        lattice: {count: 12, columns: [3, 2], spacing: [1, 1, 1], height: 1, rotation_jitter: 1}
        shape: {box: {size: [0.4, 0.1, 0.1]}}
        mass: 1
        velocity: [1, 2, 3]
        angular_velocity: [1, -2, 0.5]
      - {name: arm, shape: {box: {size: [1, 0.1, 0.1]}}, motion: kinematic, position: [9, 0, 0], angular_velocity: [0, 0, 1]}
"""


def states(folder, frame, ids=slice(None)):
    with h5py.File(folder / "frames.h5") as file:
        group = file[f"frames/{frame:06d}"]
        return {name: group[name][:][ids] for name in ("position", "orientation", "velocity", "angular_velocity")}


class AnotherScene(ProgramTest):
    def assert_same_states(self, a, b):
        for name, values in a.items():
            self.assertTrue((values == b[name]).all(), name)

    def bed(self):
        self.good(self.scene(BED, "bed.yaml"), "bed")
        return self.folder / "bed/checkpoint.h5"

    def refused(self, scene, *says, checkpoint=None):
        before = tree(self.folder)
        run = unibody(scene, "-continue_from", checkpoint or self.folder / "bed/checkpoint.h5", "-output", self.folder / "none")
        self.assertEqual((run.code, len(run.message)), (2, 1), run.err)
        for text in says:
            self.assertIn(text, run.message[0])
        self.assertEqual(tree(self.folder), before)

    def test_a_plate_falls_into_a_bed(self):
        checkpoint = self.bed()
        press = self.scene(PRESS, "press.yaml")
        runs = {n: self.good(press, f"on_{n}", "-continue_from", checkpoint, ranks=n) for n in (1, 3)}
        self.assertEqual(runs[1].state, runs[3].state)
        bed, start = states(self.folder / "bed", 120), states(self.folder / "on_1", 0)
        # Ids run in the order of the file: the plane, five planes of the container, the balls, the box; and a plate before them.
        count = len(bed["position"])
        balls = slice(count - 61, count - 1)
        self.assertNotIn("ground", "".join(runs[1].out.splitlines()[:4]))  # it stands as it stood
        self.assert_same_states({k: v[balls] for k, v in bed.items()}, {k: v[len(v) - 60:] for k, v in start.items()})
        self.assertTrue((start["position"][0] == [0, 0, 0.9]).all())
        for line in ("starts from frame 120", "60 bodies go on", "plate is new: 1 body as the scene says",
                     "balls: 60 of 60 bodies go on", "lid is left out"):
            self.assertIn(line, runs[1].out)
        end = states(self.folder / "on_1", 40)["position"]
        self.assertLess(end[0, 2], 0.6)  # it has fallen onto the bed
        self.assertGreater(end[0, 2], end[len(end) - 60:, 2].min())
        summary = json.loads((self.folder / "on_1/summary.json").read_text())
        self.assertEqual(summary["continued_from"], str(checkpoint))

    # Balls without rolling friction never quite stand; those of a cube of boxes do.
    def test_what_rests_goes_on_resting(self):
        boxes = BED.replace("sphere: {radius: 0.05}", "box: {size: [0.1, 0.1, 0.1]}").replace("jitter: 0.004", "jitter: 0")
        scene = self.scene(boxes)
        self.good(scene, "bed")
        self.good(scene, "on", "-continue_from", self.folder / "bed/checkpoint.h5", "-set", "time.frames=100")
        before, after = (states(self.folder / name, frame)["position"] for name, frame in (("bed", 120), ("on", 100)))
        self.assertGreater(before[-2, 2], 0.3)  # m: they are four layers
        self.assertLess(abs(after - before).max(), 1e-3 * 0.1)  # m: a thousandth of an edge

    def test_what_moves_freely_goes_on_as_if_nothing_had_been(self):
        scene = self.scene(FREE)
        self.good(scene, "straight", "-set", "time.frames=40")
        self.good(scene, "first")
        self.good(scene, "second", "-continue_from", self.folder / "first/checkpoint.h5", ranks=3)
        for frame in (0, 20):  # of the second half
            self.assert_same_states(states(self.folder / "second", frame), states(self.folder / "straight", 20 + frame))

    def test_a_restart_goes_on_with_such_a_run(self):
        checkpoint = self.bed()
        press = self.scene(PRESS, "press.yaml")
        straight = self.good(press, "straight", "-continue_from", checkpoint)
        options = ("-continue_from", checkpoint, "-restart", "auto")
        self.good(press, "chain", *options, "-set", "time.frames=15")
        self.assertEqual(self.good(press, "chain", *options, ranks=3).state, straight.state)
        self.assertEqual(self.good(press, "own", "-restart", self.folder / "chain/checkpoint.h5").state, straight.state)

    def test_what_has_left_stays_away(self):
        drain = "    outlets: [{name: drain, box: {low: [-2, -2, -0.1], high: [0, 2, 2]}}]\n"
        self.good(self.scene(BED + drain, "bed.yaml"), "bed", "-set", "time.frames=1")
        press = self.scene(PRESS, "press.yaml")
        checkpoint = self.folder / "bed/checkpoint.h5"
        with h5py.File(checkpoint) as file:
            left = file.attrs["bodies"] - len(file["bodies"])
        self.assertGreater(left, 10)
        run = self.good(press, "press", "-continue_from", checkpoint, ranks=3)
        self.assertIn(f"balls: {60 - left} of 60 bodies go on, {left} are absent there and here", run.out)
        self.assertEqual(self.good(press, "one", "-continue_from", checkpoint, ranks=1).state, run.state)
        with h5py.File(self.folder / "press/frames.h5") as file:
            whole = len(file["frames/000040/position"])
        self.assertEqual(whole, 1 + 6 + 60 - left)
        again = self.good(press, "again", "-restart", self.folder / "press/checkpoint.h5", "-set", "time.frames=50")
        straight = self.good(press, "straight", "-continue_from", checkpoint, "-set", "time.frames=50")
        self.assertEqual(again.state, straight.state)

    # A load whose rope was cut at 0.1 s falls on, although the scene that goes on has the rope whole; another one hangs on.
    def test_what_has_broken_stays_broken(self):
        hanging = """
    time: {frame: 0.01, frames: 30}
    bodies:
      - {name: extra, shape: {sphere: {radius: 0.1}}, mass: 1, position: [5, 0, 0]}
      - {name: cut, shape: {sphere: {radius: 0.1}}, mass: 1}
      - {name: held, shape: {sphere: {radius: 0.1}}, mass: 1, position: [1, 0, 0]}
    joints:
      - {name: string, type: rope, bodies: [cut, world], points: [[0, 0, 0], [0, 0, 1]]}
      - {name: other, type: rope, bodies: [held, world], points: [[1, 0, 0], [1, 0, 1]]}
"""
        cut = hanging + "    events: [{do: release, joints: string, when: {time: 0.1}}]\n"
        self.good(self.scene(cut, "cut.yaml"), "cut")
        lines = [line for line in hanging.splitlines() if "extra" not in line]
        run = self.good(self.scene("\n".join(lines), "on.yaml"), "on", "-continue_from", self.folder / "cut/checkpoint.h5")
        self.assertIn("1 of the scene's joints have broken there, and are so here", run.out)
        velocity = states(self.folder / "on", 30)["velocity"][:, 2]
        self.assertAlmostEqual(velocity[0], -9.81 * 0.5, places=6)
        self.assertAlmostEqual(velocity[1], 0, places=6)

    def test_an_inlet_that_has_done_its_work(self):
        inlet = """
      - name: balls
        inlet: {count: 40, rate: 50, box: {low: [-0.2, -0.2, 0.5], high: [0.2, 0.2, 0.6]}, mix: [{shape: {sphere: {radius: 0.05}}}]}
        density: 1000
        material: steel
"""
        scene = self.scene(BED.replace(BALLS, inlet), "bed.yaml")
        self.good(scene, "bed", "-set", "time.frames=50")
        checkpoint = self.folder / "bed/checkpoint.h5"
        with h5py.File(checkpoint) as file:
            present = 40 - (file.attrs["bodies"] - len(file["bodies"]))
        self.assertTrue(10 < present < 40)
        run = self.good(scene, "on", "-continue_from", checkpoint, "-set", "time.frames=60")
        self.assertIn(f"balls: {present} of 40 bodies go on", run.out)
        self.assertIn("its inlet lets in no more", run.out)
        self.assertIn("inlet balls: 0 bodies (0 kg) came in", run.out)
        with h5py.File(self.folder / "on/checkpoint.h5") as file:
            self.assertEqual(40 - (file.attrs["bodies"] - len(file["bodies"])), present)

    def test_differences_are_told(self):
        checkpoint = self.bed()
        other = PRESS.replace("mass: 0.5", "mass: 0.6").replace("material: steel", "material: wood")
        other = other.replace("sphere: {radius: 0.05}", "sphere: {radius: 0.04}").replace("count: 60", "count: 50")
        run = self.good(self.scene(other), "other", "-continue_from", checkpoint)
        self.assertIn("balls: 50 of 50 bodies go on, 10 of the checkpoint's are left out, 50 with another shape, "
                      "50 with another mass, 50 with another material", run.out)
        run = self.good(self.scene(PRESS.replace("count: 60", "count: 70")), "more", "-continue_from", checkpoint)
        self.assertIn("balls: 60 of 70 bodies go on, 10 are new", run.out)

    def test_cloths_and_joints(self):
        text = """
            time: {frame: 0.01, frames: 30}
            bodies:
              - {name: block, shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [0, 0, 2]}
              - {name: bob, shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.5, 0, 2]}
            joints:
              - {type: ball, bodies: [block, world], anchor: [0, 0, 2]}
              - {type: ball, bodies: [bob, block], anchor: [0.1, 0, 2]}
            cloths:
              - {name: flag, grid: {size: [1, 1], nodes: [11, 11]}, mass: 0.2, thickness: 0.02, position: [3, 0, 2],
                 pins: [{node: [0, 0]}, {node: [10, 0]}]}
        """
        scene = self.scene(text)
        self.good(scene, "first")
        checkpoint = self.folder / "first/checkpoint.h5"
        run = self.good(scene, "second", "-continue_from", checkpoint, ranks=3)
        self.assert_same_states(states(self.folder / "second", 0), states(self.folder / "first", 30))
        self.assertEqual(run.state, self.good(scene, "one", "-continue_from", checkpoint, ranks=1).state)
        with open(self.folder / "second/report.csv", encoding="ascii") as file:
            header, *rows = [line.strip().split(",") for line in file]
        drift = [float(row[header.index("joint_drift_max (m)")]) for row in rows]
        self.assertLess(max(drift), 0.01)
        self.refused(self.scene(text.replace("name: bob", "name: ball").replace("[bob,", "[ball,")), "joint 1 holds ball and block together",
                     "found only block", checkpoint=checkpoint)
        self.refused(self.scene(text.replace("nodes: [11, 11]", "nodes: [12, 11]")), "flag: found 132 nodes, expected 121",
                     checkpoint=checkpoint)

    def test_bad_input(self):
        self.bed()
        press = self.scene(PRESS, "press.yaml")
        self.refused(press, "there is no checkpoint", checkpoint=self.folder / "no.h5")
        self.refused(press, "is damaged or no checkpoint", checkpoint=self.folder / "bed/frames.h5")
        self.refused(self.scene(PRESS.replace("name: balls", "name: beads").replace("name: ground", "name: floor")
                                .replace("name: walls", "name: box")), "found no moving bodies of a name", "ground, walls, balls, lid")
        self.refused(self.scene("planar: true\nbodies:\n  - {name: balls, shape: {disc: {radius: 0.05}}, mass: 1}\n"),
                     "key 'planar': found true, expected false")
        run = unibody(press, "-continue_from", "a.h5", "-restart", "b.h5", folder=self.folder)
        self.assertEqual(run.code, 2)
        self.assertIn("option -continue_from: a checkpoint is given already", run.message[0])


if __name__ == "__main__":
    unittest.main(verbosity=2)
