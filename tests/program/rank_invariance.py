#!/usr/bin/python3
"""The same bits on any number of ranks, for any partition: state, frames.h5, frames.xdmf, checkpoint.h5 and report.csv."""
import csv
import json
import unittest

from unibody_runs import SCENES, SOURCE, ProgramTest, comparable, contents

SOLVERS = ["accelerated_jacobi", "gauss_seidel", "jacobi"]

# Boxes and spheres of many sizes dropped between walls, on a tilted board and beside a kinematic one.
MIXED = """
    title: boxes and spheres between walls
    time: {frame: 0.016, frames: 40}
    output: {every: 10}
    materials: {stone: {friction: 0.5}, ice: {friction: 0}}
    bodies:
      - container: {size: [1.5, 1.5]}
      - shape: {box: {size: [1, 1, 0.1]}}
        motion: fixed
        position: [0.2, 0, 0.2]
        orientation: {axis: [0, 1, 0], angle: 20}
        material: ice
      - shape: {box: {size: [0.2, 1, 0.2]}}
        motion: kinematic
        position: [-0.6, 0, 0.15]
        velocity: [0.3, 0, 0]
        angular_velocity: [0, 0, 0.5]
      - pile:
          count: 120
          columns: [4, 4]
          mix:
            - {shape: {sphere: {radius: 0.08}}, scale: [0.6, 1.4], share: 2}
            - {shape: {box: {size: [0.2, 0.15, 0.1]}}, scale: [0.5, 1.2]}
        density: 2600
        position: [0, 0, 0.5]
        velocity: [0, 0, -4]
"""

GROUND = "- shape: {plane: {normal: [0, 0, 1]}}"


def step_solid():
    """A step, 0.2 m long, as an ASCII STL file: closed, and not convex."""
    outline = [(0, 0), (0.2, 0), (0.2, 0.05), (0.1, 0.05), (0.1, 0.1), (0, 0.1)]
    fan = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    front, back = [(x, 0.0, z) for x, z in outline], [(x, 0.1, z) for x, z in outline]
    facets = [[front[i] for i in t] for t in fan] + [[back[i] for i in reversed(t)] for t in fan]
    for i in range(6):
        j = (i + 1) % 6
        facets += [[front[j], front[i], back[i]], [front[j], back[i], back[j]]]
    text = ["solid step"]
    for facet in facets:
        text += ["facet normal 0 0 0", "outer loop", *("vertex %g %g %g" % x for x in facet), "endloop", "endfacet"]
    return "\n".join([*text, "endsolid step", ""])


