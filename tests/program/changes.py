#!/usr/bin/python3
"""Scenes that change while they run: the same on any number of ranks and through restarts, and told in every file."""
import json
import re
import shutil
import unittest

import h5py
import numpy

from unibody_runs import ProgramTest, comparable, contents, report, unibody

# Grains fall on a gate that is removed, are added to by a body and pass an outlet; a cloth hangs beside them.
FEED = """
    time: {frame: 0.01, frames: 100}
    output: {every: 5, checkpoint_every: 0}
    solver: {iterations: 30}
    materials: {steel: {friction: 0.3}}
    bodies:
      - {name: floor, shape: {box: {size: [1, 1, 0.1]}}, motion: fixed, position: [0, 0, -0.05], material: steel}
      - {name: gate, shape: {box: {size: [0.3, 0.3, 0.02]}}, motion: fixed, position: [0, 0, 0.2], material: steel}
      - {name: late, shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, position: [0.4, 0, 0.3], start: absent, material: steel}
      - {name: hung, shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, position: [-0.4, 0, 0.3], start: held, material: steel}
      - name: grains
        density: 2500
        material: steel
        velocity: [0, 0, -1]
        position: [0, 0, 0.5]
        inlet:
          count: 150
          rate: 300
          box: {low: [-0.05, -0.05, 0], high: [0.05, 0.05, 0.05]}
          mix:
            - {shape: {sphere: {radius: 0.01}}, scale: {normal: {mean: 1, deviation: 0.2, smallest: 0.6, largest: 1.4}}}
            - {shape: {box: {size: [0.02, 0.02, 0.02]}}, share: 0.3}
    cloths:
      - {name: curtain, grid: {nodes: [5, 5], size: [0.2, 0.2]}, position: [0.2, 0, 0.4], mass: 0.1, thickness: 0.005, links: {},
         pins: [{node: [0, 0]}, {node: [4, 0]}]}
    outlets:
      - {name: drain, of: grains, box: {low: [-5, -5, -5], high: [5, 5, 0.1]}}
    events:
      - {do: add, bodies: late, when: {time: 0.2}}
      - {do: release, bodies: hung, when: {time: 0.4}}
      - {do: remove, bodies: gate, when: {time: 0.5}}
      - {do: friction, between: [steel, steel], friction: 0, when: {column: inlet_grains_placed, above: 140}}
"""
FIRST = {"add late": 21, "release hung": 41, "remove gate": 51}


