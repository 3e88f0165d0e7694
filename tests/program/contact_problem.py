#!/usr/bin/python3
"""-dump_fclib and -error_estimate: problems with known answers, FCLIB's own reader, the same bytes on any number of ranks."""
import csv
import ctypes
import importlib.util
import json
import sys
import unittest

import h5py
import numpy as np

from unibody_runs import SOURCE, SCENES, ProgramTest, comparable, contents, execute, unibody

sys.path.insert(0, str(SOURCE / "scripts" / "rivals"))
from fclib import Problem  # noqa: E402

# A ball just above the ground, sliding to where it is stopped or held by friction.
BALL = """
    time: {frame: 0.01, frames: 1}
    gravity: [0, 0, -10]
    materials: {stone: {friction: 0.5}}
    solver: {iterations: 400, tolerance: 0, stages: together}
    bodies:
      - shape: {plane: {normal: [0, 0, 1]}}
      - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, 0.104], velocity: [3, 0, -1]}
"""

PILE = """
    time: {frame: 0.01, frames: 25}
    materials: {stone: {friction: 0.4}}
    bodies:
      - container: {size: [0.6, 0.6]}
      - {shape: {box: {size: [0.2, 0.1, 0.1]}}, motion: kinematic, position: [-0.2, 0, 0.06], velocity: [0.3, 0.1, 0], angular_velocity: [0, 0, 1]}
      - pile:
          count: 20
          columns: [2, 2]
          mix:
            - {shape: {box: {size: [0.2, 0.15, 0.1]}}}
            - {shape: {sphere: {radius: 0.07}}}
        density: 1000
        velocity: [0, 0, -2]
        position: [0, 0, 0.15]
"""

# Boxes that meet each other and the ground in the first step, whose problem is the same whatever the solver does.
BLOCK = """
    time: {frame: 0.01, frames: 1}
    materials: {stone: {friction: 0.4}}
    solver: {stages: together, tolerance: 0}
    bodies:
      - shape: {plane: {normal: [0, 0, 1]}}
      - lattice: {count: 12, columns: [2, 2], spacing: [0.105, 0.105, 0.103], height: 0.055, jitter: 0.002}
        shape: {box: {size: [0.1, 0.1, 0.1]}}
        mass: 1
        velocity: [0.5, 0, -2]
"""

CLOTH = """
    time: {frame: 0.016, frames: 8}
    bodies:
      - shape: {plane: {normal: [0, 0, 1]}}
      - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.4, 0.4, 0.4], velocity: [0, 0, -3]}
    cloths:
      - {name: sheet, grid: {size: [1, 1], nodes: [8, 8]}, mass: 0.4, thickness: 0.02, links: {}, position: [0.4, 0.4, 0.25]}
"""


class Matrix(ctypes.Structure):
    _fields_ = [(n, ctypes.c_int) for n in ("nzmax", "m", "n")] + [("p", ctypes.POINTER(ctypes.c_int)), (
        "i", ctypes.POINTER(ctypes.c_int)), ("x", ctypes.POINTER(ctypes.c_double)), ("nz", ctypes.c_int), ("info", ctypes.c_void_p)]


class Info(ctypes.Structure):
    _fields_ = [(n, ctypes.c_char_p) for n in ("title", "description", "math_info")]


def record(matrices, vectors):
    fields = [(n, ctypes.POINTER(Matrix)) for n in matrices] + [(n, ctypes.POINTER(ctypes.c_double)) for n in vectors]
    return type("Record", (ctypes.Structure,), {"_fields_": fields + [("spacedim", ctypes.c_int), ("info", ctypes.POINTER(Info))]})


Local, Global = record("WVR", ("mu", "q", "s")), record("MHG", ("mu", "f", "b", "w"))


class Solution(ctypes.Structure):
    _fields_ = [(n, ctypes.POINTER(ctypes.c_double)) for n in "vurl"]


def dense(matrix):
    """Of a matrix in compressed columns, as FCLIB holds it."""
    full = np.zeros((matrix.m, matrix.n))
    for column in range(matrix.n):
        for k in range(matrix.p[column], matrix.p[column + 1]):
            full[matrix.i[k], column] += matrix.x[k]
    return full