class RankInvariance(ProgramTest):
    def assert_same(self, first, other, files=("frames.h5", "frames.xdmf", "checkpoint.h5")):
        one, two = self.folder / first, self.folder / other
        for name in files:
            self.assertTrue(contents(one / name) == contents(two / name), f"{name} of {other} isn't the one of {first}")
        self.assertEqual(comparable(one / "report.csv"), comparable(two / "report.csv"), f"{other}: report.csv")

    def ranks_told(self, name):
        return json.loads((self.folder / name / "summary.json").read_text())["ranks"]

    def check_all(self, scene, solver, *options):
        options = (f"-set", f"solver.name={solver}", *options)
        one = self.good(scene, "on_1", *options, ranks=1)
        header, *rows = comparable(self.folder / "on_1" / "report.csv")
        contacts = header.index("contacts")
        self.assertGreater(int(rows[-1][contacts]), 100, "nothing touches anything: such a run tells nothing")
        variants = {f"on_{n}": (n, []) for n in ((2, 3, 4, 7) if solver == SOLVERS[0] else (4,))}
        variants["random_11_by_messages"] = (3, ["-partition", "random:11", "-shared_memory", "off"])
        if solver == SOLVERS[0]:
            variants["random_12_fixed"] = (4, ["-partition", "random:12", "-rebalance", "off"])
            variants["no_rebalance"] = (3, ["-rebalance", "off"])
        for name, (ranks, more) in variants.items():
            with self.subTest(solver=solver, variant=name):
                run = self.good(scene, name, *options, *more, ranks=ranks)
                self.assertEqual(run.state, one.state)
                self.assertEqual(self.ranks_told(name), ranks)
                self.assert_same("on_1", name)

    def test_boxes(self):
        for solver in SOLVERS:
            with self.subTest(solver=solver):
                self.folder_for(solver)
                self.check_all(SCENES / "boxes_500.yaml", solver, "-set", "time.frames=40", "-set", "output.every=10")

    def test_the_memory_of_a_rank_falls_with_their_number(self):
        largest = []
        for n in (1, 4):
            self.good(SCENES / "boxes_2000.yaml", f"memory_{n}", "-set", "time.frames=1", "-set", "output.every=0", ranks=n)
            largest.append(json.loads((self.folder / f"memory_{n}" / "summary.json").read_text())["final"]["bytes_of_largest_rank (B)"])
        self.assertLess(largest[1], 0.6 * largest[0])

    def test_boxes_and_spheres_between_walls(self):
        for solver in SOLVERS:
            with self.subTest(solver=solver):
                self.folder_for(solver)
                self.check_all(self.scene(MIXED), solver)

    # Colours across many cuts; few frames, since it takes a message a colour.
    def test_gauss_seidel_on_seven_ranks(self):
        scene = self.scene(MIXED)
        options = ["-set", "solver.name=gauss_seidel", "-set", "time.frames=16", "-set", "solver.iterations=6"]
        one = self.good(scene, "on_1", *options, ranks=1)
        header, *rows = comparable(self.folder / "on_1" / "report.csv")
        self.assertGreater(int(rows[-1][header.index("contacts")]), 100, "nothing touches anything: such a run tells nothing")
        self.assertEqual(self.good(scene, "on_7", *options, ranks=7).state, one.state)
        self.assertEqual(self.ranks_told("on_7"), 7)
        self.assert_same("on_1", "on_7")

    def report_of_equal_runs(self, scene, options):
        """The rows of report.csv of a scene's runs on 1 rank and of a random partition on 4, both the same."""
        one = self.good(SCENES / f"{scene}.yaml", f"{scene}_1", *options, ranks=1)
        other = self.good(SCENES / f"{scene}.yaml", f"{scene}_4", *options, "-partition", "random:3", ranks=4)
        with self.subTest(scene=scene):
            self.assertEqual(other.state, one.state)
            self.assert_same(f"{scene}_1", f"{scene}_4")
        return list(csv.DictReader((self.folder / f"{scene}_1" / "report.csv").read_text().splitlines()))

    # Up to the impact: heavy boxes on faces; sheets on each other and on themselves. The guard has had to hold some pairs of both.
    def test_cloths(self):
        heavy = ("cloths[0].mass=3", "bodies[1].mass=0.5", "bodies[1].velocity=[0, 0, -5]")
        for scene, frames, more in (("boxes_on_cloth", 20, heavy), ("cloth_stack", 26, ())):
            options = [word for text in (f"time.frames={frames}", "output.every=10", *more) for word in ("-set", text)]
            report = self.report_of_equal_runs(scene, options)
            self.assertGreater(int(report[-1]["contacts"]), 200)
            if scene == "cloth_stack":  # the other cloth does not know of itself
                self.assertEqual({row["crossings (1)"] for row in report}, {"0"})
            held = sum(int(row["held_pairs (1)"]) for row in report)
            self.assertGreater(held, 0)

    # Newton's method on two levels: a sheet that hangs from two corners; boxes that come to lie on another.
    def test_the_coarse_level(self):
        for scene, frames, stretch in (("cloth_hanging", 16, 0.005), ("boxes_on_cloth", 24, 1)):
            options = [word for text in (f"time.frames={frames}", "output.every=8", "solver.coarse=true") for word in ("-set", text)]
            report = self.report_of_equal_runs(scene, options)
            column = next(name for name in report[0] if name.startswith("stretch_max"))
            self.assertLess(max(float(row[column]) for row in report), stretch)

    # The same two, a few frames from their first contacts on, by colours.
    def test_cloths_with_gauss_seidel(self):
        heavy = ("cloths[0].mass=3", "bodies[1].mass=0.5", "bodies[1].velocity=[0, 0, -5]")
        thrown = tuple(f"cloths[{k}].velocity=[0, 0, -6]" for k in range(1, 5))
        for scene, more in (("boxes_on_cloth", heavy), ("cloth_stack", thrown)):
            options = [word for text in ("time.frames=6", "output.every=3", "solver.name=gauss_seidel", *more)
                       for word in ("-set", text)]
            report = self.report_of_equal_runs(scene, options)
            self.assertGreater(int(report[-1]["contacts"]), 100, "nothing touches anything: such a run tells nothing")

    # A soft mesh that slides on a box, with substeps; grains poured on a cloth.
    def test_soft_and_granular(self):
        slide = ("time.frames=4", "time.substeps=2", "solver.iterations=10", "solids[0].velocity=[1, 0, -3]")
        pour = ("time.frames=10", "solver.iterations=10", "bodies[1].lattice.count=300", "bodies[1].lattice.columns=[10, 10]",
                "bodies[1].velocity=[0, 0, -6]", "cloths[0].grid.nodes=[21, 21]", "cloths[0].pins=[{node: [0, 0]}, {node: [20, 20]}]")
        for scene, contacts, more in (("torus_on_box", 10, slide), ("grains_on_cloth", 100, pour)):
            options = [word for text in ("output.every=5", *more) for word in ("-set", text)]
            report = self.report_of_equal_runs(scene, options)
            self.assertGreater(int(report[-1]["contacts"]), contacts, "nothing touches anything: such a run tells nothing")
            self.assertGreater(max(int(row["sliding_contacts"]) for row in report), 0)

    # Contacts, joints, links and a soft solid, all at velocity level.
    def test_velocity_level(self):
        cases = [(self.scene(MIXED, "mixed.yaml"), "time.frames=30"), (SCENES / "hierarchy.yaml", "time.frames=30"),
                 (SCENES / "boxes_on_cloth.yaml", "time.frames=20"), (SCENES / "soft_block_on_floor.yaml", "time.frames=10")]
        for scene, *more in cases:
            others = (2, 4) if scene.stem == "mixed" else (3,)
            for solver in SOLVERS[:2]:
                name = f"{scene.stem}_{solver}"
                options = ["-solver_level", "velocity"]
                for text in (f"solver.name={solver}", "solver.iterations=15", "output.every=10", *more):
                    options += ["-set", text]
                one = self.good(scene, f"{name}_1", *options, ranks=1)
                self.assertNotEqual(self.good(scene, f"{name}_position", *options[2:], ranks=1).state, one.state, name)
                for n in others:
                    with self.subTest(scene=scene.stem, solver=solver, ranks=n):
                        self.assertEqual(self.good(scene, f"{name}_{n}", *options, ranks=n).state, one.state)
                        self.assert_same(f"{name}_1", f"{name}_{n}")

    # A chain across all ranks, and a tree that has fallen on a bar: also what each joint does.
    def test_joints(self):
        tree = ("bodies[2].tree.levels=6", "bodies[2].position=[0, 0, 3.5]", "time.frames=60")
        for scene, solver, more in (("chain_heavy_ball", "accelerated_jacobi", ("time.frames=20",)), ("hierarchy", "accelerated_jacobi", tree),
                                    ("hierarchy", "gauss_seidel", tree)):
            base = f"{scene}_{solver}"
            options = [word for text in (f"solver.name={solver}", "output.every=20", "output.joints=true", *more) for word in ("-set", text)]
            runs = {n: self.good(SCENES / f"{scene}.yaml", f"{base}_{n}", *options, ranks=n) for n in (1, 4)}
            runs[3] = self.good(SCENES / f"{scene}.yaml", f"{base}_3", *options, "-partition", "random:3", ranks=3)
            for n in (3, 4):
                with self.subTest(scene=scene, solver=solver, run=n):
                    self.assertEqual(runs[n].state, runs[1].state)
                    self.assert_same(f"{base}_1", f"{base}_{n}", ("frames.h5", "checkpoint.h5", "joints.csv", "joints.h5"))
            report = list(csv.DictReader((self.folder / f"{base}_1" / "report.csv").read_text().splitlines()))
            drift = [float(row["joint_drift_max (m)"]) for row in report]
            self.assertGreater(max(drift), 1e-6, "nothing pulls at any joint: such a run tells nothing")
            self.assertLess(max(drift), 0.1)

    # What is taken from contacts for one kind of constraint must not show in what is said of the others.
    def test_everything_at_once(self):
        scene = SOURCE / "tests" / "program" / "everything.yaml"
        for name, more in (("iterative", []), ("direct", ["-set", "solver.joints=direct"]), ("velocity", ["-solver_level", "velocity"]),
                           ("gauss_seidel", ["-set", "solver.name=gauss_seidel"])):
            one = self.good(scene, f"{name}_1", *more, ranks=1)
            with self.subTest(joints=name):
                self.assertEqual(self.good(scene, f"{name}_3", *more, "-partition", "random:4", ranks=3).state, one.state)
                self.assert_same(f"{name}_1", f"{name}_3")
            rows = list(csv.DictReader((self.folder / f"{name}_1" / "report.csv").read_text().splitlines()))
            self.assertGreater(max(int(row["contacts"]) for row in rows), 40, "nothing touches anything: such a run tells nothing")

    # Few grains in the drum and on the hills; solids read from an STL file, in convex pieces, on a cloth.
    def test_shapes(self):
        solid = self.folder / "solid.stl"
        solid.write_text(step_solid())
        scenes = {
            "drum": ("bodies[1].pile.count=200", "bodies[1].pile.columns=[8, 5]", "bodies[1].position=[0, 0, 0.1]", "time.frames=20"),
            "terrain": ("bodies[1].pile.count=150", "bodies[1].pile.columns=[10, 10]", "bodies[1].velocity=[0, 0, -8]", "time.frames=25"),
            "bunnies_on_cloth": (f"bodies[1].shape.compound.mesh={solid}", "bodies[1].density=400", "bodies[1].velocity=[0, 0, -8]",
                                 "time.frames=8"),
        }
        for scene, more in scenes.items():
            options = [word for text in ("output.every=10", *more) for word in ("-set", text)]
            report = self.report_of_equal_runs(scene, options)
            self.assertGreater(int(report[-1]["contacts"]), 50, "nothing touches anything: such a run tells nothing")

    # Contacts with and without friction side by side in every block of four, which contacts share one depends on the rank.
    def test_every_friction_model(self):
        scene = self.scene(MIXED)
        for model in ("cone", "saxce", "box", "none", "postprocess"):
            for solver in SOLVERS[:2]:
                with self.subTest(model=model, solver=solver):
                    options = ["-set", "time.frames=25", "-set", f"solver.friction={model}", "-set", f"solver.name={solver}"]
                    runs = [self.good(scene, f"{model}_{solver}_{n}", *options, ranks=n) for n in (1, 3)]
                    self.assertEqual(runs[0].state, runs[1].state)
                    self.assert_same(f"{model}_{solver}_1", f"{model}_{solver}_3")

    def folder_for(self, solver):
        base = getattr(self, "base", self.folder)
        self.base, self.folder = base, base / solver
        self.folder.mkdir()

    # The comparison can fail: one bit of one body's velocity, or of the gravity, is another run.
    def test_a_changed_scene_has_another_state(self):
        scene = """
            time: {frames: 30}
            output: {every: 30}
            bodies:
              - shape: {plane: {normal: [0, 0, 1]}}
              - lattice: {count: 60, columns: [4, 4], spacing: [0.16, 0.16, 0.19], height: 0.2, jitter: 0.01}
                shape: {box: {size: [0.12, 0.12, 0.15]}}
                mass: 1
              - shape: {sphere: {radius: 0.05}}
                mass: 1
                position: [0, 0, 1.2]
                velocity: [VELOCITY, 0, 0]
        """
        one = self.scene(scene.replace("VELOCITY", "0.5"))
        original = self.good(one, "original", ranks=2)
        bit = self.scene(scene.replace("VELOCITY", "0.50000000000000011102230246251565"), "bit.yaml")
        changed = self.good(bit, "bit", ranks=2)
        self.assertNotEqual(changed.state, original.state)
        self.assertNotEqual(contents(self.folder / "bit/frames.h5"), contents(self.folder / "original/frames.h5"))
        self.assertNotEqual(contents(self.folder / "bit/checkpoint.h5"), contents(self.folder / "original/checkpoint.h5"))
        gravity = self.good(one, "gravity", "-set", "gravity=[0, 0, -9.810000000000002]", ranks=2)
        self.assertNotEqual(gravity.state, original.state)
        self.assertNotEqual(comparable(self.folder / "gravity/report.csv"), comparable(self.folder / "original/report.csv"))
        again = self.good(one, "again", ranks=3)
        self.assertEqual(again.state, original.state)


