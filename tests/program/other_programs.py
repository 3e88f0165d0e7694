#!/usr/bin/python3
"""Drivers of other programs on motions with closed forms, from the files they write, and what the report makes of one that fails."""
import os
import pathlib
import shutil
import sys
import unittest

import h5py
import numpy as np

from unibody_runs import PROGRAM, SOURCE, ProgramTest, execute

BUILT = pathlib.Path(PROGRAM).parent / "scripts" / "rivals"
SPHERE, BOX, PLANE = 0, 1, 2
H, G, MU = .016, 9.8, .3
ENGINES = {"bullet": 2e-5, "ode": 1e-9, "dart": 1e-9}  # how well they compute (m, m/s): Bullet in single precision
SPRINGS = {"liggghts.py": "liggghts", "lammps.py": "lmp"}


def moment(shape, size, mass):
    return np.full(3, .4 * mass * size[0] ** 2) if shape == SPHERE else mass / 3 * (np.sum(size**2) - size**2)


def write_scene(path, bodies):
    """bodies: (shape, size (m), position (m), velocity (m/s), spin (rad/s)), of 1 kg; planes stand still and face up."""
    shapes, sizes, places, velocities, spins = (np.array(column) for column in zip(*bodies))
    with h5py.File(path, "w") as file:
        file["bodies/shape"], file["bodies/motion"] = shapes.astype(np.int8), (shapes == PLANE).astype(np.int8)
        file["bodies/size"], file["bodies/mass"] = sizes.astype(float), np.ones(len(bodies))
        file["bodies/inertia"] = np.array([moment(shape, size, 1.) for shape, size in zip(shapes, sizes)])
        first = file.create_group("frames/000000")
        first["position"], first["velocity"], first["angular_velocity"] = places.astype(float), velocities.astype(float), spins.astype(float)
        first["orientation"] = np.tile([1., 0, 0, 0], (len(bodies), 1))


REST, GROUND = (0, 0, 0), (PLANE, (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0))


