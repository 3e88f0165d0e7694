#!/usr/bin/python3
"""What a run writes and says, seen by other people's tools: HDF5, XDMF, CSV, JSON, pictures, the log.
tests/report checks the writers on made-up bodies; here the numbers are those of a run, and are computed anew."""
import json
import math
import os
import re
import shutil
import subprocess
import sys
import unittest
import xml.etree.ElementTree as ElementTree

import h5py
import numpy as np

from unibody_runs import SCENES, SOURCE, ProgramTest, report, unibody

STEP, FRAMES, EVERY = 0.016, 30, 5
SCENE = """
    title: boxes and spheres on the ground
    time: {frame: 0.016, frames: 30}
    output: {every: 5, checkpoint_every: 10}
    gravity: [0.3, 0, -9.81]
    bodies:
      - shape: {plane: {normal: [0, 0, 1]}}
      - {name: flyer, shape: {sphere: {radius: 0.1}}, mass: 3, position: [20, 0.25, 50], velocity: [1, -2, 3], angular_velocity: [0, 0, 4]}
      - lattice: {count: 40, columns: [3, 3], spacing: [0.16, 0.16, 0.19], height: 0.1, jitter: 0.01, rotation_jitter: 0.3}
        shape: {box: {size: [0.12, 0.11, 0.15]}}
        mass: 1.5
      - {shape: {box: {size: [0.1, 0.1, 2]}}, motion: kinematic, position: [-0.6, 0, 0.5], velocity: [0.2, 0, 0]}
      - points: [[0, 0, 1.4], [0.1, 0, 1.7]]
        shape: {sphere: {radius: 0.07}}
        density: 800
"""
SPHERE, BOX, PLANE = 0, 1, 2


def rotate_back(q, v):
    """World vectors v in the frames of the bodies with orientations q (w, x, y, z)."""
    u, w = -q[:, 1:], q[:, :1]
    return v + 2 * np.cross(u, np.cross(u, v) + w * v)


