#!/usr/bin/python3
"""A run that is asked to stop keeps a checkpoint, says so, and goes on to the end that the straight run has."""
import json
import os
import signal
import subprocess
import time
import unittest

from unibody_runs import ProgramTest, command, start, unibody

SCENE = """
    time: {frame: 0.01, frames: 400, substeps: 2}
    output: {every: 0, checkpoint_every: 0}
    bodies:
      - container: {size: [1, 1]}
      - pile: {count: 400, columns: [6, 6], mix: [{shape: {sphere: {radius: 0.05}}, scale: [0.7, 1.2]}]}
        density: 2000
        position: [0, 0, 0.2]
"""


class Stopping(ProgramTest):
    def straight(self, scene):
        return self.good(scene, "straight").state

    def assert_stopped(self, output, code, reason):
        self.assertEqual(code, 4)
        self.assertRegex(output, rf"(?m)^stopped as asked by {reason} after frame \d+ of 400: it goes on with -restart \S+/checkpoint.h5$")
        summary = json.loads((self.folder / "part/summary.json").read_text())
        self.assertEqual(summary["status"], f"stopped as asked by {reason}")
        self.assertLess(summary["last_frame"], 400)
        return summary["last_frame"]

    def test_a_signal(self):
        scene = self.scene(SCENE)
        expected = self.straight(scene)
        for name, to_all in (("TERM", True), ("INT", True), ("USR1", False)):
            with self.subTest(signal=name):
                run = start(command([scene, "-output", self.folder / "part", "-overwrite"], 2))
                while not (self.folder / "part/report.csv").is_file() or \
                        (self.folder / "part/report.csv").read_text().count("\n") < 5:
                    time.sleep(0.02)
                if to_all:  # what mpirun itself does with these is to kill
                    subprocess.run(["pkill", f"-{name}", "-P", str(run.pid)], check=True)
                else:
                    os.kill(run.pid, signal.SIGUSR1)  # mpirun hands it on
                output = run.communicate(timeout=120)[0]
                self.assert_stopped(output, run.returncode, f"SIG{name}")
                rest = self.good(scene, "rest", "-restart", self.folder / "part/checkpoint.h5", "-overwrite", ranks=3)
                self.assertEqual(rest.state, expected)
                for file in (self.folder / "part").iterdir():
                    file.unlink()

    def test_a_limit_of_time(self):
        scene = self.scene(SCENE)
        started = time.monotonic()
        expected = self.straight(scene)
        limit = 0.4 * (time.monotonic() - started)  # of however long this machine takes for all of it
        run = unibody(scene, "-output", self.folder / "part", "-wall_limit", f"{limit:.3f}s")
        frame = self.assert_stopped(run.out, run.code, "-wall_limit")
        self.assertGreater(frame, 0)
        rest = self.good(scene, "rest", "-restart", self.folder / "part/checkpoint.h5")
        self.assertEqual(rest.state, expected)
        self.assertEqual(unibody(scene, "-output", self.folder / "all", "-wall_limit", "1h2m3.5s").code, 0)

    def test_nobody_reads_on(self):
        scene = self.scene(SCENE)
        run = start(command([scene, "-output", self.folder / "alone", "-set", "time.frames=60"], 1))
        run.stdout.readline()
        run.stdout.close()
        self.assertEqual(run.wait(timeout=60), 0)
        self.assertEqual(run.stderr.read(), "")
        run.stderr.close()
        state = json.loads((self.folder / "alone/summary.json").read_text())["state_hash"]
        self.assertEqual(state, self.good(scene, "read", "-set", "time.frames=60").state)

    def test_checkpoints_by_wall_time(self):
        scene = self.scene(SCENE)
        run = start(command([scene, "-output", self.folder / "part", "-set", "output.checkpoint_minutes=0.0005"], 2))
        checkpoint = self.folder / "part/checkpoint.h5"
        deadline = time.monotonic() + 60
        while not checkpoint.is_file() and time.monotonic() < deadline and run.poll() is None:
            time.sleep(0.01)
        self.assertIsNone(run.poll(), "the run has ended, whose only other checkpoint is at its end")
        subprocess.run(["pkill", "-KILL", "-P", str(run.pid)], check=True)
        run.communicate(timeout=60)
        rest = self.good(scene, "part", "-restart", "auto", ranks=3)
        self.assertEqual(rest.state, self.straight(scene))

    def test_without_checkpoints_it_says_so(self):
        scene = self.scene(SCENE)
        run = unibody(scene, "-output", self.folder / "part", "-wall_limit", "0.3s", "-set", "output.checkpoint_every=-1")
        self.assertEqual(run.code, 4)
        self.assertIn("output.checkpoint_every is -1, so that there is no checkpoint to go on from", run.out)
        self.assertFalse((self.folder / "part/checkpoint.h5").exists())

    def test_times_that_are_none(self):
        scene = self.scene(SCENE)
        for text in ("5x", "h", "-3", "0", "1e99", "3h-1m", ""):
            run = unibody(scene, "-output", self.folder / "none", "-wall_limit", text)
            self.assertEqual(run.code, 2, text)
            self.assertIn(f"option -wall_limit: found '{text}', expected a time as 3h55m, 90m, 45s or 3600 (s), more than 0", run.err)
        self.assertFalse((self.folder / "none").exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