class Changes(ProgramTest):
    def columns(self, name):
        head, rows = report(self.folder / name / "report.csv")
        return {column: [float(row[k]) if row[k] else None for row in rows] for k, column in enumerate(head)}

    def test_any_ranks_and_solvers(self):
        for solver in ("accelerated_jacobi", "gauss_seidel"):
            with self.subTest(solver):
                scene = self.scene(FEED)
                chosen = ["-set", f"solver.name={solver}"]
                one = self.good(scene, f"{solver}1", *chosen)
                for ranks in (2, 3, 4):
                    name = f"{solver}{ranks}"
                    self.assertEqual(self.good(scene, name, *chosen, ranks=ranks).state, one.state)
                    for file in ("checkpoint.h5", "frames.h5", "frames.xdmf"):
                        self.assertEqual(contents(self.folder / name / file), contents(self.folder / f"{solver}1" / file), file)
                    self.assertEqual(comparable(self.folder / name / "report.csv"),
                                     comparable(self.folder / f"{solver}1/report.csv"))

    def test_a_restart_in_the_middle(self):
        scene = self.scene(FEED)
        straight = self.good(scene, "straight")
        for frames in (10, 20, 40, 50, 70):  # the inlet runs, events are pending or take effect in the next frame
            with self.subTest(frames=frames):
                self.good(scene, "part", "-set", f"time.frames={frames}", ranks=2)
                self.assertEqual(self.good(scene, "part", "-restart", "auto", ranks=3).state, straight.state)
                self.assertEqual(contents(self.folder / "part/checkpoint.h5"), contents(self.folder / "straight/checkpoint.h5"))
                self.assertEqual(contents(self.folder / "part/frames.xdmf"), contents(self.folder / "straight/frames.xdmf"))
                self.assertEqual(comparable(self.folder / "part/report.csv"), comparable(self.folder / "straight/report.csv"))
                shutil.rmtree(self.folder / "part")

    def test_what_is_told(self):
        run = self.good(self.scene(FEED), "run")
        columns = self.columns("run")
        placed, removed = columns["inlet_grains_placed (1)"], columns["outlet_drain_removed (1)"]
        self.assertEqual(placed[-1], 150)
        self.assertEqual(placed[9], 27)  # 0.09 s at 300 a second, by the start of frame 10
        self.assertGreater(removed[-1], 50)
        late = [1 if frame >= FIRST["add late"] else 0 for frame in range(1, 101)]
        gate = [1 if frame < FIRST["remove gate"] else 0 for frame in range(1, 101)]
        always = 2 + 25  # the floor and what hangs, and the cloth's nodes
        self.assertEqual(columns["bodies (1)"], [always + a + g + p - r for a, g, p, r in zip(late, gate, placed, removed)])
        summary = json.loads((self.folder / "run/summary.json").read_text())["changes"]
        first = {event["event"]: event["first_frame"] for event in summary["events"]}
        steel = first.pop("friction steel steel")
        self.assertEqual(first, FIRST)
        self.assertEqual(steel, next(k for k, n in enumerate(placed) if n > 140) + 2)  # the frame after; frames count from 1
        self.assertEqual(summary["outlets"][0]["removed"], removed[-1])
        self.assertAlmostEqual(summary["inlets"][0]["placed_mass (kg)"], columns["inlet_grains_placed_mass (kg)"][-1])
        for line in ("inlet grains: 150 bodies", f"outlet drain: {removed[-1]:.0f} bodies", "event remove gate at 0.5 s: from frame 51 on"):
            self.assertIn(line, run.out)
        self.assertIn("  inlet  grains: up to 150 bodies come in", run.out)
        milliseconds, rate = re.findall(r"([0-9.]+) ms/frame  (\S+) bodies/s", run.out)[-1]  # of those that are there
        present = columns["bodies (1)"]
        self.assertAlmostEqual(float(rate) * float(milliseconds) / 1e3 / (sum(present) / len(present)), 1, delta=0.1)
        self.assertLess(sum(present) / len(present), 0.8 * (150 + 25))

    def test_frames_hold_what_is_there(self):
        self.good(self.scene(FEED), "run", ranks=2)
        columns = self.columns("run")
        with h5py.File(self.folder / "run/frames.h5") as file:
            self.assertEqual(len(file["bodies/id"]), 4 + 150 + 25)
            for name, frame in file["frames"].items():
                ids, number = frame["id"][:], int(name)
                if number > 0:
                    self.assertEqual(len(ids), columns["bodies (1)"][number - 1])
                self.assertTrue((numpy.diff(ids) > 0).all())
                self.assertEqual(1 in ids, number < FIRST["remove gate"])
                self.assertEqual(2 in ids, number >= FIRST["add late"])
                self.assertTrue((frame["size"][:] == file["bodies/size"][:][ids]).all())
                self.assertTrue((frame["shape"][:] == file["bodies/shape"][:][ids]).all())
                self.assertTrue((frame["node_position"][:] == frame["position"][:][ids >= 154]).all())
            cells = file["surfaces/000000/cells"][:] - 154
            self.assertTrue((file["surfaces/000000/node_cells"][:] == cells).all())

    def test_a_run_that_starts_empty(self):
        scene = self.scene("""
            time: {frame: 0.01, frames: 30}
            bodies:
              - name: rain
                density: 1000
                inlet: {count: 40, rate: 200, box: {low: [0, 0, 0], high: [3, 3, 3]}, mix: [{shape: {box: {size: [0.1, 0.1, 0.1]}}}]}
        """)
        one = self.good(scene, "one")
        self.assertEqual(self.columns("one")["bodies (1)"][-1], 40)
        for ranks in (2, 4):
            self.assertEqual(self.good(scene, f"on{ranks}", ranks=ranks).state, one.state)
        self.good(scene, "none", "-set", "time.frames=0")
        self.assertEqual(self.good(scene, "none", "-restart", "auto", ranks=3).state, one.state)

    def test_another_scene_is_refused(self):
        self.good(self.scene(FEED), "run", "-set", "time.frames=10")
        for before, now in (("rate: 300", "rate: 310"), ("time: 0.4", "time: 0.41"), ("high: [5, 5, 0.1]", "high: [5, 5, 0.11]"),
                            ("start: held", "start: present")):
            with self.subTest(now):
                run = unibody(self.scene(FEED.replace(before, now)), "-output", self.folder / "run", "-restart", "auto")
                self.assertEqual(run.code, 2)
                self.assertIn("belongs to another scene", run.err)


if __name__ == "__main__":
    unittest.main()