class Results(ProgramTest):
    """One run on two ranks, looked at from all sides."""

    @classmethod
    def setUpClass(cls):
        maker = ProgramTest()
        maker.setUp()
        cls.maker, cls.results = maker, maker.folder / "results"
        cls.run_done = maker.good(maker.scene(SCENE), "results", "-set", "title=a \"title\"", ranks=2)
        cls.file = h5py.File(cls.results / "frames.h5", "r")

    @classmethod
    def tearDownClass(cls):
        cls.file.close()
        cls.maker.doCleanups()

    def test_frames_and_shapes(self):
        count = 45
        frames = self.file["frames"]
        self.assertEqual(list(frames), [f"{k:06d}" for k in range(0, FRAMES + 1, EVERY)])
        for name, frame in frames.items():
            self.assertEqual(frame.attrs["frame"], int(name))
            self.assertEqual(frame.attrs["time"], int(name) * STEP)
            shapes = {field: frame[field].shape for field in frame}
            self.assertEqual(shapes, {"position": (count, 3), "orientation": (count, 4), "velocity": (count, 3),
                                      "angular_velocity": (count, 3)})
            lengths = np.linalg.norm(frame["orientation"][:], axis=1)
            np.testing.assert_allclose(lengths, 1, atol=1e-14)

    def test_bodies_are_in_order_of_id(self):
        bodies = self.file["bodies"]
        self.assertTrue((bodies["id"][:] == np.arange(45)).all())
        kinds = [PLANE, SPHERE] + 40 * [BOX] + [BOX, SPHERE, SPHERE]
        self.assertEqual(list(bodies["shape"][:]), kinds)
        self.assertEqual(list(bodies["motion"][:]), [1] + 41 * [0] + [2] + 2 * [0])
        ball = 800 * 4 / 3 * math.pi * 0.07**3
        np.testing.assert_allclose(bodies["mass"][:], [0, 3] + 40 * [1.5] + [0, ball, ball], rtol=1e-14)
        start = self.file["frames/000000/position"]
        np.testing.assert_array_equal(start[1], [20, 0.25, 50])
        np.testing.assert_array_equal(start[44], [0.1, 0, 1.7])

    def test_free_fall_is_the_discrete_parabola(self):
        """v_k = v_0 + k h g and x_k = x_0 + k h v_0 + h^2 g k (k + 1) / 2, the spin is constant."""
        g = np.array([0.3, 0, -9.81])
        for k in range(0, FRAMES + 1, EVERY):
            frame = self.file[f"frames/{k:06d}"]
            x = np.array([20, 0.25, 50]) + k * STEP * np.array([1, -2, 3]) + STEP**2 * g * k * (k + 1) / 2
            np.testing.assert_allclose(frame["position"][1], x, rtol=0, atol=1e-12)
            np.testing.assert_allclose(frame["velocity"][1], np.array([1, -2, 3]) + k * STEP * g, rtol=0, atol=1e-13)
            np.testing.assert_array_equal(frame["angular_velocity"][1], [0, 0, 4])

    def test_kinematic_body_keeps_its_way(self):
        for k in range(0, FRAMES + 1, EVERY):
            position = self.file[f"frames/{k:06d}/position"][42]
            np.testing.assert_allclose(position, [-0.6 + 0.2 * k * STEP, 0, 0.5], rtol=0, atol=1e-13)

    def test_report_agrees_with_the_frames(self):
        header, rows = report(self.results / "report.csv")
        self.assertEqual([int(row[0]) for row in rows], list(range(1, FRAMES + 1)))
        for name in header:
            has_unit = re.search(r" \(.+\)$", name)
            self.assertTrue(has_unit or name in ("step", "iterations", "contact_pairs", "contacts", "sliding_contacts"), name)
        self.assertEqual(len(set(header)), len(header))
        column = {name.split(" ")[0]: k for k, name in enumerate(header)}
        bodies = self.file["bodies"]
        mass, inertia = bodies["mass"][:][:, None], bodies["inertia"][:]
        g = np.array([0.3, 0, -9.81])
        touched = 0
        for row in rows:
            self.assertEqual(len(row), len(header))
            values = {name: float(row[k]) for name, k in column.items()}
            self.assertTrue(all(math.isfinite(v) for v in values.values()))
            self.assertAlmostEqual(values["time"], values["step"] * STEP, delta=1e-12)
            self.assertAlmostEqual(values["total_energy"], values["kinetic_energy"] + values["potential_energy"], delta=1e-9)  # none of it is elastic
            touched += values["contacts"]
            frame = self.file["frames"].get(f"{int(values['step']):06d}")
            if frame is None:
                continue
            x, v, w, q = (frame[f][:] for f in ("position", "velocity", "angular_velocity", "orientation"))
            spin = rotate_back(q, w)
            moment = inertia * spin
            kinetic = 0.5 * (mass * v * v).sum() + 0.5 * (moment * spin).sum()
            self.assertAlmostEqual(values["kinetic_energy"] / kinetic, 1, delta=1e-9)
            potential = -(mass * x * g).sum()
            self.assertAlmostEqual(values["potential_energy"] / potential, 1, delta=1e-9)
            momentum = (mass * v).sum(0)
            back = q * [1, -1, -1, -1]
            angular = (np.cross(x, mass * v) + rotate_back(back, moment)).sum(0)
            for k, axis in enumerate("xyz"):
                self.assertAlmostEqual(values[f"linear_momentum_{axis}"], momentum[k], delta=1e-9 * abs(momentum).max())
                self.assertAlmostEqual(values[f"angular_momentum_{axis}"], angular[k], delta=1e-9 * abs(angular).max())
        self.assertGreater(touched, 1000, "hardly anything touches anything: such a run tells nothing")

    def test_xdmf(self):
        path = self.results / "frames.xdmf"
        grids = ElementTree.parse(path).getroot().findall("./Domain/Grid/Grid")
        times = [float(grid.find("Time").get("Value")) for grid in grids]
        self.assertEqual(times, [k * STEP for k in range(0, FRAMES + 1, EVERY)])
        for grid, frame in zip(grids, self.file["frames"]):
            items = list(grid.iter("DataItem"))
            self.assertGreaterEqual(len(items), 7)
            for item in items:
                name, place = item.text.strip().split(":")
                self.assertTrue((self.results / name).exists())
                self.assertEqual(self.file[place].shape, tuple(int(n) for n in item.get("Dimensions").split()), place)
            self.assertIn(f"/frames/{frame}/position", "".join(grid.find("Geometry").itertext()))
            points = "".join(grid.find("Topology").itertext()).strip().split(":")[1]
            np.testing.assert_array_equal(self.file[points][:], np.arange(len(self.file["bodies/id"])))

    def test_xdmf_in_its_own_library(self):
        """ParaView's XDMF 3 reader is this library; Debian's VTK brings no reader of XDMF."""
        if not os.environ.get("UNIBODY_XDMF_POINTS"):
            self.skipTest("built without the XDMF library")
        done = subprocess.run([os.environ["UNIBODY_XDMF_POINTS"], self.results / "frames.xdmf"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        grids = [[float(word) for word in line.split()] for line in done.stdout.splitlines()]
        self.assertEqual([grid[0] for grid in grids], [k * STEP for k in range(0, FRAMES + 1, EVERY)])
        for grid, frame in zip(grids, self.file["frames"].values()):
            places = frame["position"][:]
            self.assertEqual(grid[1], len(places))
            np.testing.assert_array_equal(np.reshape(grid[2:], (-1, 3)), places)

    def test_xdmf_in_vtk(self):
        try:  # ParaView's VTK has it (5.11: put its dist-packages first in PYTHONPATH)
            from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
        except ImportError:
            self.skipTest("this VTK has no XDMF reader; ParaView's has")
        reader = vtkXdmfReader()
        reader.SetFileName(str(self.results / "frames.xdmf"))
        reader.UpdateTimeStep(20 * STEP)
        data = reader.GetOutputDataObject(0)
        points = np.array([data.GetPoint(k) for k in range(data.GetNumberOfPoints())])
        np.testing.assert_allclose(points, self.file["frames/000020/position"][:], atol=1e-6)
        self.assertEqual(data.GetNumberOfCells(), len(points))

    def test_summary(self):
        summary = json.loads((self.results / "summary.json").read_text())
        self.assertEqual(summary["ranks"], 2)
        self.assertEqual(summary["scene"]["title"], 'a "title"')
        self.assertEqual((summary["scene"]["bodies"], summary["scene"]["dynamic_bodies"]), (45, 43))
        self.assertEqual((summary["first_frame"], summary["last_frame"]), (0, FRAMES))
        self.assertEqual(summary["state_hash"], self.run_done.state)
        versions = summary["versions"]
        self.assertEqual(set(versions), {"unibody", "commit", "compiler", "petsc", "mpi", "hdf5", "metis"})
        self.assertEqual(versions["hdf5"].split(".")[:2], h5py.version.hdf5_version.split(".")[:2])
        for name in ("unibody", "petsc", "metis"):
            self.assertRegex(versions[name], r"^\d+\.\d+\.\d+$")
        self.assertRegex(versions["mpi"], r"\d+\.\d+")
        # What the scene leaves to the program is told as it was used for all islands: a tolerance of 2e-5 of the smallest box, ...
        self.assertEqual(summary["settings"], {
            "time": {"frame (s)": STEP, "frames": FRAMES, "substeps": 1},
            "solver": {"name": "accelerated_jacobi", "iterations": "auto", "accuracy": "auto", "tolerance (m)": 2e-5 * 0.11, "acceleration": "auto",
                       "mass_sharing": "directions", "level": "position", "stabilisation": 0.4, "stages": "two",
                       "warm_start": "auto", "velocity_share": 0.8, "leak": 0.6, "friction": "disc", "gap": "frozen", "form": "incremental",
                       "order": "coloured", "joints": "iterative", "coarse": False, "scaling": 1, "recovery_time (s)": STEP, "recovery_speed (m/s)": 0.25,
                       "margin (m)": 0.002},
            "output": {"every (frames)": EVERY, "crossings": True, "joints": False, "contacts (frames)": 0, "checkpoint_every (frames)": 10, "checkpoint_minutes (min)": 0,
                       "precision": "double"}})
        header, rows = report(self.results / "report.csv")
        pairs, points = (int(rows[-1][header.index(name)]) for name in ("contact_pairs", "contacts"))
        plan, = summary["plans"]
        # Half a millisecond by what one is counted as (ns); pairs whose faces turn on each other count as two.
        iterations = plan["iterations"]
        self.assertLessEqual(iterations, 5e5 / (20 * 43 + 20 * pairs + 5 * points))
        self.assertGreaterEqual(iterations, int(5e5 / (20 * 43 + 40 * pairs + 5 * points)))
        self.assertEqual({key: plan[key] for key in ("islands", "stages", "tolerance (m)", "has_velocity_stage", "velocity_iterations", "leak",
                                                     "most_stiffness")},
                         {"islands": "all", "stages": "two", "tolerance (m)": 2e-5 * 0.11, "has_velocity_stage": True,
                          "velocity_iterations": int(0.8 * iterations), "leak": 0.6, "most_stiffness": 2})
        self.assertEqual(set(summary["files"]), set(os.listdir(self.results)))
        for name in ("kinetic_energy (J)", "penetration_max (m)", "natural_residual (m)"):
            self.assertEqual(summary["final"][name], float(rows[-1][header.index(name)]))
        phases = summary["timings"]["phases"]
        total = sum(phase["total (s)"] for phase in phases.values())
        self.assertGreater(total, 0)
        for phase in phases.values():  # a sum of maxima over ranks is no less than the maximum of sums
            least, mean, most = (phase[name] for name in ("least of a rank (s)", "mean of the ranks (s)", "most of a rank (s)"))
            self.assertLessEqual(least, mean + 1e-12)
            self.assertLessEqual(mean, most + 1e-12)
            self.assertLessEqual(most, phase["total (s)"] + 1e-9)
        self.assertGreater(phases["solve"]["least of a rank (s)"], 0)
        self.assertLessEqual(total, 2 * summary["timings"]["wall_total (s)"])  # each the slowest rank's

    def test_picture(self):
        if subprocess.run([sys.executable, "-c", "import vtk"], capture_output=True, check=False).returncode != 0:
            self.skipTest("Python's VTK is not installed")
        if not os.environ.get("DISPLAY") and shutil.which("xvfb-run") is None:
            self.skipTest("no display and no xvfb-run")
        picture = self.maker.folder / "picture.png"
        done = subprocess.run([SOURCE / "scripts/render", self.results, "--out", picture, "--size", "320x200"], timeout=120,
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        data = picture.read_bytes()
        self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual((int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")), (320, 200))


SOLIDS = f"""
time: {{frames: 0}}
solids:
  - {{name: brick, block: {{size: [0.6, 0.5, 0.9], cells: [3, 2, 4]}}, density: 800, youngs_modulus: 1.0e+5, poissons_ratio: 0.3, thickness: 0.01}}
  - {{name: ring, mesh: "{SOURCE}/scenes/meshes/torus.msh", position: [5, 0, 0], density: 800, youngs_modulus: 1.0e+5, poissons_ratio: 0.3,
     thickness: 0.01}}
"""


class Solids(ProgramTest):
    def test_tetrahedra_fill_what_the_surface_bounds(self):
        self.good(self.scene(SOLIDS), "results")
        grids = ElementTree.parse(self.folder / "results/frames.xdmf").getroot().findall(".//Grid[@GridType='Uniform']")
        kinds = [(grid.find("Topology").get("TopologyType"), int(grid.find("Topology").get("NumberOfElements"))) for grid in grids]
        with h5py.File(self.folder / "results/frames.h5") as file:
            places = file["frames/000000/position"][:]
            for number, volume in ("000000", 0.6 * 0.5 * 0.9), ("000001", None):
                surface = file["surfaces"][number]
                cells, tetrahedra = surface["cells"][:], surface["tetrahedra"][:]
                self.assertIn(("Tetrahedron", len(tetrahedra)), kinds)
                edges = places[tetrahedra[:, 1:]] - places[tetrahedra[:, :1]]
                volumes = np.linalg.det(edges) / 6
                self.assertGreater(volumes.min(), 0)
                flux = np.einsum("ij,ij->i", places[cells[:, 0]], np.cross(places[cells[:, 1]], places[cells[:, 2]])) / 6
                self.assertAlmostEqual(volumes.sum(), flux.sum(), delta=1e-12)
                if volume:
                    self.assertAlmostEqual(volumes.sum(), volume, delta=1e-12)


class Switches(ProgramTest):
    def test_nothing_is_written_that_was_not_asked_for(self):
        scene = self.scene(SCENE)
        off = ["-set", "output.every=0", "-set", "output.checkpoint_every=-1", "-set", "time.frames=3"]
        self.good(scene, "results", *off)
        self.assertEqual(sorted(os.listdir(self.folder / "results")), ["report.csv", "summary.json"])

    def test_convergence_is_told_of_a_run_that_has_something_to_converge_to(self):
        scene = self.scene(SCENE)
        few = ["-set", "time.frames=3", "-set", "solver.iterations=2", "-overwrite"]
        self.assertRegex(self.good(scene, "results", *few, "-set", "solver.tolerance=1e-15").out,
                         r"accuracy: (all|[012]) of 3 frames are within 0.01 of the smallest moving body's size \(\S+ m\)\n"
                         r"what they are off by, over that size: half within \S+, 95 % within \S+, all within \S+ \(frame [123], "
                         r"(penetration|natural residual)\)\n(no accuracy is asked for: .*\n)?"
                         r"natural residual: half within \S+ m, 95 % within \S+ m, all within \S+ m; [012] of 3 frames converged to "
                         r"the tolerance of 1.00e-15 m\nwhat should rest may creep by so much a second: half within .*\nfarthest from solved: frame [123], contacts of .* and .*\n")
        without = self.good(scene, "results", *few, "-set", "solver.tolerance=0").out
        self.assertRegex(without, r"natural residual: half within .*; the tolerance is 0: all iterations were made\n")

    def test_a_strict_run_stops_where_it_has_not_converged(self):
        scene = self.scene("""
            bodies:
              - {shape: {plane: {normal: [0, 0, 1]}}}
              - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, points: [[0, 0, 0.1], [0, 0, 0.3], [0, 0, 0.5]]}
        """)
        few = ["-set", "time.frames=3", "-set", "solver.iterations=2", "-overwrite", "-strict"]
        for ranks in (1, 2):
            run = unibody(scene, "-output", self.folder / "results", *few, "-set", "solver.tolerance=1e-15", ranks=ranks)
            self.assertEqual(run.code, 3)
            self.assertRegex(run.err, r"option -strict: frame [123] has not converged: the natural residual is \S+ m, the tolerance "
                                      r"1.00e-15 m; farthest from solved: contacts of .* and .*")
        self.assertEqual(unibody(scene, "-output", self.folder / "results", *few, "-set", "solver.tolerance=1").code, 0)
        run = unibody(scene, "-output", self.folder / "results", *few, "-set", "solver.tolerance=0")
        self.assertEqual(run.code, 2)
        self.assertIn("option -strict: found solver.tolerance 0", run.err)

    def test_a_run_says_what_is_inside_out(self):
        # The material bears 0.19 of its modulus at most, half of the block's weight: its lowest tetrahedra must turn inside out, and
        # the steps converge all the same.
        scene = self.scene("""
            time: {frame: 0.016, frames: 30}
            solver: {name: gauss_seidel, iterations: 200, tolerance: 1.0e-4}
            materials: {jelly: {friction: 0}}
            bodies:
              - {shape: {plane: {normal: [0, 0, 1]}}}
            solids:
              - {block: {size: [0.2, 0.2, 0.4], cells: [2, 2, 4]}, youngs_modulus: 1.0e+4, poissons_ratio: 0, density: 1000,
                 thickness: 0.01, position: [0, 0, 0.205]}
        """)
        run = self.good(scene, "results", "-overwrite")
        header, rows = report(self.folder / "results" / "report.csv")
        counts = [int(row[header.index("inverted[jelly] (1)")]) for row in rows]
        frames = [int(row[0]) for row in rows]
        most = max(counts)
        self.assertGreater(most, 0)
        frame = frames[counts.index(most)]
        self.assertIn(f"not as the scene has it: {most} tetrahedra of jelly inside out in frame {frame}, {counts[-1]} at the end; ", run.out)
        summary = json.loads((self.folder / "results" / "summary.json").read_text())
        self.assertEqual(summary["side_faults"], [{"what": "tetrahedra of jelly inside out", "most": most, "most_frame": frame, "at_end": counts[-1]}])
        off = sum(count > 0 for count in counts)
        self.assertLessEqual(summary["convergence"]["frames_within_accuracy"], 30 - off)
        first = next(k for k, count in enumerate(counts) if count > 0)
        for ranks in (1, 2):
            strict = unibody(scene, "-output", self.folder / "results", "-overwrite", "-strict", ranks=ranks)
            self.assertEqual(strict.code, 3)
            self.assertIn(f"option -strict: frame {frames[first]}: found {counts[first]} tetrahedra of jelly inside out", strict.err)
        guarded = self.good(scene, "results", "-overwrite", "-set", "solids[0].least_volume=0.1").out
        self.assertNotIn("not as the scene has it", guarded)

    def test_a_run_says_what_it_has_held_back(self):
        # Balls at 50 m/s without friction or loss, in a turning box of plates 1 cm thick: they go 0.8 m in a step.
        plates = ", ".join(f"{{shape: {{box: {{size: {[0.01 if a == k else 1.2 for a in range(3)]}}}}}, position: {[s * 0.505 if a == k else 0 for a in range(3)]}}}"
                           for k in range(3) for s in (-1, 1))
        scene = self.scene(f"""
            time: {{frame: 0.016, frames: 40}}
            materials: {{m: {{friction: 0, restitution: 1}}}}
            bodies:
              - {{shape: {{compound: {{parts: [{plates}]}}}}, motion: kinematic, angular_velocity: [1, 0, 3]}}
              - {{shape: {{sphere: {{radius: 0.03}}}}, mass: 1, velocity: [45, 21, 9], points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0.2], [0.2, 0, -0.2]]}}
        """)
        run = self.good(scene, "results", "-overwrite")
        header, rows = report(self.folder / "results" / "report.csv")
        counts = [int(row[header.index("held_bodies (1)")]) for row in rows]
        most = max(counts)
        self.assertGreater(most, 0)
        first = next(k for k, count in enumerate(counts) if count > 0)
        what = "bodies held back that would have passed through what is fixed or driven"
        self.assertIn(f"not as the scene has it: {most} {what} in frame {rows[counts.index(most)][0]}, {counts[-1]} at the end; ", run.out)
        for ranks in (1, 2):
            strict = unibody(scene, "-output", self.folder / "results", "-overwrite", "-strict", ranks=ranks)
            self.assertEqual(strict.code, 3)
            self.assertIn(f"option -strict: frame {rows[first][0]}: found {counts[first]} {what}", strict.err)

    def test_a_run_says_what_goes_through_what(self):
        # A sheet that starts through another one.
        scene = self.scene("""
            time: {frame: 0.016, frames: 2}
            gravity: [0, 0, 0]
            cloths:
              - {grid: {size: [1, 1], nodes: [5, 5]}, mass: 1, thickness: 0.01}
              - {grid: {size: [1, 1], nodes: [4, 4]}, mass: 1, thickness: 0.01, orientation: {axis: [1, 0, 0], angle: 90}}
        """)
        run = self.good(scene, "results", "-overwrite")
        self.assertRegex(run.out, r"not as the scene has it: \d+ edges of cloths or threads through faces in frame \d, \d+ at the end; ")

    def test_single_precision_changes_the_files_and_not_the_run(self):
        scene = self.scene(SCENE)
        double = self.good(scene, "double")
        single = self.good(scene, "single", "-set", "output.precision=single")
        self.assertEqual(single.state, double.state)
        with h5py.File(self.folder / "single/frames.h5") as a, h5py.File(self.folder / "double/frames.h5") as b:
            positions = a["frames/000030/position"][:], b["frames/000030/position"][:]
            self.assertEqual((positions[0].dtype, positions[1].dtype), (np.float32, np.float64))
            self.assertTrue((positions[0] == positions[1].astype(np.float32)).all())

    def test_log_view(self):
        log = self.folder / "log.txt"
        self.good(SCENES / "boxes_500.yaml", "results", "-set", "time.frames=3", "-log_view", f":{log}")
        text = log.read_text()
        for phase in ("collide", "solve", "halo", "output", "partition"):
            self.assertRegex(text, rf"(?m)^.*unibody_{phase}\b")
        self.assertIn("with 2 processors", text)

    def test_version(self):
        run = unibody("-version", ranks=2)
        self.assertEqual(run.code, 0, run.err)
        told = dict(line.split(" ", 1) for line in run.out.strip().splitlines())
        self.assertEqual(list(told), ["unibody", "commit", "compiler", "petsc", "mpi", "hdf5", "metis"])
        project = re.search(r"project\(unibody VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text())
        self.assertEqual(told["unibody"], project.group(1))
        self.assertNotIn("", told.values())

    def test_help(self):
        for word in ("-help", "--help", "-h"):
            run = unibody(word, ranks=2, timeout=60, folder=self.folder)
            self.assertEqual(run.code, 0, run.err)
            self.assertEqual(run.out.count("usage:"), 1, "each rank speaks")
        source = (SOURCE / "src/app/options.cpp").read_text()
        parser = source[source.index("Options parse_options"):source.index("std::string help_text")]
        options = set(re.findall(r'word == "(-[a-z_]+)"', parser)) - {"-h"}
        self.assertLessEqual({"-output", "-overwrite", "-set", "-restart", "-partition", "-rebalance", "-shared_memory"}, options)
        for option in options | {"-log_view", "-options_file"}:
            self.assertRegex(run.out, rf"(?m)^  {option}\b", "the help text doesn't explain it")
        self.assertEqual(os.listdir(self.folder), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
