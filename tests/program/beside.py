#!/usr/bin/python3
"""Runs beside each other on one machine, and after runs that were killed: none stops another one, or leaves anything behind that does."""
import ctypes
import os
import random
import signal
import subprocess
import time
import unittest

from unibody_runs import ENVIRONMENT, ProgramTest, command, end, start

SCENE = """
    time: {frames: FRAMES}
    output: {checkpoint_every: 1}
    bodies:
      - container: {size: [0.5, 0.5]}
      - lattice: {count: 40, columns: [2, 2], spacing: [0.2, 0.2, 0.2], height: 0.15, jitter: 0.01}
        shape: {sphere: {radius: 0.09}}
        mass: 1
"""
RESULTS = ["checkpoint.h5", "frames.h5", "frames.xdmf", "report.csv", "summary.json"]


def locked_semaphore(name):
    """A semaphore of the machine that nobody will ever release, as a run that was killed leaves it behind."""
    library = ctypes.CDLL(None, use_errno=True)
    library.sem_open.restype = ctypes.c_void_p
    made = library.sem_open(name.encode(), os.O_CREAT, ctypes.c_uint(0o644), ctypes.c_uint(0))
    assert made, os.strerror(ctypes.get_errno())
    return lambda: library.sem_unlink(name.encode())


class Beside(ProgramTest):
    def scene_of(self, frames):
        return self.scene(SCENE.replace("FRAMES", str(frames)), f"scene_{frames}.yaml")

    def test_semaphores_that_a_killed_run_holds(self):
        """Open MPI names one after the base name of each file: those of all that a run writes are locked."""
        for name in ("frames.h5", "checkpoint.h5", "checkpoint.h5.part", "joints.h5"):
            self.addCleanup(locked_semaphore(f"/OMPIO_{name}"))
        for ranks in (1, 2, 3):
            self.good(self.scene_of(3), f"results_{ranks}", ranks=ranks, timeout=60)

    def test_a_run_without_mpirun_needs_no_folder_of_open_mpi(self):
        """Which runs that end would remove under those that start: here no such folder can be made."""
        occupied = self.folder / "a_file"
        occupied.write_text("")
        environment = dict(ENVIRONMENT, OMPI_MCA_orte_tmpdir_base=str(occupied))
        output = self.folder / "results"
        process = start(command([self.scene_of(3), "-output", output], 1), environment=environment)
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, err)
        self.assertEqual(out.strip().splitlines()[-1], f"state {self.good(self.scene_of(3), 'good').state}")
        self.assertEqual(sorted(os.listdir(output)), RESULTS)

    def test_after_runs_that_were_killed(self):
        """At moments of all kinds (seed 7), at the hardest: afterwards runs end, in the same folder too, and nothing is left there."""
        moments = random.Random(7)
        scene, good = self.scene_of(100000), self.good(self.scene_of(3), "good")
        for k in range(16):
            process = start(command([scene, "-output", self.folder / "results", "-overwrite"], 2))
            time.sleep(moments.uniform(0.2, 1.0))
            subprocess.run(["pkill", "-9", "-f", str(scene)], check=False)
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
        self.assertEqual([name for name in os.listdir("/dev/shm") if name.startswith("sem.OMPIO_")], [])
        run = self.good(self.scene_of(3), "results", "-overwrite", timeout=60)
        self.assertEqual(run.state, good.state)
        self.assertEqual(sorted(os.listdir(self.folder / "results")), RESULTS)

    def test_runs_at_the_same_time(self):
        """Files of the same names in folders of their own."""
        good = self.good(self.scene_of(30), "good")
        processes = [start(command([self.scene_of(30), "-output", self.folder / f"results_{k}"], 2)) for k in range(4)]
        for process in processes:
            try:
                out, err = process.communicate(timeout=120)
            except subprocess.TimeoutExpired:
                end(process)
                raise
            self.assertEqual(process.returncode, 0, err)
            self.assertEqual(out.strip().splitlines()[-1], f"state {good.state}")


if __name__ == "__main__":
    unittest.main(verbosity=2)
