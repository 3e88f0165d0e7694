#!/usr/bin/python3
"""A run that goes on in its own folder leaves there what the straight run leaves."""
import csv
import os
import pty
import random
import shutil
import signal
import time
import unittest

import h5py

from restart import JOINTED, PILE, frame_of, ranks_of
from unibody_runs import (MPIEXEC, ENVIRONMENT, PROGRAM, ProgramTest, command, comparable, contents, end, is_hydra, start, tree,
                          unibody)

EVERY = ["-set", "output.every=5", "-set", "output.checkpoint_every=10"]


class Continuing(ProgramTest):
    def assert_same_results(self, name, straight):
        a, b = self.folder / name, self.folder / straight
        self.assertEqual(comparable(a / "report.csv"), comparable(b / "report.csv"))
        self.assertEqual(contents(a / "frames.xdmf"), contents(b / "frames.xdmf"))
        self.assertEqual(contents(a / "checkpoint.h5"), contents(b / "checkpoint.h5"))
        with h5py.File(a / "frames.h5") as one, h5py.File(b / "frames.h5") as other:
            self.assertEqual(list(one["frames"]), list(other["frames"]))
            for frame in one["frames"]:
                self.assertEqual(dict(one["frames"][frame].attrs), dict(other["frames"][frame].attrs))
                for field in one["frames"][frame]:
                    self.assertTrue((one["frames"][frame][field][:] == other["frames"][frame][field][:]).all(), field)

    def crashed(self, scene, *options):
        """A folder as a run leaves it that was killed in frame 38: its checkpoint is of frame 30."""
        self.good(scene, "early", *options, "-set", "time.frames=30")
        self.good(scene, "part", *options, "-set", "time.frames=37")
        shutil.copy(self.folder / "early/checkpoint.h5", self.folder / "part/checkpoint.h5")
        (self.folder / "part/summary.json").unlink()
        with open(self.folder / "part/report.csv", "a", encoding="ascii") as file:
            file.write("38,0.60")  # half of a line
        return self.folder / "part"

    def test_a_crashed_run(self):
        scene = self.scene(PILE)
        straight = self.good(scene, "straight", *EVERY)
        for ranks, restart in ((1, "auto"), (3, None)):
            with self.subTest(ranks=ranks):
                part = self.crashed(scene, *EVERY)
                run = self.good(scene, "part", *EVERY, "-restart", restart or part / "checkpoint.h5", ranks=ranks)
                self.assertEqual(run.state, straight.state)
                self.assert_same_results("part", "straight")
                shutil.rmtree(part), shutil.rmtree(self.folder / "early")

    def test_joints(self):
        scene = self.scene(JOINTED)
        options = [*EVERY, "-set", "output.joints=true"]
        straight = self.good(scene, "straight", *options)
        self.crashed(scene, *options)
        self.assertEqual(self.good(scene, "part", *options, "-restart", "auto").state, straight.state)
        self.assert_same_results("part", "straight")
        for name in ("joints.csv",):
            self.assertEqual(contents(self.folder / "part" / name), contents(self.folder / "straight" / name))
        with h5py.File(self.folder / "part/joints.h5") as one, h5py.File(self.folder / "straight/joints.h5") as other:
            self.assertEqual(list(one["frames"]), list(other["frames"]))
            for frame in one["frames"]:
                self.assertTrue((one["frames"][frame][:] == other["frames"][frame][:]).all())

    def test_auto_starts_where_there_is_nothing(self):
        scene = self.scene(PILE)
        straight = self.good(scene, "straight")
        self.assertEqual(self.good(scene, "new", "-restart", "auto").state, straight.state)
        self.assertEqual(self.good(scene, "new", "-restart", "auto").state, straight.state)  # nothing is left to do
        self.assert_same_results("new", "straight")

    def test_auto_loses_no_results_that_have_no_checkpoint(self):
        scene = self.scene(PILE)
        self.good(scene, "old", "-set", "output.checkpoint_every=-1")
        before = tree(self.folder / "old")
        refused = unibody(scene, "-output", self.folder / "old", "-restart", "auto")
        self.assertEqual((refused.code, len(refused.message)), (2, 1), refused.err)
        self.assertEqual(tree(self.folder / "old"), before)
        self.good(scene, "old", "-restart", "auto", "-overwrite")
        self.assertEqual(frame_of(self.folder / "old/checkpoint.h5"), 60)

    def test_other_columns_or_another_precision_lose_nothing(self):
        scene = self.scene(PILE)
        part = self.crashed(scene, *EVERY)
        before = tree(part)
        for change, told in ((["-error_estimate"], "report.csv' has other columns"),
                             (["-set", "output.precision=single"], "output.precision"),
                             (["-set", "bodies[2].density=2000"], "another scene")):
            with self.subTest(told=told):
                run = unibody(scene, "-output", part, *EVERY, "-restart", "auto", *change)
                self.assertEqual((run.code, len(run.message)), (2, 1), run.err)
                self.assertIn(told, run.message[0])
                self.assertEqual(tree(part), before)

    def test_damaged_files_are_set_aside(self):
        scene = self.scene(JOINTED)
        options = [*EVERY, "-set", "output.joints=true", "-set", "output.contacts=5"]
        straight = self.good(scene, "straight", *options)
        part = self.crashed(scene, *options)
        whole = contents(part / "contacts.h5")
        for attempt, kept in ((1, "frames-damaged.h5"), (2, "frames-damaged-2.h5")):
            for name in ("frames.h5", "joints.h5"):
                data = (part / name).read_bytes()
                (part / name).write_bytes(data[: len(data) // 2])
            damaged = contents(part / "frames.h5")
            run = self.good(scene, "part", *options, "-restart", "auto", ranks=attempt)
            self.assertEqual(run.state, straight.state)
            warnings = [line for line in run.err.splitlines() if "damaged" in line]
            self.assertEqual(len(warnings), 2, run.err)
            self.assertIn("frames.h5' is damaged", warnings[0])
            self.assertIn(kept, warnings[0])
            self.assertIn("joints.h5' is damaged", warnings[1])
            self.assertEqual(contents(part / kept), damaged)
            first = 30 if attempt == 1 else 60
            with h5py.File(part / "frames.h5") as file:
                self.assertEqual([int(frame) for frame in file["frames"]], list(range(first, 61, 5)))
            with h5py.File(part / "joints.h5") as file:
                self.assertEqual([int(frame) for frame in file["frames"]], list(range(first + 5, 61, 5)))
        self.assertEqual(contents(part / "joints.csv"), contents(self.folder / "straight/joints.csv"))
        self.assertGreater(len(contents(part / "contacts.h5")), len(whole))  # it was whole, and went on

    def test_killed_again_and_again(self):
        """SIGKILL of any rank at any moment, writes included; `-restart auto` until the run has come to its end. UNIBODY_KILLS=100 does
        so a hundred times."""
        kills, moments = int(os.environ.get("UNIBODY_KILLS", "8")), random.Random(5)
        frames = 40 * kills
        scene = self.scene(JOINTED)
        options = ["-set", "output.every=1", "-set", "output.checkpoint_every=1", "-set", "output.joints=true",
                   "-set", "output.contacts=1", "-set", f"time.frames={frames}"]
        straight = self.good(scene, "straight", *options, timeout=300)
        checkpoint, report = self.folder / "part/checkpoint.h5", self.folder / "part/report.csv"
        words = [scene, "-output", self.folder / "part", *options, "-restart", "auto", "-overwrite"]
        for attempt in range(kills):
            before = frame_of(checkpoint) if checkpoint.exists() else -1
            process = start(command(words, 2))
            while process.poll() is None and not (checkpoint.exists() and frame_of(checkpoint) > before):
                time.sleep(0.002)
            if process.poll() is not None:
                self.fail(f"run {attempt} ended by itself: {process.communicate()}")
            time.sleep(moments.uniform(0, 0.1))
            os.kill(moments.choice(ranks_of(process.pid)), signal.SIGKILL)
            end(process)
            computed = int(report.read_text(encoding="utf-8").rpartition("\n")[0].splitlines()[-1].split(",")[0])
            self.assertGreaterEqual(frame_of(checkpoint), max(before, computed - 1), f"kill {attempt} lost more than one frame")
        self.assertLess(frame_of(checkpoint), frames, "the machine was faster than foreseen: no run was killed at work")
        self.assertEqual(unibody(*words, timeout=300).state, straight.state)
        self.assert_same_results("part", "straight")
        self.assertEqual(contents(self.folder / "part/joints.csv"), contents(self.folder / "straight/joints.csv"))
        for name in ("joints.h5", "contacts.h5"):
            with h5py.File(self.folder / "part" / name) as one, h5py.File(self.folder / "straight" / name) as other:
                self.assertEqual(list(one["frames"]), list(other["frames"]))


class ProgressLines(ProgramTest):
    SCENE = """
        time: {frame: 0.01, frames: 200}
        output: {every: 0, checkpoint_every: -1}
        bodies:
          - {shape: {sphere: {radius: 0.1}}, mass: 1}
    """

    def test_a_file_gets_plain_lines(self):
        scene, begin = self.scene(self.SCENE), time.time()
        run = self.good(scene, "out")
        took = time.time() - begin
        self.assertNotIn("\r", run.out)
        self.assertNotIn("\033", run.out)
        lines = [line for line in run.out.splitlines() if line.startswith("frame ")]
        self.assertLessEqual(len(lines), 1 + took // 5)  # one every five seconds, and the last
        self.assertTrue(lines[-1].startswith("frame 200/200 "), lines)

    def test_a_terminal_gets_a_bar(self):
        for words in ([PROGRAM], *([] if is_hydra() else [[MPIEXEC, "-n", "2", PROGRAM]])):
            with self.subTest(words=words):
                own, other = pty.openpty()
                scene = self.scene(self.SCENE)
                child = os.posix_spawnp(words[0], [*words, str(scene), "-output", str(self.folder / words[0].split("/")[-1])],
                                        ENVIRONMENT, file_actions=[(os.POSIX_SPAWN_DUP2, other, 1),
                                                                 (os.POSIX_SPAWN_OPEN, 2, os.devnull, os.O_WRONLY, 0)])
                os.close(other)
                text = b""
                try:
                    while part := os.read(own, 65536):
                        text += part
                except OSError:  # the other end is closed
                    pass
                os.close(own)
                self.assertEqual(os.waitpid(child, 0)[1], 0)
                self.assertIn(b"\r\033[K[####################] frame 200/200 ", text)


class Options(ProgramTest):
    SCENE = """
        time: {frame: 0.01, frames: 2}
        bodies:
          - {shape: {sphere: {radius: 0.1}}, mass: 1}
    """

    def test_two_dashes_and_short_names(self):
        scene = self.scene(self.SCENE)
        run = unibody("--set", "time.frames=3", scene, "-o", self.folder / "out", "--partition", "random:5", ranks=1)
        self.assertEqual(run.code, 0, run.err)
        with open(self.folder / "out/report.csv", newline="", encoding="ascii") as file:
            self.assertEqual(len(list(csv.reader(file))), 4)
        self.assertEqual(unibody(scene, "-o", self.folder / "out", "--overwrite", ranks=1).code, 0)
        for word in ("-h", "--help", "-help"):
            self.assertIn("usage: mpirun", unibody(word, ranks=1).out)
        self.assertIn("unibody 0.", unibody("--version", ranks=1).out)

    def test_did_you_mean(self):
        scene = self.scene(self.SCENE)
        for word, meant in (("-ouptut", "-output"), ("--overwrit", "-overwrite"), ("-restrat", "-restart")):
            run = unibody(scene, word, ranks=1)
            self.assertEqual(run.code, 2)
            self.assertIn(f"(did you mean {meant}?)", run.message[0])


if __name__ == "__main__":
    unittest.main()
