"""The scripts in scripts/examples run as they are."""
import importlib.util
import os
import re
import subprocess
import sys

import numpy as np

import unibody

from conftest import ENVIRONMENT, SOURCE, mpirun

EXAMPLES = SOURCE / "scripts" / "examples"


def run(folder, name, *arguments):
    ended = subprocess.run([sys.executable, EXAMPLES / name, *map(str, arguments)], cwd=folder, env=ENVIRONMENT,
                           capture_output=True, text=True, check=False, timeout=600)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout.splitlines()


def test_the_script_on_the_page(tmp_path):
    page = (SOURCE / "docs" / "python.md").read_text(encoding="utf-8")
    script = tmp_path / "page.py"
    script.write_text(re.search(r"```python\n(.*?)```", page, re.DOTALL).group(1), encoding="utf-8")
    ended = subprocess.run([sys.executable, script], env=ENVIRONMENT, capture_output=True, text=True, check=False, timeout=60)
    assert ended.returncode == 0, ended.stderr
    # 2 N on 1 kg for a second, and a fall of 1.9 m, which takes 0.62 s, onto the floor.
    x, _, z = [float(word) for word in re.search(r"\[\[(.*?)\]\]", ended.stdout).group(1).split()]
    assert 0.8 < x < 1.02 and abs(z - 0.1) < 0.01


def test_friction_study(tmp_path):
    lines = run(tmp_path, "friction_study.py", "--quick", tmp_path / "plot.png")
    distances = [float(line.split()[1]) for line in lines[1:]]
    assert len(distances) == 5
    assert distances[0] > 2 * distances[1] > 2 * 0.12  # without friction they roll away; no heap is narrower than the column
    assert min(distances[2:]) > 0.12 and distances[1] > distances[4]
    assert os.path.getsize(tmp_path / "plot.png") > 10000


def test_gripper(tmp_path):
    lines = run(tmp_path, "gripper.py")
    assert "the crate hangs" in lines[-1]


def test_hopper_discharge():
    told = []
    for ranks in (1, 2):
        ended = mpirun(ranks, sys.executable, EXAMPLES / "hopper_discharge.py", 2.6)
        assert ended.returncode == 0, ended.stderr
        told.append(ended.stdout)
    assert told[1] == told[0]
    rows = [line.split() for line in told[0].splitlines()[1:]]
    grains = {float(time): int(count) for time, count, _ in rows}
    assert grains[2.0] == 0 and grains[2.6] > 50  # the gate opens at 2 s
    assert all(int(a[1]) <= int(b[1]) for a, b in zip(rows, rows[1:]))


def test_silo_pressure_is_that_of_janssen(tmp_path):
    # One parameter for fills of 1 : 4: without friction at the walls both shares would be 1, and with them the law's.
    for solver in ("accelerated_jacobi", "gauss_seidel"):
        lines = run(tmp_path, "silo_pressure.py", "--quick", "--solver", solver, "--plot", tmp_path / "plot.png")
        rows = [[float(word) for word in line.split()] for line in lines[2:]]
        assert [row[0] for row in rows] == [250, 1000]
        for _, weight, load, share, law in rows:
            assert abs(share - load / weight) < 1e-3
            assert abs(share - law) < 0.06 * law, (solver, rows)
        assert rows[1][3] < 0.5 < rows[0][3]
        assert os.path.getsize(tmp_path / "plot.png") > 10000


def test_incline_flow_weighs_on_the_ground(tmp_path):
    lines = run(tmp_path, "incline_flow.py", "--quick", "--plot", tmp_path / "plot.png")
    angle, slope, along, across, _, left = [float(word) for word in lines[1].split()]
    assert angle == 24 and abs(across - 1) < 0.01  # no grain rises or sinks in the mean
    assert 0.9 * slope < along < slope  # the flow still gains speed
    assert left < 0.1
    assert os.path.getsize(tmp_path / "plot.png") > 10000


def test_triaxial_test_holds_its_pressure_and_finds_a_strength(tmp_path):
    lines = run(tmp_path, "triaxial_test.py", "--quick", "--iterations", 400, "--plot", tmp_path / "plot.png")
    _, across, ratio, angle, _, solid = [float(word) for word in lines[1].split()]
    assert abs(across - 500) < 5  # the scene's pressure
    assert abs(np.sin(np.radians(angle)) - (ratio - 1) / (ratio + 1)) < 1e-3
    assert 1.6 < ratio < 2.4  # 1.35 without friction between the grains
    assert 0.5 < solid < 0.64
    assert os.path.getsize(tmp_path / "plot.png") > 10000


def test_grain_environment_as_a_script(tmp_path):
    assert len(run(tmp_path, "grain_environment.py")) == 4


def test_grain_environment_starts_anew():
    spec = importlib.util.spec_from_file_location("grain_environment", EXAMPLES / "grain_environment.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    environment = module.RoverOnGrains()
    ends = []
    for seed in (3, 3, 4):
        first, _ = environment.reset(seed=seed)
        assert first.shape == (13,) and np.array_equal(first[:3], [0, 0, 0])
        seen, reward, ended, cut, _ = environment.step([6, -6])
        assert not ended and not cut
        assert abs(reward - (seen[0] - 1e-5 * 72)) < 1e-12
        assert seen[12] < -0.05  # the left wheels drive forwards: it turns to the right
        ends.append(seen)
    environment.close()
    assert np.array_equal(ends[0], ends[1]) and not np.array_equal(ends[0], ends[2])


def test_orifice_flow_is_that_of_beverloo(tmp_path):
    lines = run(tmp_path, "orifice_flow.py", "--quick", "--plot", tmp_path / "plot.png")
    exponent = float(re.match(r"n = (\S+) at", lines[0]).group(1))
    small, large = [float(line.split()[1]) for line in lines[2:]]
    assert abs(exponent - 2.5) < 0.4 and small < large  # two orifices of coarse steps; the four of the page are within 0.1
    assert abs(large / 0.098 - 1) < 0.15  # kg/s, of 24 mm, as the page has it
    assert os.path.getsize(tmp_path / "plot.png") > 10000


def test_column_collapse_reaches_as_far_as_experiments_say(tmp_path):
    lines = run(tmp_path, "column_collapse.py", "--quick", "--plot", tmp_path / "plot.png")
    aspect, reach, law, left, speed = [float(word) for word in lines[1].split()]
    assert 0.9 < aspect < 1.3 and abs(law - 1.2 * aspect) < 0.01
    assert abs(reach - law) < 0.2 * law
    assert left < aspect and speed < 0.01  # m/s: it lies
    assert os.path.getsize(tmp_path / "plot.png") > 10000


def test_equal_balls_without_friction_fill_0_64():
    def filled(friction):
        scene = unibody.Scene.load(str(SOURCE / "scenes" / "random_packing.yaml"), set={
            "bodies[1].lattice.count": 1000, "solver.iterations": 50, "time.substeps": 2, "materials.glass.friction": friction,
            "probes[0].box.low": [-0.05, -0.05, 0.025], "probes[0].box.high": [0.05, 0.05, 0.065]})
        with unibody.Simulation(scene) as simulation:
            simulation.step(160)
            return simulation.probe("inside")["solid_fraction (1)"]
    without, rough = filled(0), filled(0.5)
    assert abs(without - 0.64) < 0.015  # one ball in 490 is 0.0013; a crystal would fill 0.74
    assert 0.55 < rough < without - 0.02