class SmallScenes(ProgramTest):
    """Fewer bodies than ranks, or all of them in one place."""

    def check(self, text, frames=30, ranks=(2, 7), solvers=SOLVERS[:1]):
        scene = self.scene("time: {frames: %d}\nbodies:\n%s" % (frames, text))
        for solver in solvers:
            one = self.good(scene, solver + "_1", "-set", "solver.name=" + solver, ranks=1)
            for n in ranks:
                with self.subTest(solver=solver, ranks=n):
                    name = f"{solver}_{n}"
                    run = self.good(scene, name, "-set", "solver.name=" + solver, ranks=n)
                    self.assertEqual(run.state, one.state)
                    for file in ("frames.h5", "frames.xdmf", "checkpoint.h5"):
                        self.assertTrue(contents(self.folder / name / file) == contents(self.folder / (solver + "_1") / file), file)
                    reports = [comparable(self.folder / f / "report.csv") for f in (name, solver + "_1")]
                    self.assertEqual(*reports)
                    self.assertEqual(len(reports[0]), frames + 1)

    def test_three_bodies_on_seven_ranks(self):
        self.check(f"""
  {GROUND}
  - {{shape: {{box: {{size: [1, 1, 0.2]}}}}, mass: 2, position: [0, 0, 0.11]}}
  - {{shape: {{sphere: {{radius: 0.1}}}}, mass: 1, position: [0.1, 0, 0.32]}}
  - {{shape: {{box: {{size: [0.2, 0.2, 0.2]}}}}, mass: 1, position: [-0.2, 0, 0.34], velocity: [0, 0, -1]}}
""", ranks=(7,), solvers=SOLVERS)

    # So small beside the largest body that all of them lie in one cell of the partition's grid.
    def test_all_bodies_in_one_place(self):
        self.check(f"""
  {GROUND}
  - {{shape: {{box: {{size: [8, 8, 0.5]}}}}, mass: 500, position: [0, 0, 0.25]}}
  - lattice: {{count: 27, columns: [3, 3], spacing: [0.021, 0.021, 0.021], height: 0.512, jitter: 0.001}}
    shape: {{sphere: {{radius: 0.01}}}}
    mass: 0.01
""", ranks=(7,), solvers=SOLVERS)

    def test_one_body(self):
        self.check(f"  {GROUND}\n  - {{shape: {{sphere: {{radius: 0.1}}}}, mass: 1, position: [0, 0, 0.3], velocity: [1, 0, 0]}}\n")

    def test_nothing_but_statics(self):
        self.check(f"  {GROUND}\n  - {{shape: {{box: {{size: [1, 1, 1]}}}}, motion: fixed, position: [0, 0, 0.4]}}\n",
                   frames=3, ranks=(2, 3))

    def test_no_frames(self):
        self.check(f"  {GROUND}\n  - {{shape: {{sphere: {{radius: 0.1}}}}, mass: 1, position: [0, 0, 0.3]}}\n", frames=0, ranks=(3,))


if __name__ == "__main__":
    unittest.main(verbosity=2)
