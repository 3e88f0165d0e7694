#!/usr/bin/python3
"""The final state of every scene in scenes/, and of many settings, bit for bit: on 1 and on 3 ranks it is the one of the table.
Runs with overrides are on one of the two in turn.

The table, state_hashes.txt, says of each run its scene, its frames, its overrides and its state hash. It holds for a machine with
AVX2 and FMA and for the distribution's compiler and libraries: another mathematical library may round otherwise. Newton's method
factorises by BLAS, and is compared only where that is the distribution's reference; other packages may have brought another.

A change of the program that should change no result must leave the table as it is. A change that should is followed by
    tests/program/state_hashes.py --write
which writes the table anew, from runs on 1 rank; the new table belongs in the same commit.
"""
import pathlib
import re
import subprocess
import sys
import unittest

from unibody_runs import PROGRAM, SCENES, SOURCE, ProgramTest, unibody

TABLE = pathlib.Path(__file__).with_name("state_hashes.txt")
OPTIONS_OF_A_RUN = 3  # fields before the overrides: scene, frames, hash


def read_table():
    """Of each line that is no comment: scene, frames, hash, overrides."""
    rows = [line.split() for line in TABLE.read_text().splitlines() if line.strip() and not line.startswith("#")]
    return [(row[0], row[1], row[2], row[OPTIONS_OF_A_RUN:]) for row in rows]


def path_of(scene):
    return SOURCE / scene


def lacks_mesh(path):
    """A scene whose mesh has to be fetched from the network, and is not there."""
    meshes = re.findall(r"[:{]\s*((?:\.\./)+results/meshes/[^\s,}]+)", path.read_text())
    return any(not (path.parent / mesh).is_file() for mesh in meshes)


def options(frames, overrides):
    sets = [f"time.frames={frames}", *overrides]
    return [word for value in sets for word in ("-set", value)]


def cpu_is_of_the_table():
    try:
        flags = pathlib.Path("/proc/cpuinfo").read_text().split()
    except OSError:
        return True
    return "flags" not in flags or ("avx2" in flags and "fma" in flags)


def blas_is_of_the_table():
    listed = subprocess.run(["ldd", PROGRAM], capture_output=True, text=True, check=False).stdout
    found = re.search(r"libblas\.so\S* => (\S+)", listed)
    return found is None or pathlib.Path(found.group(1)).resolve().parent.name == "blas"


class StateHashes(ProgramTest):
    @unittest.skipUnless(cpu_is_of_the_table(), "the table holds for processors with AVX2 and FMA")
    def test_every_run_of_the_table(self):
        compared, has_its_blas = 0, blas_is_of_the_table()
        for row, (scene, frames, expected, overrides) in enumerate(read_table()):
            path = path_of(scene)
            if lacks_mesh(path):
                continue
            sequential = any("sequential" in o or "newton" in o for o in overrides)
            for ranks in (1,) if sequential else ((1, 3)[row % 2],) if overrides else (1, 3):
                with self.subTest(scene=scene, overrides=overrides, ranks=ranks):
                    run = unibody(path, "-output", self.folder / "run", "-overwrite", *options(frames, overrides), ranks=ranks,
                                  timeout=300)
                    self.assertEqual(run.code, 0, run.err)
                    if has_its_blas or not any("newton" in o for o in overrides):
                        self.assertEqual(run.state, expected, "the state is another one than in state_hashes.txt")
                    compared += 1
        self.assertGreater(compared, 100)

    def test_every_scene_is_in_the_table(self):
        known = {row[0] for row in read_table()}
        for path in sorted(SCENES.glob("*.yaml")):
            self.assertIn(f"scenes/{path.name}", known, "add it to state_hashes.txt")


def write_table(folder):
    lines = []
    for line in TABLE.read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            scene, frames, expected, *overrides = line.split()
            if not lacks_mesh(path_of(scene)):
                run = unibody(path_of(scene), "-output", folder, "-overwrite", *options(frames, overrides), ranks=1, timeout=600)
                if run.state is None:
                    sys.exit(f"{line}\n{run.err}")
                expected = run.state
            line = " ".join([f"{scene:34}", f"{frames:>4}", expected, *overrides])
        lines.append(line)
    TABLE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--write"]:
        import tempfile
        with tempfile.TemporaryDirectory() as folder:
            write_table(folder)
    else:
        unittest.main()
