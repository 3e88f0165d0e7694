#!/usr/bin/python3
"""What a user can get wrong: every fault ends the program at once, on every rank, with a message that says what to change,
and nothing is written. tests/scene holds the reader's messages word for word; here it is the whole program on two ranks."""
import os
import resource
import subprocess
import time
import unittest

from unibody_runs import MPIEXEC, PROGRAM, ProgramTest, command, end, execute, start, tree, unibody

GOOD = """\
title: a ball on the ground
time: {frames: 5}
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - shape: {sphere: {radius: 0.1}}
    mass: 1
    position: [0, 0, 0.3]
"""

MOST_SECONDS = 5  # of processor time, in a run that is refused, mpirun's own included; it takes less than one


class RefusedTest(ProgramTest):
    def refused(self, scene, *options, ranks=2, says=(), output="results/deep"):
        """The program must end with code 2 and one message that holds all of `says`; it must have written nothing."""
        before = tree(self.folder)
        run = unibody(scene, "-output", self.folder / output, *options, ranks=ranks, timeout=60, folder=self.folder)
        self.assertEqual(run.code, 2, run.err)
        self.assertLess(run.seconds, MOST_SECONDS, "it is meant to be refused at once")
        self.assertEqual(len(run.message), 1, run.err)
        for text in says:
            self.assertIn(text, run.message[0])
        self.assertIsNone(run.state)
        self.assertEqual(tree(self.folder), before, "something was written")
        return run


