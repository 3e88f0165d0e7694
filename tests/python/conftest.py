"""What the tests of the Python module share. ctest sets PYTHONPATH, UNIBODY_PROGRAM and UNIBODY_SOURCE_DIR."""
import os
import pathlib
import re
import subprocess

import pytest

SOURCE = pathlib.Path(os.environ.get("UNIBODY_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("UNIBODY_PROGRAM", str(SOURCE / "build" / "release" / "unibody"))
MPIEXEC = os.environ.get("UNIBODY_MPIEXEC", "mpirun")
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_hwloc_base_binding_policy="none",
                   OMPI_MCA_mpi_yield_when_idle="1", OMPI_MCA_orte_execute_quiet="1", OMP_NUM_THREADS="1",
                   OMPI_MCA_pml="ob1")  # else Open MPI looks for clusters' networks, a third of the time that a run starts


def mpirun(ranks, *words):
    return subprocess.run([MPIEXEC, "-n", str(ranks), *map(str, words)], env=ENVIRONMENT, capture_output=True, text=True,
                          check=False, timeout=300)


@pytest.fixture
def state_of_program(tmp_path):
    """The state's hash with which a run of the program ends."""

    def run(scene, *options):
        ended = mpirun(1, PROGRAM, scene, "-output", tmp_path / "program", "-overwrite", "-set", "output.every=0", *options)
        assert ended.returncode == 0, ended.stderr
        return re.search(r"^state ([0-9a-f]{16})$", ended.stdout, re.MULTILINE).group(1)

    return run


@pytest.fixture
def ball():
    """A ball of 2 kg in free space."""
    return {"time": {"frame": 0.01, "frames": 100}, "gravity": [0, 0, 0],
            "bodies": [{"name": "ball", "shape": {"sphere": {"radius": 0.5}}, "mass": 2, "position": [0, 0, 0]}]}
