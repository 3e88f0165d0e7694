#!/usr/bin/python3
"""A run that goes on from a checkpoint ends in the bits of the run that never stopped, on any number of ranks."""
import csv
import os
import shutil
import signal
import time
import unittest

import h5py

from restart_scenes import BREAKING, CLOTH, GEARED, JOINTED, PERIODIC, PILE, TIED, TRIAXIAL
from unibody_runs import SCENES, ProgramTest, command, comparable, contents, end, is_hydra, start, tree, unibody


def frame_of(checkpoint):
    with h5py.File(checkpoint, "r") as file:
        return int(file.attrs["frame"])


class Restart(ProgramTest):
    def first_half(self, scene, *options, ranks=2, frames=30):
        self.good(scene, "half", *options, "-set", f"time.frames={frames}", ranks=ranks)
        checkpoint = self.folder / "half" / "checkpoint.h5"
        self.assertEqual(frame_of(checkpoint), frames)
        return checkpoint

    def check(self, *options, ranks=(1, 3), text=PILE, change="bodies[2].velocity=[0, 0, -2]"):
        scene = self.scene(text)
        whole = self.check_runs(scene, *options, ranks=ranks, half=30, written=["000040", "000060"])
        self.assertNotEqual(self.good(scene, "changed", *options, "-set", change).state, whole.state)

    def check_runs(self, scene, *options, ranks, half, written):
        whole = self.good(scene, "whole", *options, ranks=2)
        checkpoint = self.first_half(scene, *options, frames=half)
        rows = comparable(self.folder / "whole/report.csv")
        for n in ranks:
            with self.subTest(ranks=n):
                name = f"rest_{n}"
                rest = self.good(scene, name, "-restart", checkpoint, *options, ranks=n)
                self.assertEqual(rest.state, whole.state)
                self.assertEqual(contents(self.folder / name / "checkpoint.h5"), contents(self.folder / "whole/checkpoint.h5"))
                self.assertEqual(comparable(self.folder / name / "report.csv"), [rows[0], *rows[half + 1:]])
                with h5py.File(self.folder / name / "frames.h5") as a, h5py.File(self.folder / "whole/frames.h5") as b:
                    self.assertEqual(list(a["frames"]), written)
                    for frame in a["frames"]:
                        for field in a["frames"][frame]:
                            self.assertTrue((a["frames"][frame][field][:] == b["frames"][frame][field][:]).all(), field)
        return whole

    def test_accelerated_jacobi(self):
        self.check()

    def test_gauss_seidel_and_substeps(self):
        self.check("-set", "time.substeps=3", "-set", "solver.name=gauss_seidel", "-set", "solver.iterations=20")

    def test_warm_started_position_stage(self):
        self.check("-set", "solver.stages=position", "-set", "solver.name=jacobi", ranks=(3,))

    def test_wet_grains(self):
        self.check("-set", "materials.stone.liquid_volume=1.0e-5", "-set", "materials.stone.surface_tension=20", ranks=(3,))
        with open(self.folder / "whole/report.csv", newline="") as file:
            self.assertGreater(max(int(row["liquid_bridges (1)"]) for row in csv.DictReader(file)), 20)

    def test_velocity_level(self):
        self.check("-solver_level", "velocity", "-set", "solver.warm_start=0.7", ranks=(3,))

    def test_another_level_is_refused(self):
        self.check_refused(PILE, ("solver.level=velocity",))

    def test_cloth_and_thread(self):
        self.check(text=CLOTH, change="cloths[0].links.stiffness=3001")

    def test_tied_bodies_in_the_wind(self):
        self.check(text=TIED, change="wind=[1, 0, 2.1]")

    def test_a_periodic_scene(self):
        self.check(text=PERIODIC, change="bodies[1].position=[0.01, 0.01, 0]")
        with h5py.File(self.folder / "whole/frames.h5") as file:
            places = file["frames/000060/position"][:]
            self.assertTrue(((places[:, :2] >= [0, -.3]) & (places[:, :2] <= [.6, .3])).all())
        with open(self.folder / "whole/report.csv", newline="") as file:
            self.assertGreater(sum(float(row["flux_count (1)"]) for row in csv.DictReader(file)), 20)

    def test_another_period_is_refused(self):
        self.check_refused(PERIODIC, ("periodic.x=[0, 0.7]", "periodic.x=[0.1, 0.7]"))

    def test_jointed_bodies(self):
        self.check(text=JOINTED, change="joints[0].motor.max_torque=5.1")

    def test_geared_bodies(self):
        self.check(text=GEARED, change="couplings[0].ratio=-0.71")

    def test_other_gears_are_refused(self):
        self.check_refused(GEARED, ("joints[1].spring.damping=0.2", "bodies[4].collide.with=[load]", "bodies[0].centre_of_mass=[0.2, 0, 0]"))

    def test_geared_bodies_by_gauss_seidel(self):
        self.check("-set", "solver.name=gauss_seidel", text=GEARED, change="joints[2].spring.rest=0.2", ranks=(3,))

    def test_a_triaxial_cell(self):
        self.check(text=TRIAXIAL, change="bodies[0].triaxial.x.pressure=3001")

    def check_breaking(self, *options):
        self.check(*options, text=BREAKING, change="bonds[0].strength.torque=200")
        whole = (self.folder / "whole/breaks.csv").read_text()
        times = [float(line.split(",")[0]) for line in whole.splitlines()[1:]]
        self.assertGreater(sum(t < 0.48 for t in times), 3)
        self.assertGreater(sum(t > 0.49 for t in times), 0)
        self.assertEqual((self.folder / "rest_3/breaks.csv").read_text(), whole)
        with h5py.File(self.folder / "rest_3/joints.h5") as a, h5py.File(self.folder / "whole/joints.h5") as b:
            self.assertTrue((a["frames/000060"][:] == b["frames/000060"][:]).all())
            self.assertEqual(a["frames/000060"][:, 13].sum(), len(times))

    def test_breaking_bonds(self):
        self.check_breaking()

    def test_breaking_bonds_by_gauss_seidel(self):
        self.check_breaking("-set", "solver.name=gauss_seidel", "-set", "solver.joints=direct")

    def test_other_bonds_are_refused(self):
        self.check_refused(BREAKING, ("bonds[0].strength.force=4100", "bonds[0].strength.duration=0.03", "events[0].when.time=0.6"))

    def test_jointed_bodies_by_gauss_seidel(self):
        self.check("-set", "solver.name=gauss_seidel", text=JOINTED, change="joints[0].friction=1.1", ranks=(3,))

    def test_other_joints_are_refused(self):
        self.check_refused(JOINTED, ("joints[0].motor.speed=41", "joints[0].friction=2", "joints[1].limits=[-1, 0.2]", "bodies[2].chain.held=none"))

    # From the middle of the impact: sheets lie on each other and on themselves, and the guard holds pairs before and after.
    def test_sheets_on_sheets_and_on_themselves(self):
        self.check_runs(SCENES / "cloth_stack.yaml", "-set", "time.frames=27", "-set", "output.every=1", ranks=(1, 3), half=25,
                        written=["000025", "000026", "000027"])
        with open(self.folder / "whole/report.csv", newline="") as file:
            held = [int(row["held_pairs (1)"]) for row in csv.DictReader(file)]
        self.assertGreater(sum(held[:25]), 0)
        self.assertGreater(sum(held[25:]), 0)

    def test_a_hanging_cloth_with_a_coarse_level(self):
        self.check_runs(SCENES / "cloth_hanging.yaml", "-set", "time.frames=20", "-set", "output.every=10", "-set", "solver.coarse=true",
                        ranks=(1, 3), half=10, written=["000010", "000020"])

    def test_another_cloth_is_refused(self):
        self.check_refused(CLOTH, ("cloths[0].links.stiffness=3001", "cloths[0].bending.damping=0.1", "cloths[0].pins[1].release=0.8",
                                   "cloths[0].self_collision=true", "cloths[0].thickness=0.06", "cloths[0].position=[0, 0, 0.36]"))

    def test_other_bodies_are_refused(self):
        self.check_refused(PILE, ("materials.stone.friction=[[0.2, 0.6], [0.7, 0.2]]", "materials.stone.stiction=0.2",
                                  "materials.stone.adhesion=3", "materials.stone.stiffness=3.0e+5", "materials.stone.damping_ratio=0.4", "materials.stone.liquid_volume=1.0e-5", "materials.stone.adhesion_range=0.001",
                                  "bodies[1].surface_velocity=[0, {expression: \"t > 0.3 ? sin(5 * t) : 0\"}, 0]", "bodies[1].surface_angular_velocity=[0, 0, 1]", "bodies[1].anisotropic_friction={axis: [1, 0, 0], across: 0.5}", "bodies[2].density=2700", "bodies[2].velocity=[0, 0, -2]", "bodies[1].path=[0, 0, [[0.3, 0], [0.7, 0.2]]]",
                                  "bodies[1].shape.box.size=[0.2, 0.9, 0.3]", "bodies[2].force=[0, 0, 1]"))

    def test_other_ties_or_another_wind_are_refused(self):
        self.check_refused(TIED, ("cloths[0].pins[1].to=weight", "cloths[0].pins[2].to=crank", "cloths[0].pins[2].release=1",
                                  "cloths[0].drag=1.1", "cloths[0].pressure=2", "wind=[1, 0, 1]", "wind=[1, 0, [[0, 0], [1, 1]]]", "air_density=1"))

    def check_refused(self, text, settings):
        scene = self.scene(text)
        checkpoint = self.first_half(scene)
        for setting in settings:
            with self.subTest(setting=setting):
                run = unibody(scene, "-output", self.folder / "rest", "-restart", checkpoint, "-set", setting, timeout=60)
                self.assertEqual(run.code, 2, run.err)
                self.assertIn(str(checkpoint), run.message[0])

    def test_another_scene_or_setting_is_refused(self):
        scene = self.scene(PILE)
        checkpoint = self.first_half(scene)
        other = self.scene(PILE.replace("count: 60", "count: 61"), "other.yaml")
        before = tree(self.folder)
        for path, setting in ((other, []), (scene, ["gravity=[0, 0, -1.62]"]), (scene, ["solver.name=gauss_seidel"]),
                              (scene, ["solver.iterations=51"]), (scene, ["time.frame=0.01"]), (scene, ["time.substeps=2"]),
                              (scene, ["materials.stone.friction=0.41"]), (scene, ["solver.friction=box"]),
                              (scene, ["solver.acceleration=nesterov"]), (scene, ["solver.mass_sharing=count"]), (scene, ["solver.leak=0.25"]), (scene, ["solver.velocity_share=0.6"])):
            with self.subTest(path=path.name, setting=setting):
                options = [word for text in setting for word in ("-set", text)]
                run = unibody(path, "-output", self.folder / "rest", "-restart", checkpoint, *options, timeout=60)
                self.assertEqual(run.code, 2, run.err)
                self.assertEqual(len(run.message), 1, run.err)
                self.assertIn(str(checkpoint), run.message[0])
                self.assertEqual(tree(self.folder), before, "something was written")
        # What is written, and how long the run is, may change.
        self.good(scene, "rest", "-restart", checkpoint, "-set", "output.every=7", "-set", "time.frames=33", "-set", "title=other")

    def test_other_settings_may_start_from_a_state_but_no_other_bodies(self):
        scene = self.scene(PILE)
        checkpoint = self.first_half(scene)
        same = self.good(scene, "same", "-start_from", checkpoint)
        self.assertEqual(same.state, self.good(scene, "rest", "-restart", checkpoint).state)
        other = self.good(scene, "other", "-start_from", checkpoint, "-set", "solver.name=gauss_seidel", "-set", "time.substeps=2")
        self.assertNotEqual(other.state, same.state)
        for setting in ("gravity=[0, 0, -1.62]", "materials.stone.friction=0.41"):
            with self.subTest(setting=setting):
                run = unibody(scene, "-output", self.folder / "bad", "-start_from", checkpoint, "-set", setting, timeout=60)
                self.assertEqual(run.code, 2, run.err)
                self.assertIn(str(checkpoint), run.message[0])

    def test_damaged_checkpoints_are_refused(self):
        scene = self.scene(PILE)
        checkpoint = self.first_half(scene)
        whole = contents(checkpoint)
        for share in (0, 0.1, 0.5, 0.9):
            with self.subTest(share=share):
                cut = self.folder / "cut.h5"
                cut.write_bytes(whole[:int(share * len(whole))])
                before = tree(self.folder)
                run = unibody(scene, "-output", self.folder / "rest", "-restart", cut, timeout=60)
                self.assertEqual(run.code, 2, run.err)
                self.assertEqual(len(run.message), 1, run.err)
                self.assertIn(str(cut), run.message[0])
                self.assertEqual(tree(self.folder), before, "something was written")

    def test_a_changed_bit_is_found(self):
        scene = self.scene(PILE)
        checkpoint = self.first_half(scene)
        good = contents(checkpoint)
        with h5py.File(checkpoint, "r") as file:
            tables = [file["bodies"], file["multipliers/key"], file["multipliers/point"]]
            middles = [table.id.get_offset() + table.id.get_storage_size() // 2 for table in tables]
        for middle in middles:
            with self.subTest(byte=middle):
                changed = self.folder / "changed.h5"
                changed.write_bytes(good[:middle] + bytes([good[middle] ^ 1]) + good[middle + 1:])
                before = tree(self.folder)
                run = unibody(scene, "-output", self.folder / "rest", "-restart", changed, ranks=3, timeout=60)
                self.assertEqual((run.code, len(run.message)), (2, 1), run.err)
                self.assertIn(f"'{changed}' is damaged", run.message[0])
                self.assertIn("bits have changed", run.message[0])
                self.assertEqual(tree(self.folder), before, "something was written")

    def test_a_killed_run_can_go_on(self):
        """Killed again and again while it writes a checkpoint a frame: what it leaves is always whole."""
        scene = self.scene(PILE)
        options = ["-set", "output.checkpoint_every=1", "-set", "output.every=0"]
        whole = self.good(scene, "whole", *options, ranks=2)
        for attempt in range(3):
            output = self.folder / f"killed_{attempt}"
            process = start(command([scene, "-output", output, *options, "-set", "time.frames=100000"], 2))
            deadline = time.monotonic() + 60
            while not (output / "checkpoint.h5").exists() and time.monotonic() < deadline:
                time.sleep(0.01)
            time.sleep(0.05 + 0.037 * attempt)
            ranks = ranks_of(process.pid)
            self.assertEqual(len(ranks), 2, "mpirun has other children than the two ranks")
            for rank in ranks:
                os.kill(rank, signal.SIGKILL)
            end(process)
            frame = frame_of(output / "checkpoint.h5")
            self.assertGreater(frame, 0)
            self.assertFalse((output / "summary.json").exists())
            last = max(60, frame + 5)
            expected = whole
            if last != 60:  # the machine was faster than foreseen
                expected = self.good(scene, f"long_{attempt}", *options, "-set", f"time.frames={last}")
            rest = self.good(scene, f"rest_{attempt}", "-restart", output / "checkpoint.h5", *options, "-set",
                             f"time.frames={last}", ranks=1 + attempt)
            self.assertEqual(rest.state, expected.state)

    def test_in_the_same_folder(self):
        scene = self.scene(PILE)
        whole = self.good(scene, "whole")
        checkpoint = self.first_half(scene)
        kept = shutil.copy(checkpoint, self.folder / "kept.h5")
        refused = unibody(scene, "-output", self.folder / "half", "-restart", kept, timeout=60)
        self.assertEqual(refused.code, 2, "the first half's results would be lost")
        self.assertEqual(contents(checkpoint), contents(kept))
        self.assertEqual(self.good(scene, "half", "-overwrite", "-restart", checkpoint).state, whole.state)
        self.assertEqual(frame_of(checkpoint), 60)

    def test_from_the_start(self):
        """A run of no frames ends with a checkpoint too: the state at the start."""
        scene = self.scene(PILE)
        self.check_runs(scene, ranks=(1, 3), half=0, written=["000000", "000020", "000040", "000060"])

    def test_nothing_left_to_do(self):
        """A checkpoint of the last frame, or of a later one: no frame is run, and the state is the checkpoint's."""
        scene = self.scene(PILE)
        self.first_half(scene)
        for frames, code in ((30, 0), (20, 2)):
            with self.subTest(frames=frames):
                run = unibody(scene, "-output", self.folder / f"rest_{frames}", "-restart", self.folder / "half/checkpoint.h5",
                              "-set", f"time.frames={frames}", timeout=60)
                self.assertEqual(run.code, code, run.err)
                if code == 0:
                    self.assertEqual(contents(self.folder / "rest_30/checkpoint.h5"), contents(self.folder / "half/checkpoint.h5"))
                    self.assertEqual(run.state, unibody(scene, "-output", self.folder / "again", "-set", "time.frames=30").state)
                else:
                    self.assertIn("frame 30", run.message[0])
                    self.assertFalse((self.folder / "rest_20").exists())


def ranks_of(pid):
    """The ranks of an mpirun: what it has started, or what another process has that it has started."""
    found = children(pid)
    return [rank for child in found for rank in children(child)] if is_hydra() else found


def children(pid):
    with open(f"/proc/{pid}/task/{pid}/children") as file:
        listed = {int(word) for word in file.read().split()}
    # Some kernels give no list: then all processes are asked for their parent.
    for name in os.listdir("/proc"):
        if name.isdigit():
            try:
                with open(f"/proc/{name}/stat") as file:
                    if int(file.read().rsplit(")", 1)[1].split()[1]) == pid:
                        listed.add(int(name))
            except OSError:
                pass
    return sorted(listed)


if __name__ == "__main__":
    unittest.main(verbosity=2)