class BadScenes(RefusedTest):
    def bad(self, change, line, key, found, expected):
        """The good scene with one text changed for another one."""
        text = GOOD.replace(*change)
        self.assertNotEqual(text, GOOD)
        scene = self.scene(text)
        expected_place = f"{scene}:{line}:" if line else str(scene)
        self.refused(scene, says=[expected_place, f"key '{key}'", f"found {found}", f"expected {expected}"])

    def test_the_good_scene_is_good(self):
        self.good(self.scene(GOOD), "results")

    def test_unknown_key(self):
        self.bad(("    mass: 1\n", "    mass: 1\n    colour: red\n"), 7, "bodies[1].colour", "an unknown key", "name, material")

    def test_wrong_type(self):
        self.bad(("mass: 1", "mass: heavy"), 6, "bodies[1].mass", "heavy", "a number > 0 (kg)")

    def test_map_for_a_number(self):
        self.bad(("frames: 5", "frames: {number: 5}"), 2, "time.frames", "a map", "an integer")

    def test_missing_value(self):
        self.bad(("mass: 1", "mass:"), 6, "bodies[1].mass", "nothing", "a number > 0 (kg)")

    def test_missing_key(self):
        self.bad(("    mass: 1\n", ""), 5, "bodies[1].mass", "nothing", "")

    def test_negative_mass(self):
        self.bad(("mass: 1", "mass: -1"), 6, "bodies[1].mass", "-1", "a number > 0 (kg)")

    def test_nan(self):
        self.bad(("0.3]", ".nan]"), 7, "bodies[1].position[2]", ".nan", "a finite number (m)")

    def test_infinity(self):
        self.bad(("mass: 1", "mass: .inf"), 6, "bodies[1].mass", ".inf", "a number > 0 (kg)")

    def test_overflow(self):
        self.bad(("mass: 1", "mass: 1e999"), 6, "bodies[1].mass", "1e999", "a number > 0 (kg)")

    def test_plane_normal_without_unit_length(self):
        self.bad(("[0, 0, 1]", "[0, 0, 2]"), 4, "bodies[0].shape.plane.normal", "[0, 0, 2]", "")

    def test_quaternion_without_unit_length(self):
        self.bad(("    mass: 1\n", "    mass: 1\n    orientation: [1, 1, 0, 0]\n"), 7, "bodies[1].orientation", "[1, 1, 0, 0]", "")

    def test_axis_without_unit_length(self):
        self.bad(("    mass: 1\n", "    mass: 1\n    orientation: {axis: [0, 0, 0], angle: 30}\n"), 7,
                 "bodies[1].orientation.axis", "[0, 0, 0]", "")

    def test_box_of_no_size(self):
        self.bad(("sphere: {radius: 0.1}", "box: {size: [1, 0, 1]}"), 5, "bodies[1].shape.box.size[1]", "0", "a number > 0 (m")

    def test_key_given_twice(self):
        self.bad(("    mass: 1\n", "    mass: 1\n    mass: 2\n"), 7, "bodies[1].mass", "", "each key once")

    def test_unknown_solver(self):
        self.bad(("time:", "solver: {name: sor}\ntime:"), 2, "solver.name", "sor", "accelerated_jacobi")

    def test_warm_start_of_more_than_half(self):
        self.bad(("time:", "solver: {warm_start: 0.9}\ntime:"), 2, "solver.warm_start", "0.9", "")

    def test_sequential_order_on_two_ranks(self):
        text = GOOD.replace("time:", "solver: {name: gauss_seidel, order: sequential}\ntime:")
        run = self.refused(self.scene(text), says=["scene.yaml", "key 'solver.order'", "found sequential", "expected coloured"])
        self.assertIn("2 ranks", run.message[0])
        self.good(self.scene(text), "one", ranks=1)

    def test_newton_on_two_ranks(self):
        scene = self.scene("solver: {name: newton}\ntime: {frames: 2}\nsolids:\n"
                           "  - {block: {size: [1, 1, 1], cells: [1, 1, 1]}, density: 1000, youngs_modulus: 1.0e+6,\n"
                           "     poissons_ratio: 0.3, thickness: 0.01}\n")
        run = self.refused(scene, says=["scene.yaml", "key 'solver.name'", "found newton", "expected an iterative solver"])
        self.assertIn("2 ranks", run.message[0])
        self.good(scene, "one", ranks=1)

    def test_what_doubles_cannot_resolve(self):
        for change, place, says in (
                (("0.3]", "0.3]\n    velocity: [0, 3.0e8, 0]"), ":5:", "a speed of 3e+08 m/s"),
                (("0.3]", "0.3]\n    angular_velocity: [1.0e200, 0, 0]"), ":5:", "a speed of 1e+199 m/s"),
                (("radius: 0.1", "radius: 1.0e-20"), ":5:", "a size of 2e-20 m"),
                (("radius: 0.1", "radius: 1.0e16"), ":5:", "a size of 2e+16 m"),
                (("[0, 0, 0.3]", "[0, 1.0e16, 0]"), ":5:", "a coordinate of 1e+16 m"),
                (("[0, 0, 0.3]", "[0, 1.0e10, 0]"), ":5:", "a size of 0.2 m where coordinates of 1e+10 m are rounded"),
                (("frames: 5", "frames: 5, frame: 1.0e-15"), ":5:", "steps of 1e-15 s"),
                (("frames: 5", "frames: 5, frame: 1.0e-9, substeps: 1000000"), ":5:", "steps of 1e-15 s"),
                (("frames: 5", "frames: 5, frame: 1.0e+20"), ": found", "steps of 1e+20 s"),
                (("time:", "gravity: [0, 0, -1.0e308]\ntime:"), ": found", "in a gravity of 1e+308 m/s^2")):
            with self.subTest(says=says):
                text = GOOD.replace(*change)
                self.assertNotEqual(text, GOOD)
                self.refused(self.scene(text), says=[f"scene.yaml{place}", says, "expected"])
        for change in (("0.3]", "0.3]\n    velocity: [0, 1.0e6, 0]"), ("frames: 5", "frames: 5, frame: 1.0e-9"),
                       ("[0, 0, 0.3]", "[1.0e7, 0, 0.3]"), ("radius: 0.1", "radius: 1.0e-7")):
            with self.subTest(good=change):
                self.good(self.scene(GOOD.replace(*change)), "results", "-overwrite")

    def test_aliases_that_stand_for_more_than_there_is_memory_for(self):
        """Ten aliases of ten aliases of ..., 10^10 values in 400 bytes; and an alias that stands for itself."""
        lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
        lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 10)]
        self.refused(self.scene("\n".join(lines) + "\n"), says=["scene.yaml:1:", "aliases that stand for more than 200000 values"])
        self.refused(self.scene("title: x\nbodies: &b [*b]\n"), says=["scene.yaml:2:", "levels"])
        good = GOOD.replace("shape: {sphere: {radius: 0.1}}", "shape: &ball {sphere: {radius: 0.1}}")
        good += "  - {shape: *ball, mass: 1, position: [1, 0, 1]}\n"
        self.good(self.scene(good), "results")

    def test_many_keys_and_deep_lists(self):
        self.refused(self.scene("\n".join(f"k{k}: 1" for k in range(30000)) + "\n"), says=["scene.yaml:1:", "an unknown key"])
        self.refused(self.scene("bodies: " + "[" * 100000 + "\n"), says=["scene.yaml"])

    def test_more_bodies_than_any_machine_holds(self):
        scene = self.scene("bodies:\n  - {lattice: {count: 1000000000000, columns: [10, 10], spacing: [1, 1, 1]},\n"
                           "     shape: {sphere: {radius: 0.1}}, mass: 1}\n")
        for ranks in (1, 2):
            self.refused(scene, ranks=ranks, says=["scene.yaml:2:", "key 'bodies[0].lattice.count'", "found 1000000000000",
                                                   f"the memory of {ranks} rank"])

    def test_more_bodies_than_the_memory_holds(self):
        scene = self.scene("bodies:\n  - {lattice: {count: 100000000, columns: [100, 100], spacing: [1, 1, 1]},\n"
                           "     shape: {sphere: {radius: 0.1}}, mass: 1}\n")
        self.within(4, lambda: self.refused(scene, says=["bodies[0].lattice.count", "found 100000000", "the memory of 2 ranks"]))

    def within(self, gigabytes, run):
        """Runs something whose processes may have that much memory each."""
        before = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (gigabytes << 30, before[1]))
        try:
            return run()
        finally:
            resource.setrlimit(resource.RLIMIT_AS, before)

    def test_memory_runs_out(self):
        """Bodies that could be held, but not moved: the run ends, on all ranks, and says with how many bodies."""
        scene = self.scene("time: {frames: 1}\nbodies:\n  - {lattice: {count: 3000000, columns: [100, 100], spacing: [1, 1, 1]},\n"
                           "     shape: {sphere: {radius: 0.1}}, mass: 1}\n")
        run = self.within(2, lambda: unibody(scene, "-output", self.folder / "results", ranks=1, timeout=60))
        self.assertEqual(run.code, 3, run.err)
        self.assertEqual(len(run.message), 1, run.err)
        self.assertIn("rank 0: out of memory, with 3000000 bodies on 1 rank", run.message[0])

    def test_cloth_of_a_missing_mesh(self):
        cloth = "cloths:\n  - {mesh: flag.obj, mass: 1, thickness: 0.1}\n"
        self.bad(("bodies:", cloth + "bodies:"), 4, "cloths[0].mesh", str(self.folder / "flag.obj") + ", which isn't there",
                 "an OBJ, STL, PLY, glTF or DAE file")

    def test_cloth_of_a_mesh_with_three_triangles_at_an_edge(self):
        (self.folder / "flag.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n")
        scene = self.scene(GOOD + "cloths:\n  - {mesh: flag.obj, mass: 1, thickness: 0.1}\n")
        self.refused(scene, says=["flag.obj: found triangles 0, 1 and 2 at the edge of nodes 0 and 1"])

    def test_missing_file(self):
        self.refused(self.folder / "nowhere.yaml", says=["nowhere.yaml"])

    def test_folder_as_a_scene(self):
        (self.folder / "folder").mkdir()
        self.refused(self.folder / "folder", says=["folder"])

    def test_not_yaml(self):
        self.refused(self.scene("title: x\ntime: {step: 1\nbodies: 3\n"), says=["scene.yaml:3:", "YAML"])

    def test_binary_file(self):
        path = self.folder / "scene.yaml"
        path.write_bytes(bytes(range(256)) * 64)
        self.refused(path, says=["scene.yaml"])

    def test_empty_file(self):
        self.refused(self.scene(""), says=["scene.yaml:1:"])


