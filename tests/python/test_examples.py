"""The scripts in scripts/examples run as they are."""
import os
import subprocess
import sys

from conftest import ENVIRONMENT, SOURCE, mpirun

EXAMPLES = SOURCE / "scripts" / "examples"


def run(folder, name, *arguments):
    ended = subprocess.run([sys.executable, EXAMPLES / name, *map(str, arguments)], cwd=folder, env=ENVIRONMENT,
                           capture_output=True, text=True, check=False, timeout=600)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout.splitlines()


def test_friction_study(tmp_path):
    lines = run(tmp_path, "friction_study.py", tmp_path / "plot.png")
    distances = [float(line.split()[1]) for line in lines[1:]]
    assert len(distances) == 20
    assert distances[0] > 2 * distances[5] > 2 * 0.12  # without friction they roll away; no heap is narrower than the column
    assert min(distances[10:]) > 0.12 and distances[1] > distances[10]
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