class ContactProblem(ProgramTest):
    def dump(self, text, name, *options, ranks=1, frame=None):
        path = self.folder / f"{name}.h5"
        step = ["-dump_step", frame] if frame else []
        self.good(self.scene(text), name, "-dump_fclib", path, *step, *options, ranks=ranks)
        return path

    def test_a_ball_that_lands(self):
        path = self.dump(BALL, "ball")
        problem, mu = Problem(path), 0.5
        m, h, g = 2, 0.01, 10
        arm = 0.1 + 0.004 / 2  # contacts lie half way across the gap
        np.testing.assert_allclose(problem.dense(), np.diag([1 / m] + 2 * [1 / m + arm**2 / (0.4 * m * 0.1**2)]), atol=1e-12)
        np.testing.assert_allclose(problem.mu, [mu])
        # The normal velocity that the gap leaves room for is added; the tangential one has its size, along axes of the file's own.
        self.assertAlmostEqual(problem.q[0], -1 - g * h + 0.004 / h, places=12)
        self.assertAlmostEqual(np.hypot(*problem.q[1:]), 3, places=12)
        normal = m * (1 + g * h - 0.004 / h)
        np.testing.assert_allclose(problem.r[0], normal, rtol=1e-9)
        np.testing.assert_allclose(problem.r[1:], -mu * normal * problem.q[1:] / 3, atol=1e-9)  # it slides on
        self.assertLess(problem.measures(problem.r)["residual"], 1e-9)
        # What is no solution is told from one: without friction, pulled, and not at all.
        for wrong in ([normal, 0, 0], [-normal, 0, 0], [0, 0, 0]):
            self.assertGreater(problem.measures(np.array(wrong, float))["residual"], 0.1)

    # An impact is resolved before the step's problem, at its own moment t: u(t) there, and (1 + e) u more after it. What is left is
    # a contact that opens, seen from where the ball seems to have started, t times that change deeper.
    def test_a_ball_that_bounces(self):
        problem = Problem(self.dump(BALL.replace("friction: 0.5", "friction: 0.5, restitution: 0.5"), "bouncing"))
        gap, g, h, recovery_time = 0.004, 10, 0.01, 0.01
        t = (-(1 + g * h / 2) + np.sqrt((1 + g * h / 2) ** 2 + 2 * g * gap)) / g
        change = 1.5 * (1 + g * h / 2 + g * t)
        self.assertAlmostEqual(problem.q[0], -1 - g * h + change + (gap - t * change) / (h + recovery_time), places=9)
        np.testing.assert_allclose(problem.r, 0, atol=1e-12)
        self.assertLess(problem.measures(problem.r)["residual"], 1e-9)

    # At velocity level a penetration of 5 mm is to shrink by gamma of that: its velocity is added.
    def test_a_ball_in_the_ground_at_velocity_level(self):
        sunk = BALL.replace("0.104]", "0.095]").replace("stages: together", "level: velocity, stabilisation: 0.3")
        problem = Problem(self.dump(sunk, "sunk"))
        self.assertAlmostEqual(problem.q[0], -1 - 10 * 0.01 - 0.3 * 0.005 / 0.01, places=12)
        np.testing.assert_allclose(problem.r[0], 2 * (1 + 10 * 0.01 + 0.3 * 0.005 / 0.01), rtol=1e-9)
        self.assertLess(problem.measures(problem.r)["residual"], 1e-9)

    # Three contacts with W = [[2, 1], [1, 2]] between the normals of the first two: both are pressed, the first sticks and the second
    # slides; the third opens.
    def test_a_problem_made_by_hand(self):
        W = np.diag([2.0, 4, 4, 2, 4, 4, 1, 1, 1])
        W[0, 3] = W[3, 0] = 1
        mu = np.array([0.5, 0.25, 1])
        r = np.array([[2.0, 0.6, -0.8], [4, 0, 1], [0, 0, 0]])  # 1 = mu r_n of the second; the first is right at its limit
        u = np.array([[0.0, 0, 0], [0, 0, -3], [0.5, 0.1, 0]])
        q = u.ravel() - W @ r.ravel()
        path = self.folder / "hand.h5"
        with h5py.File(path, "w") as file:
            file["fclib_local/spacedim"] = [3]
            rows, columns = np.nonzero(W)
            for name, value in {"m": [9], "n": [9], "nzmax": [len(rows)], "nz": [len(rows)], "i": rows, "p": columns, "x": W[rows, columns]}.items():
                file[f"fclib_local/W/{name}"] = value
            file["fclib_local/vectors/q"], file["fclib_local/vectors/mu"] = q, mu
            file["guesses/1/r"] = r.ravel()
        problem = Problem(path)
        np.testing.assert_array_equal(problem.dense(), W)
        self.assertLess(problem.measures(problem.r)["residual"], 1e-15)
        for k in range(9):  # no other one is: each number of it matters
            wrong = problem.r.copy()
            wrong[k] += 0.01
            self.assertGreater(problem.measures(wrong)["residual"], 1e-4, k)

    # The dynamics hold for what the step did, whatever its iterations; the two forms are one problem.
    def test_both_forms_hold_the_step(self):
        for solver in ("accelerated_jacobi", "gauss_seidel"):
            with self.subTest(solver=solver):
                with h5py.File(self.dump(PILE, solver, "-set", f"solver.name={solver}", "-set", "solver.iterations=10")) as file:
                    matrix = lambda at: dense(Stored(file[at]))  # noqa: E731
                    M, H, W = matrix("fclib_global/M"), matrix("fclib_global/H"), matrix("fclib_local/W")
                    f, w, q = file["fclib_global/vectors/f"][:], file["fclib_global/vectors/w"][:], file["fclib_local/vectors/q"][:]
                    v, u, r = (file[f"solution/{name}"][:] for name in "vur")
                    self.assertGreater(len(r), 60)
                    scale = np.abs(f).max()
                    np.testing.assert_allclose(M @ v, H @ r + f, atol=1e-11 * scale)
                    np.testing.assert_allclose(u, H.T @ v + w, atol=1e-12)
                    np.testing.assert_allclose(W, H.T @ np.linalg.solve(M, H), atol=1e-9 * np.abs(W).max())
                    np.testing.assert_allclose(q, H.T @ np.linalg.solve(M, f) + w, atol=1e-10)
                    self.assertGreater(np.abs(w.reshape(-1, 3)[:, 1:]).max(), 0.1, "nothing touches the kinematic box")

    def test_the_residual_falls_with_iterations(self):
        problems = [Problem(self.dump(BLOCK, f"i{n}", "-set", f"solver.iterations={n}")) for n in (10, 100, 1000)]
        for other in problems[1:]:
            np.testing.assert_array_equal(other.values, problems[0].values)
            np.testing.assert_array_equal(other.q, problems[0].q)
        residuals = [p.measures(p.r)["residual"] for p in problems]
        self.assertEqual(residuals, sorted(residuals, reverse=True))
        self.assertLess(residuals[-1], residuals[0] / 100)

    def test_the_same_file_on_any_number_of_ranks(self):
        for solver in ("accelerated_jacobi", "gauss_seidel"):
            files = [self.dump(PILE, f"{solver}_{n}", "-set", f"solver.name={solver}", ranks=n, frame=20) for n in (1, 2, 3)]
            self.assertTrue(contents(files[0]) == contents(files[1]) == contents(files[2]), solver)
            with h5py.File(files[0]) as file:
                self.assertEqual(sorted(map(tuple, file["unibody/contacts"][:])), list(map(tuple, file["unibody/contacts"][:])))

    def test_fclib_reads_it(self):
        try:
            library = ctypes.CDLL("libfclib.so.0")
        except OSError:
            self.skipTest("libfclib0 is not installed")
        path = self.dump(PILE, "pile", "-set", "solver.stages=together", "-set", "solver.iterations=1000")
        name, kept = str(path).encode(), Problem(path)
        for function, kind in (("local", Local), ("global", Global), ("solution", Solution)):
            getattr(library, f"fclib_read_{function}").restype = ctypes.POINTER(kind)
        library.fclib_read_guesses.restype = ctypes.POINTER(Solution)
        library.fclib_merit_local.restype = ctypes.c_double
        local, whole, solution = (getattr(library, f"fclib_read_{f}")(name) for f in ("local", "global", "solution"))
        number = ctypes.c_int()
        guess = library.fclib_read_guesses(name, ctypes.byref(number))
        n = 3 * len(kept.mu)
        np.testing.assert_array_equal(dense(local.contents.W[0]), kept.dense())
        np.testing.assert_array_equal(local.contents.q[:n], kept.q)
        np.testing.assert_array_equal(local.contents.mu[:n // 3], kept.mu)
        self.assertEqual((local.contents.spacedim, whole.contents.spacedim, number.value), (3, 3, 1))
        self.assertIn(b"frame 25", local.contents.info[0].description)
        np.testing.assert_array_equal(solution.contents.r[:n], kept.r)
        np.testing.assert_array_equal(guess[0].r[:n], kept.r)
        M, H = dense(whole.contents.M[0]), dense(whole.contents.H[0])
        v, f = (np.array(a[:len(M)]) for a in (solution.contents.v, whole.contents.f))
        np.testing.assert_allclose(M @ v, H @ kept.r + f, atol=1e-11 * np.abs(f).max())
        # Its own measure knows our solution from none.
        ours = library.fclib_merit_local(local, 0, solution)
        for k in range(n):
            solution.contents.r[k] = 0
        self.assertLess(ours, 1e-2 * library.fclib_merit_local(local, 0, solution))

    # Siconos reads back what --text writes, bit for bit, and solves it; 12 boxes on and above each other.
    def test_siconos_reads_the_text_form(self):
        path, text = self.dump(BLOCK, "block"), self.folder / "block.dat"
        done = execute([sys.executable, str(SOURCE / "scripts" / "rivals" / "solve_siconos.py"), str(path), "--text", str(text)], 60)
        self.assertEqual(done.code, 0, done.err)
        problem, n = Problem(path), len(Problem(path).mu)
        self.assertGreater(n, 20)
        numbers = np.array(text.read_text().split(), float)
        self.assertEqual(list(numbers[:7]), [3, n, 0, 3 * n, 3 * n, 3 * n, 3 * n])
        W, q, mu = np.split(numbers[7:], [9 * n * n, 9 * n * n + 3 * n])
        np.testing.assert_array_equal(W.reshape(3 * n, 3 * n).T, problem.dense())
        np.testing.assert_array_equal(q, problem.q)
        np.testing.assert_array_equal(mu, problem.mu)
        if importlib.util.find_spec("siconos") is None:
            self.skipTest("python3-siconos is not installed")
        import siconos.numerics as sn
        read = sn.frictionContact_new_from_filename(str(text))
        np.testing.assert_array_equal(read.q, problem.q)
        np.testing.assert_array_equal(read.mu, problem.mu)
        options = sn.SolverOptions(sn.SICONOS_FRICTION_3D_NSGS)
        options.dparam[sn.SICONOS_DPARAM_TOL], options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = 1e-10, 10000
        r, u = np.zeros(3 * n), np.zeros(3 * n)
        self.assertEqual(sn.fc3d_nsgs(read, r, u, options), 0)
        self.assertLess(problem.measures(r)["residual"], 1e-8)
        np.testing.assert_allclose(u, problem.times_w(r) + problem.q, atol=1e-12)

    def test_what_it_cannot_do_is_said_at_once(self):
        pile, cloth, path = self.scene(PILE, "pile.yaml"), self.scene(CLOTH, "cloth.yaml"), self.folder / "x.h5"
        newton = self.scene(CLOTH.split("bodies")[0] + "cloths" + CLOTH.split("cloths")[1], "newton.yaml")
        path.with_name("there.h5").write_text("")
        cases = {
            "-dump_step: expected -dump_fclib": (pile, "-dump_step", 3),
            "-dump_step: found 'x', expected a whole number": (pile, "-dump_fclib", path, "-dump_step", "x"),
            "-dump_step: found 26, expected a frame of the run, 1 to 25": (pile, "-dump_fclib", path, "-dump_step", 26),
            "-dump_fclib: found joints, cloths": (cloth, "-dump_fclib", path),
            "-dump_fclib: cannot write": (pile, "-dump_fclib", self.folder / "none" / "x.h5"),
            "there.h5' exists": (pile, "-dump_fclib", path.with_name("there.h5")),
            "-error_estimate: found '0', expected a whole number": (pile, "-error_estimate", 0),
            "-error_estimate: found solver.name newton": (newton, "-error_estimate", "-set", "solver.name=newton"),
        }
        for text, arguments in cases.items():
            with self.subTest(text):
                run = unibody(*arguments, "-output", self.folder / "out", ranks=1)
                self.assertEqual(run.code, 2, run.err)
                self.assertIn(text, run.err)
                self.assertFalse((self.folder / "out").exists() or path.exists())

    def test_files_that_hold_no_problem_are_named_in_one_line(self):
        wrong = self.scene("not HDF5", "wrong.h5")
        with h5py.File(self.folder / "empty.h5", "w"):
            pass
        for script in ("fclib.py", "solve_siconos.py"):
            for path, why in ((self.folder / "none.h5", "no such file"), (wrong, "not a frictional"), (self.folder / "empty.h5", "not a frictional")):
                done = execute([sys.executable, str(SOURCE / "scripts" / "rivals" / script), str(path)], 60)
                self.assertEqual(done.code, 1)
                self.assertRegex(done.err, rf"^{script}: {path}: {why}[^\n]*\n$")

    def test_a_run_without_a_step_has_none_to_write(self):
        pile = self.scene(PILE, "pile.yaml")
        self.good(pile, "whole", "-set", "time.frames=2", ranks=1)
        for more in ((), ("-dump_step", 2)):
            run = unibody(pile, "-set", "time.frames=2", "-restart", self.folder / "whole" / "checkpoint.h5", "-dump_fclib", self.folder / "x.h5", *more,
                          "-output", self.folder / "out", ranks=1)
            self.assertEqual(run.code, 2, run.err)
            self.assertIn("-dump_fclib: the run starts with its last frame, 2: there is no step to write", run.err)


class Stored:
    """A matrix of the file with the fields of FCLIB's."""

    def __init__(self, group):
        self.m, self.n = int(group["m"][0]), int(group["n"][0])
        self.p, self.i, self.x = group["p"][:], group["i"][:], group["x"][:]


class ErrorEstimate(ProgramTest):
    def test_every_third_frame_and_nothing_else_changes(self):
        soft = ("-set", "time.frames=8", "-set", "time.substeps=2")
        for name, scene, options in (("pile", self.scene(PILE, "pile.yaml"), ("-set", "time.frames=10")),
                                     ("cloth", self.scene(CLOTH, "cloth.yaml"), ()),
                                     ("solid", SCENES / "soft_block_on_floor.yaml", soft)):
            for solver in ("accelerated_jacobi", "gauss_seidel") if name == "pile" else ("accelerated_jacobi",):
                with self.subTest(scene=name, solver=solver):
                    options = (*options, "-set", f"solver.name={solver}")
                    plain, asked = f"{name}_{solver}_plain", f"{name}_{solver}"
                    state = self.good(scene, plain, *options, ranks=1).state
                    for n in (1, 3):
                        run = self.good(scene, f"{asked}_{n}", *options, "-error_estimate", 3, ranks=n, timeout=400)
                        self.assertEqual(run.state, state)
                    self.assertEqual(*(comparable(self.folder / f"{asked}_{n}" / "report.csv") for n in (1, 3)))
                    self.assertNotIn("error", (self.folder / plain / "report.csv").read_text())
                    with open(self.folder / f"{asked}_1" / "report.csv", newline="") as file:
                        rows = list(csv.DictReader(file))
                    told = [row["error_estimate (m)"] for row in rows]
                    self.assertEqual([k + 1 for k, cell in enumerate(told) if cell], sorted({*range(3, len(rows) + 1, 3), len(rows)}))
                    self.assertTrue(all(float(cell) >= 0 for cell in told if cell))
                    self.assertGreater(max(float(cell) for cell in told if cell), 0)
                    self.told_at_the_end(self.folder / f"{asked}_1", run.out, {k + 1: float(cell) for k, cell in enumerate(told) if cell})
                    self.assertNotIn("error", (self.folder / plain / "summary.json").read_text())

    def told_at_the_end(self, folder, out, estimates):
        """summary.json and the last lines have the worst and the last of {frame: estimate (m)}."""
        kept = json.loads((folder / "summary.json").read_text())["error_estimates"]
        worst, last = min(estimates, key=lambda frame: (-estimates[frame], frame)), max(estimates)
        self.assertEqual(kept["samples"], len(estimates))
        for name, frame in (("worst", worst), ("last", last)):
            self.assertEqual((kept[name]["frame"], kept[name]["error_estimate (m)"]), (frame, estimates[frame]))
        self.assertIn(f"in {len(estimates)} frames: at worst {estimates[worst]:.2e} m (frame {worst}), in the last {estimates[last]:.2e} m"
                      f" (frame {last})", out)

    def test_the_last_frame_is_always_sampled(self):
        self.good(self.scene(PILE, "pile.yaml"), "out", "-set", "time.frames=5", "-error_estimate", ranks=1)
        with open(self.folder / "out" / "report.csv", newline="") as file:
            told = [row["error_estimate (m)"] for row in csv.DictReader(file)]
        self.assertEqual([bool(cell) for cell in told], [False] * 4 + [True])


if __name__ == "__main__":
    unittest.main(verbosity=2)