class BadOptions(RefusedTest):
    """Faults of the command line."""

    def test_sets(self):
        scene = self.scene(GOOD)
        for setting, says in (("time.frams=3", ["-set time.frams=3", "time.frams"]),
                              ("bodies[9].mass=1", ["-set bodies[9].mass=1", "expected"]),
                              ("bodies[1].mass=-2", ["-set bodies[1].mass=-2", "key 'bodies[1].mass'", "found -2", "expected"]),
                              ("..=1", ["-set"]), ("time.frames", ["-set", "time.frames", "path.to.key=value"]),
                              ("gravity=[0, 0", ["-set gravity=[0, 0", "YAML"])):
            with self.subTest(setting=setting):
                self.refused(scene, "-set", setting, says=says)

    def test_options(self):
        scene = self.scene(GOOD)
        for words, says in ((["-colour", "red"], ["-colour"]), (["-overwite"], ["-overwite"]), (["-set"], ["-set", "value"]),
                            (["-restart"], ["-restart", "value"]), (["-partition", "scotch"], ["-partition", "scotch", "metis"]),
                            (["-partition", "random:"], ["random:", "SEED"]), (["-partition", "random:-1"], ["random:-1"]),
                            (["-solver_level"], ["-solver_level", "value"]),
                            (["-solver_level", "speed"], ["key 'solver.level'", "found speed", "expected position or velocity"]),
                            (["-solver_level", "velocity", "-set", "solver.stages=two"], ["key 'solver.stages'", "found two", "auto"]),
                            (["-rebalance", "maybe"], ["-rebalance", "maybe", "on or off"]),
                            (["-shared_memory", "no"], ["-shared_memory", "no", "on or off"]), ([str(scene)], ["two scenes"]),
                            (["-sf_type", "bogus"], ["-sf_type bogus", "Unable to find requested PetscSF type bogus"])):
            with self.subTest(words=words):
                self.refused(scene, *words, says=says)

    def test_no_scene(self):
        run = unibody(ranks=2, timeout=60, folder=self.folder)
        self.assertEqual((run.code, len(run.message)), (2, 1), run.err)
        self.assertIn("no scene", run.message[0])
        self.assertEqual(tree(self.folder), {})

    def test_missing_petsc_options_file(self):
        self.refused(self.scene(GOOD), "-options_file", self.folder / "nowhere", says=["nowhere"])

    def test_petsc_options_beside_the_scene(self):
        """Nobody but PETSc knows which of its options take a value: a file is the scene until there is one."""
        scene = self.scene(GOOD, "ball.scene")
        info = self.folder / "info"
        options = self.folder / "options.yaml"
        options.write_text("log_view:\n")
        for n, words in enumerate((["-log_view", scene], [scene, "-log_view"], ["-info", info, scene], [scene, "-info", info],
                                   ["-options_file", options, scene], ["-log_view", "-options_file", options, scene])):
            with self.subTest(words=words):
                run = unibody(*words, "-output", self.folder / f"results_{n}", timeout=60, folder=self.folder)
                self.assertEqual((run.code, run.message), (0, []), run.err)
        for words, says in ((["-log_view", "nowhere.yaml"], "nowhere.yaml"), (["-options_file"], "a value is missing")):
            with self.subTest(words=words):
                run = unibody(*words, ranks=2, timeout=60, folder=self.folder)
                self.assertEqual((run.code, len(run.message)), (2, 1), run.err)
                self.assertIn(says, run.message[0])

    def test_petsc_options_that_petsc_does_not_know(self):
        """It takes any word; the run says which of them it made no use of."""
        run = unibody(self.scene(GOOD), "-output", self.folder / "results", "-log_veiw", "-vec_tpye", "standard")
        self.assertEqual(run.code, 0, run.err)
        self.assertEqual([line.split(": is it")[0] for line in sorted(run.message)],
                         [f"unibody: PETSc made no use of its option -{name}" for name in ("log_veiw", "vec_tpye")])

    def test_every_rank_returns_the_code(self):
        codes = self.folder / "codes"
        scene = self.scene(GOOD.replace("mass: 1", "mass: -1"))
        script = f"'{PROGRAM}' '{scene}' -output '{self.folder}/results'; code=$?; echo $code >> '{codes}'"
        run = execute([MPIEXEC, "-n", "3", "sh", "-c", script], timeout=60)
        self.assertEqual(run.code, 0, run.err)  # the shells' own
        self.assertEqual(codes.read_text().split(), ["2", "2", "2"])
        self.assertEqual(len(run.message), 1, run.err)