class Driver(ProgramTest):
    def words(self, name):
        """How the driver is started; skips where it, or its program, is not there."""
        if name in SPRINGS:
            if shutil.which(SPRINGS[name]) is None:
                self.skipTest(f"{SPRINGS[name]} is not installed")
            return [sys.executable, str(SOURCE / "scripts" / "rivals" / name)]
        if not (BUILT / name).exists():
            self.skipTest(f"no driver {name} in {BUILT}: configure with -DUNIBODY_BENCH=ON and build rival_drivers")
        return [str(BUILT / name)]

    def frames(self, name, bodies, count, *options):
        """[frame][body] positions, velocities and angular velocities of the run, the start with them."""
        start, end = self.folder / "start.h5", self.folder / "end.h5"
        write_scene(start, bodies)
        run = execute([*self.words(name), str(start), str(end), "--frames", str(count), *options], 100)
        self.assertEqual(run.code, 0, run.err)
        self.assertRegex(run.out, r"(median|mean)_ms [0-9.]+")
        with h5py.File(end) as file:
            names = sorted(file["frames"])
            self.assertEqual(names, [f"{n:06d}" for n in range(count + 1)])
            return [np.array([file[f"frames/{n}/{key}"][:] for n in names]) for key in ("position", "velocity", "angular_velocity")]

    # Each body on its own way: v falls by g h a step, and the body moves with what it then has.
    def falls(self, name):
        far = [(SPHERE, (.1, 0, 0), (0, 0, 5), (1, -2, 3), (0, 0, 0)), (BOX, (.1, .1, .1), (9, 0, 5), (0, 1, 0), (1, 2, 3))]
        places, velocities, spins = self.frames(name, far, 40)
        for body, (_, _, place, velocity, spin) in enumerate(far):
            for n in (1, 7, 40):
                down = np.array([0, 0, -G * H])
                np.testing.assert_allclose(velocities[n, body], velocity + n * down, atol=ENGINES[name])
                np.testing.assert_allclose(places[n, body], place + n * H * np.array(velocity) + n * (n + 1) / 2 * H * down, atol=ENGINES[name])
                np.testing.assert_allclose(spins[n, body], spin, atol=ENGINES[name])

    # Of two points held up by friction alone: a box, 12 m until it stops; v falls by mu g h a step. The ground is everywhere.
    def slides(self, name):
        speed = 8.4
        n = int(speed / (MU * G * H))
        way = H * (n * speed - MU * G * H * n * (n + 1) / 2)
        box = (BOX, (.5, .5, .5), (0, 0, .5), (speed, 0, 0), REST)
        places, velocities, _ = self.frames(name, [box, GROUND], n + 40, "--iterations", "50", "--friction", str(MU))
        self.assertAlmostEqual(places[-1, 0, 0] / way, 1, delta=.01)
        self.assertLess(np.abs(velocities[-1, 0]).max(), .01)
        self.assertLess(np.abs(places[:, 0, 2] - .5).max(), .01)

    def springs(self, name):
        high = [(SPHERE, (.1, 0, 0), (0, 0, 5), REST, REST), (SPHERE, (.1, 0, 0), (5, 5, 7), REST, REST)]
        places, velocities, _ = self.frames(name, high, 10)
        for body, (_, _, place, _, _) in enumerate(high):
            for n in (1, 10):  # by velocity Verlet: as Galilei has it
                t = n * H
                np.testing.assert_allclose(velocities[n, body], [0, 0, -G * t], atol=1e-9)
                np.testing.assert_allclose(places[n, body], [*place[:2], place[2] - G * t * t / 2], atol=1e-9)
        stiffness = 3.7e4
        low = (SPHERE, (.1, 0, 0), (0, 0, .1), REST, REST)
        places, velocities, _ = self.frames(name, [low, GROUND], 60, "--kn", str(stiffness))
        self.assertAlmostEqual(places[-1, 0, 2], .1 - G / stiffness, 7)  # its weight over the spring
        self.assertLess(np.abs(velocities[-1, 0]).max(), 1e-5)
        write_scene(self.folder / "moving.h5", [(SPHERE, (.1, 0, 0), (0, 0, 5), (1, 0, 0), REST)])
        run = execute([*self.words(name), str(self.folder / "moving.h5"), str(self.folder / "none.h5")], 100)
        self.assertEqual((run.code, run.err), (1, f"{name}: the spheres move at the start\n"))
        with h5py.File(self.folder / "moving.h5", "a") as file:  # at rest from where its last frame has it
            file.copy("frames/000000", file["frames"], "000001")
            file["frames/000001/position"][0, 2] = 3
        run = execute([*self.words(name), str(self.folder / "moving.h5"), str(self.folder / "last.h5"), "--frames", "2", "--from-last"], 100)
        self.assertEqual(run.code, 0, run.err)
        with h5py.File(self.folder / "last.h5") as file:
            places = [file[f"frames/{n:06d}/position"][0] for n in range(3)]
        np.testing.assert_allclose(places, [[0, 0, 3 - G * (n * H) ** 2 / 2] for n in range(3)], atol=1e-9)

    def diverges(self, name, bodies, *options):
        write_scene(self.folder / "start.h5", bodies)
        run = execute([*self.words(name), str(self.folder / "start.h5"), str(self.folder / "end.h5"), *options], 100)
        self.assertEqual((run.code, run.out), (0, "diverged_frame 1\n"), run.err)

    def test_bullet_diverges(self):
        self.diverges("bullet", [(BOX, (.1, .1, .1), (0, 0, 1), REST, REST)], "--gravity", "1e300")

    # In frames of 16 ms a pull that turns links faster than its assertions bear.
    def test_dart_diverges(self):
        links = [(BOX, (.05, .01, .01), (.1 * n, 0, 1), REST, REST) for n in range(3)]
        self.diverges("dart", links, "--chain", "1", "--gravity", "1e9")

    def test_bullet_falls(self):
        self.falls("bullet")

    def test_ode_falls(self):
        self.falls("ode")

    def test_dart_falls(self):
        self.falls("dart")

    def test_bullet_slides(self):
        self.slides("bullet")

    def test_ode_slides(self):
        self.slides("ode")

    def test_dart_slides(self):
        self.slides("dart")

    def test_liggghts(self):
        self.springs("liggghts.py")

    def test_lammps(self):
        self.springs("lammps.py")


class FailingDriver(ProgramTest):
    def report_with_bullet(self, does):
        """Twice the report's part where the driver of Bullet is a shell script that `does` something."""
        if not (BUILT / "measure").exists():
            self.skipTest(f"no {BUILT / 'measure'}")
        rivals = self.folder / "build" / "scripts" / "rivals"
        rivals.mkdir(parents=True)
        os.symlink(BUILT / "measure", rivals / "measure")
        os.symlink(PROGRAM, self.folder / "build" / "unibody")
        (rivals / "bullet").write_text(f"#!/bin/sh\n{does}\n")
        (rivals / "bullet").chmod(0o755)
        words = [
            sys.executable, str(SOURCE / "scripts" / "report"), "--tiny", "--build", str(self.folder / "build"),
            "--output", str(self.folder / "out")]
        for _ in range(2):
            yield execute([*words, "rivals"], 300)
            self.assertIn("not installed", (self.folder / "out" / "report" / "rivals.csv").read_text())  # ODE, DART: not built there

    def test_the_report_names_it_and_ends_with_1(self):
        for run in self.report_with_bullet("exit 1"):  # a failure is not taken for a result the next time
            self.assertEqual(run.code, 1, run.err)
            self.assertRegex(run.err, r"done: .*; ended in an error: Bullet --iterations \d+ ")
            self.assertIn("iterations: ended in an error", (self.folder / "out" / "report.html").read_text())

    def test_that_it_diverged_is_a_result(self):
        for run in self.report_with_bullet("echo diverged_frame 3"):
            self.assertEqual(run.code, 0, run.err)
            self.assertIn("iterations: diverged, in frame 3", (self.folder / "out" / "report.html").read_text())


if __name__ == "__main__":
    unittest.main()
