#!/usr/bin/python3
"""Calls of libraries that fail, one at a time, on one rank or on all: the run ends with an error, soon and on all ranks, and says
what failed; or, where no result depends on the call, ends in the same state. None is believed to have gone well."""
import os
import unittest

from unibody_runs import PROGRAM, ProgramTest, execute, launch

FAILING = os.environ.get("UNIBODY_FAILING", "")

PILE = """
    time: {frames: 30}
    output: {checkpoint_every: 10}
    bodies:
      - container: {size: [0.5, 0.5]}
      - lattice: {count: 60, columns: [2, 2], spacing: [0.2, 0.2, 0.2], height: 0.15, jitter: 0.01}
        shape: {sphere: {radius: 0.09}}
        mass: 1
"""


class Failures(ProgramTest):
    def run_with(self, *options, fail="", ranks=2, **more):
        """A run in which the call fails; it must end."""
        words = launch(ranks, LD_PRELOAD=FAILING, UNIBODY_FAIL=fail, **more)
        scene = self.folder / "scene.yaml"
        if not scene.exists():
            self.scene(PILE)
        self.runs = getattr(self, "runs", 0) + 1
        self.output = self.folder / f"results_{self.runs}"
        return execute([*words, PROGRAM, str(scene), "-output", str(self.output), *options], timeout=60)

    def ends(self, fail, says, code=3, **more):
        with self.subTest(fail=fail):
            run = self.run_with(fail=fail, **more)
            self.assertEqual(run.code, code, run.err)
            self.assertIsNone(run.state)
            self.assertFalse((self.output / "summary.json").exists())
            self.assertTrue(any(says in line for line in run.message), run.err)

    def setUp(self):
        super().setUp()
        self.assertTrue(os.path.exists(FAILING), "UNIBODY_FAILING names the library to preload")

    def test_nothing_fails(self):
        run = self.run_with()
        self.assertEqual((run.code, run.message), (0, []), run.err)
        self.assertIsNotNone(run.state)

    def test_global_vectors(self):
        self.ends("VecCreateMPIWithArray -1 1", "PETSc does not work", code=2)  # in the trial before the run
        self.ends("PetscSFSetGraph -1 1", "PETSc does not work", code=2)
        for rank in (0, 1, -1):
            self.ends(f"VecCreateMPIWithArray {rank} 2", "PETSc failed")
            self.ends(f"PetscSFSetGraph {rank} 2", "PETSc failed")
            self.ends(f"PetscSFBcastBegin {rank} 4", "PETSc failed")
            self.ends(f"PetscSFBcastEnd {rank} 7", "PETSc failed")
            self.ends(f"VecDestroy {rank} 3", "PETSc failed")

    def test_a_vector_that_one_rank_cannot_make(self):
        """The other waits for it within PETSc."""
        for rank in (0, 1):
            with self.subTest(rank=rank):
                run = self.run_with(fail=f"VecCreateMPIWithArray {rank} 1")
                self.assertNotEqual(run.code, 0)
                self.assertIsNone(run.state)

    def test_reference_solver(self):
        self.scene("""
            time: {frame: 10, frames: 1}
            solver: {name: newton}
            solids:
              - {block: {size: [1, 1, 1], cells: [2, 2, 2]}, density: 1000, youngs_modulus: 1.0e+6, poissons_ratio: 0.3,
                 thickness: 0.01, pins: [{node: [0, 0, 0]}]}
            """)
        self.ends("VecGetArrayRead 0 3", "PETSc failed", ranks=1)

    def test_messages(self):
        for number in (3, 40, 400):  # of this program, or of a library that it calls
            self.ends(f"MPI_Allreduce 1 {number}", "")
        self.ends("MPI_Issend 0 2", "MPI failed")

    def test_files(self):
        for rank in (0, 1):
            self.ends(f"H5Dwrite {rank} 9", "")  # the other waits within HDF5
        self.ends("H5Dwrite -1 9", "is the disk full?")
        self.ends("H5Fflush -1 2", "cannot write")
        self.ends("H5Fclose -1 1", "checkpoint")  # the first to be closed

    def test_a_partition_that_metis_cannot_make(self):
        """The bodies are divided in another way, which no result depends on."""
        good = self.run_with()
        run = self.run_with(fail="METIS_PartGraphRecursive 0 1")
        self.assertEqual((run.code, run.state), (0, good.state), run.err)
        self.assertEqual(len(run.message), 1, run.err)
        self.assertIn("METIS failed", run.message[0])

    def test_memory_that_ranks_cannot_share(self):
        """They send messages instead, with the same result."""
        good = self.run_with()
        run = self.run_with(fail="MPI_Win_allocate_shared -1 1")
        self.assertEqual((run.code, run.state), (0, good.state), run.err)

    def test_no_memory_is_shared_where_it_is_turned_off(self):
        for options in ((), ("-error_estimate", "10")):
            on = self.run_with(*options, UNIBODY_TELL_WINDOWS="1")
            off = self.run_with("-shared_memory", "off", *options, UNIBODY_TELL_WINDOWS="1")
            self.assertEqual(on.state, off.state)
            self.assertIn("a shared window", on.err)
            self.assertNotIn("a shared window", off.err)


if __name__ == "__main__":
    unittest.main(verbosity=2)