class BadOutput(RefusedTest):
    """Faults of the output folder and of the checkpoint to go on from."""

    def test_results_are_kept_without_overwrite(self):
        scene = self.scene(GOOD)
        self.good(scene, "results")
        for name in ("report.csv", "summary.json", "frames.h5", "frames.xdmf", "checkpoint.h5"):
            with self.subTest(left=name):
                for other in os.listdir(self.folder / "results"):
                    if other != name and name != "report.csv":
                        os.rename(self.folder / "results" / other, self.folder / other)
                self.refused(scene, output="results", says=["results/", "exists"])
                for other in ("report.csv", "summary.json", "frames.h5", "frames.xdmf", "checkpoint.h5"):
                    if (self.folder / other).exists():
                        os.rename(self.folder / other, self.folder / "results" / other)
        self.good(scene, "results", "-overwrite")

    def test_results_of_joints_are_results(self):
        """Without -overwrite they are kept; with it none of another run stays behind."""
        text = GOOD + "joints: [{type: rope, bodies: [1, world], points: [[0, 0, 0.3], [0, 0, 0.4]]}]\n"
        self.good(self.scene(text), "results", "-set", "output.joints=true")
        for name in ("joints.csv", "joints.h5"):
            self.good(self.scene(text), name, "-set", "output.joints=true")
            for other in os.listdir(self.folder / name):
                if other != name:
                    os.remove(self.folder / name / other)
            self.refused(self.scene(text), output=name, says=[name, "exists"])
        self.good(self.scene(text), "results", "-overwrite")
        self.assertFalse((self.folder / "results/joints.csv").exists() or (self.folder / "results/joints.h5").exists())

    def test_a_fault_with_overwrite_keeps_the_results(self):
        self.good(self.scene(GOOD), "results")
        self.refused(self.scene(GOOD.replace("mass: 1", "mass: -1"), "bad.yaml"), "-overwrite", output="results")
        self.refused(self.scene(GOOD), "-overwrite", "-restart", self.folder / "nowhere.h5", output="results", says=["nowhere.h5"])

    def test_a_second_run_into_the_same_folder(self):
        """It is refused while the first one runs; when that has been killed, it is not, whatever is left behind."""
        long = self.scene(GOOD.replace("frames: 5", "frames: 100000000"), "long.yaml")
        first = start(command([long, "-output", self.folder / "results"], 2))
        try:
            for _ in range(200):
                if (self.folder / "results/report.csv").exists():
                    break
                time.sleep(0.05)
            run = unibody(self.scene(GOOD), "-output", self.folder / "results", "-overwrite", timeout=60)
            self.assertEqual((run.code, len(run.message)), (2, 1), run.err)
            self.assertIn("another run, process ", run.message[0])
            self.assertTrue((self.folder / "results/frames.h5").exists())
        finally:
            subprocess.run(["pkill", "-9", "-f", str(long)], check=False)
            end(first)
        self.good(self.scene(GOOD), "results", "-overwrite")
        left = sorted(os.listdir(self.folder / "results"))
        self.assertEqual(left, ["checkpoint.h5", "frames.h5", "frames.xdmf", "report.csv", "summary.json"])

    def test_output_is_a_file(self):
        (self.folder / "file").write_text("precious")
        for output in ("file", "file/below"):
            with self.subTest(output=output):
                self.refused(self.scene(GOOD), output=output, says=[output])
                self.refused(self.scene(GOOD), "-overwrite", output=output, says=[output])

    def test_output_cannot_be_written(self):
        self.refused(self.scene(GOOD), output="/proc/unibody", says=["/proc/unibody"])
        if os.geteuid() != 0:  # root may write anywhere
            (self.folder / "locked").mkdir(mode=0o555)
            self.refused(self.scene(GOOD), output="locked", says=["locked"])
            self.refused(self.scene(GOOD), output="locked/below", says=["locked"])

    def test_restart_from_no_checkpoint(self):
        scene = self.scene(GOOD)
        (self.folder / "text.h5").write_text("no HDF5")
        self.refused(scene, "-restart", self.folder / "nowhere.h5", says=["nowhere.h5"])
        self.refused(scene, "-restart", self.folder / "text.h5", says=["text.h5"])
        self.refused(scene, "-restart", self.folder, says=[self.folder.name])


if __name__ == "__main__":
    unittest.main(verbosity=2)
