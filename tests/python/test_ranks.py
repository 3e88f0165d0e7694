"""The same script on 1 to 3 processes: the same bits, gathered or by process, and the program's."""
import sys

import pytest

from conftest import SOURCE, mpirun

SCRIPT = """
import sys
from mpi4py import MPI
import numpy as np
import unibody

scene = unibody.Scene.load(sys.argv[1])
with unibody.Simulation(scene, comm=MPI.COMM_WORLD) as simulation:
    ids = scene.ids("box")
    for k in range(4):
        simulation.apply_force(ids[k], [50.0, 0, 3], torque=[0, 1.0, 0])
        simulation.set_velocity(ids[10 + k], [0, 0, 1.0])
        simulation.step(2)
    places, ways = simulation.positions, simulation.orientations
    assert np.array_equal(places[simulation.home_ids], simulation.home("positions"))
    assert np.array_equal(ways[simulation.home_ids], simulation.home("orientations"))
    all_ids = MPI.COMM_WORLD.allgather(simulation.home_ids)
    assert np.array_equal(np.sort(np.concatenate(all_ids)), ids)
    assert (simulation.rank, simulation.ranks) == (MPI.COMM_WORLD.rank, MPI.COMM_WORLD.size)
    contacts = MPI.COMM_WORLD.allreduce(len(simulation.contacts()))
    assert contacts == simulation.measures()["contacts"]
    told = (simulation.state_hash(), places.tobytes().hex()[-64:], simulation.measures()["kinetic_energy"].hex(), contacts)
    if simulation.rank == 0:
        print(*told)
"""


@pytest.fixture
def script(tmp_path):
    path = tmp_path / "script.py"
    path.write_text(SCRIPT, encoding="utf-8")
    return path


def test_the_same_bits_on_any_number_of_processes(script):
    told = []
    for ranks in (1, 2, 3):
        ended = mpirun(ranks, sys.executable, script, SOURCE / "scenes" / "boxes_500.yaml")
        assert ended.returncode == 0, ended.stderr
        told.append(ended.stdout)
    assert told[0].strip()
    assert told[1] == told[0] and told[2] == told[0]


def test_processes_may_have_simulations_of_their_own(tmp_path):
    path = tmp_path / "own.py"
    path.write_text("""
from mpi4py import MPI
import unibody
rank = MPI.COMM_WORLD.rank
scene = unibody.Scene({"gravity": [0, 0, 0], "bodies": [{"shape": {"sphere": {"radius": 1}}, "mass": 1, "velocity": [rank, 0, 0]}]})
with unibody.Simulation(scene, comm=MPI.COMM_SELF) as simulation:
    simulation.step(3 * (rank + 1))
    place = simulation.positions[0, 0]
assert abs(place - rank * 3 * (rank + 1) * 0.016) < 1e-12, place
""", encoding="utf-8")
    ended = mpirun(3, sys.executable, path)
    assert ended.returncode == 0, ended.stderr


def test_an_error_is_one_of_all_processes(tmp_path):
    path = tmp_path / "bad.py"
    path.write_text("""
import unibody
simulation = unibody.Simulation(unibody.Scene.load("%s"))
try:
    simulation.set_velocity(10**6, [0, 0, 0])
except unibody.InputError as error:
    assert "10" in str(error)
else:
    raise SystemExit(5)
simulation.step()
""" % (SOURCE / "scenes" / "boxes_500.yaml"), encoding="utf-8")
    ended = mpirun(2, sys.executable, path)
    assert ended.returncode == 0, ended.stderr
