#!/usr/bin/python3
"""scripts/geometry: the volumes, corners and velocities of the surfaces it makes are those of the bodies, by closed forms."""
import csv
import os
import subprocess
import sys
import unittest
import xml.etree.ElementTree

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

from unibody_runs import SOURCE, ProgramTest

FLIGHT = """
    time: {frame: 0.01, frames: 6}
    gravity: [0, 0, 0]
    output: {every: 3}
    materials: {wood: {friction: 0.5}, iron: {friction: 0.3}}
    bodies:
      - {shape: {box: {size: [0.4, 0.6, 1.0]}}, mass: 2, velocity: [1, 2, 3], angular_velocity: [0.5, 0, 4], material: iron}
      - {shape: {sphere: {radius: 0.3}}, mass: 1, position: [3, 0, 0]}
      - {shape: {cylinder: {radius: 0.2, length: 0.8}}, mass: 1, position: [6, 0, 0], angular_velocity: [0, 1, 2]}
      - {shape: {capsule: {radius: 0.2, length: 0.8}}, mass: 1, position: [9, 0, 0], velocity: [0, 0, -1]}
      - {shape: {hull: {points: [[0, 0, 0], [0.6, 0, 0], [0, 0.9, 0], [0, 0, 1.2]]}}, mass: 1, position: [12, 0, 0], angular_velocity: [3, 0, 0]}
      - {shape: {compound: {parts: [{shape: {box: {size: [0.4, 0.2, 0.2]}}, position: [0.5, 0, 0]}, {shape: {sphere: {radius: 0.2}}, position: [-0.5, 0, 0]}]}},
         mass: 1, position: [15, 0, 0], angular_velocity: [0, 0, 2]}
    cloths: [{grid: {size: [1, 1], nodes: [4, 3]}, mass: 1, thickness: 0.01, position: [0, 5, 5]}]
    threads: [{points: [[0, -5, 0], [1, -5, 0]], segments: 5, radius: 0.01, mass: 0.1}]
"""
PILE = """
    time: {frame: 0.01, frames: 100}
    output: {every: 50, contacts: 100}
    bodies:
      - {shape: {plane: {normal: [0, 0, 1]}}}
      - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [0, 0, 0.1]}
      - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [0, 0, 0.3]}
      - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [2, 0, 0.1], name: leaves}
    events: [{do: remove, bodies: leaves, when: {time: 0.6}}]
"""


class Surface:
    """What a .vtp file holds."""

    def __init__(self, path):
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(path))
        reader.Update()
        data = reader.GetOutput()
        self.points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
        self.lines, self.triangles = ([] if cells.GetNumberOfCells() == 0 else vtk_to_numpy(cells.GetConnectivityArray()).reshape(-1, width)
                                      for cells, width in ((data.GetLines(), 2), (data.GetPolys(), 3)))
        self.velocity = vtk_to_numpy(data.GetPointData().GetArray("velocity"))
        arrays = data.GetCellData()
        self.cells = {arrays.GetArrayName(k): vtk_to_numpy(arrays.GetArray(k)) for k in range(arrays.GetNumberOfArrays())}

    def of(self, body):
        """The triangles of a body: [n, 3, 3]."""
        return self.points[self.triangles[self.cells["body"][len(self.lines):] == body]]

    def volume(self, body):
        a, b, c = np.moveaxis(self.of(body), 1, 0)
        return np.einsum("ij,ij", a - a[0], np.cross(b - a[0], c - a[0])) / 6


def turned(facets, radii, heights):
    """The volume between the circles' inscribed polygons: of each slice that of the frustum of a pyramid."""
    r, q, h = np.array(radii[:-1]), np.array(radii[1:]), np.diff(heights)
    return facets / 2 * np.sin(2 * np.pi / facets) * np.sum(h * (r * r + r * q + q * q)) / 3


class Geometry(ProgramTest):
    def geometry(self, name, *options, code=0):
        done = subprocess.run([str(SOURCE / "scripts/geometry"), str(self.folder / name), *options], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stderr if code else done.stdout.split()

    def flight(self):
        self.good(self.scene(FLIGHT), "run")
        self.geometry("run")
        return Surface(self.folder / "run/geometry/000006.vtp"), h5py.File(self.folder / "run/frames.h5", "r")

    def test_volumes(self):
        surface, _ = self.flight()
        angle = np.linspace(-np.pi / 2, np.pi / 2, 9)
        half = np.linspace(0, np.pi / 2, 5)
        ends = np.concatenate([-0.4 - 0.2 * np.sin(half[::-1]), 0.4 + 0.2 * np.sin(half)])
        ball = turned(16, np.cos(angle), np.sin(angle))
        expected = [0.4 * 0.6 * 1.0, 0.3**3 * ball, turned(16, [0.2, 0.2], [-0.4, 0.4]),
                    turned(16, 0.2 * np.cos(np.concatenate([half[::-1], half])), ends), 0.6 * 0.9 * 1.2 / 6, 0.4 * 0.2 * 0.2 + 0.2**3 * ball]
        for body, volume in enumerate(expected):
            self.assertAlmostEqual(surface.volume(body), volume, delta=2e-6 * volume, msg=f"body {body}")

    def test_more_facets_come_nearer_to_the_ball(self):
        self.good(self.scene(FLIGHT), "run")
        misses = []
        for facets in (16, 32, 64):
            self.geometry("run", "--facets", str(facets), "--frame", "last")
            misses.append(1 - Surface(self.folder / "run/geometry/000006.vtp").volume(1) / (4 / 3 * np.pi * 0.3**3))
        self.assertEqual([round(100 * miss, 1) for miss in misses[:2]], [6.3, 1.6])  # as docs/results.md says
        self.assertAlmostEqual(misses[0] / misses[1], 4, delta=0.2)
        self.assertAlmostEqual(misses[1] / misses[2], 4, delta=0.1)

    def test_places_and_velocities(self):
        surface, file = self.flight()
        frame = file["frames/000006"]
        x, q, v, w = (frame[name][:] for name in ("position", "orientation", "velocity", "angular_velocity"))
        s, u = q[0, 0], q[0, 1:]
        corners = {tuple(np.round(x[0] + k + 2 * np.cross(u, np.cross(u, k) + s * k), 5))
                   for k in (np.array([a, b, c]) for a in (-0.2, 0.2) for b in (-0.3, 0.3) for c in (-0.5, 0.5))}
        self.assertEqual({tuple(p) for p in np.round(surface.of(0).reshape(-1, 3), 5)}, corners)
        self.assertTrue(np.allclose(np.linalg.norm(surface.of(1) - x[1], axis=-1), 0.3, atol=1e-6))
        for body in range(6):
            chosen = np.unique(surface.triangles[surface.cells["body"][len(surface.lines):] == body])
            rigid = v[body] + np.cross(w[body], surface.points[chosen] - x[body])
            self.assertTrue(np.allclose(surface.velocity[chosen], rigid, atol=1e-5), body)
        self.assertTrue((surface.cells["material"][surface.cells["body"] == 0] == 1).all())
        self.assertTrue((surface.cells["mass"][surface.cells["body"] == 0] == 2).all())

    def test_parts_of_a_scene(self):
        """Every second body; those in a box; and both. Cloths and threads stay."""
        self.good(self.scene(FLIGHT), "run")
        bodies = {}
        for options in ((), ("--every", "2"), ("--box", "2,-1,-1,10,1,1"), ("--every", "3", "--box", "2,-1,-1,10,1,1")):
            self.geometry("run", *options, "--frame", "last")
            surface = Surface(self.folder / "run/geometry/000006.vtp")
            bodies[options] = set(surface.cells["body"][surface.cells["surface"] < 0])
            self.assertEqual(set(surface.cells["surface"]), {-1, 0, 1})
        self.assertEqual(list(bodies.values()), [{0, 1, 2, 3, 4, 5}, {0, 2, 4}, {1, 2, 3}, {3}])

    def test_cloths_and_threads(self):
        surface, file = self.flight()
        x = file["frames/000006/position"][:]
        cloth, thread = (file[f"surfaces/00000{k}/cells"][:] for k in (0, 1))
        of = surface.cells["surface"]
        self.assertEqual(len(surface.lines), 5)
        self.assertTrue(np.allclose(surface.points[surface.lines], x[thread], atol=1e-6))
        self.assertTrue((of[:5] == 1).all())
        self.assertTrue(np.allclose(surface.points[surface.triangles[of[5:] == 0]], x[cloth], atol=1e-6))

    def test_stretch(self):
        """Of a thread that bears a weight by its law; of cloths the length of their longest image of a unit circle, sampled."""
        self.good(self.scene("""
            time: {frame: 0.01, frames: 200}
            output: {every: 100}
            solver: {iterations: 400}
            cloths:
              - {grid: {size: [1, 0.6], nodes: [5, 4]}, mass: 0.4, thickness: 0.01, position: [0, 5, 5], links: {stiffness: 30, damping: 0.05},
                 pins: [{node: [0, 0]}, {node: [4, 0]}]}
            threads: [{points: [[0, 0, 0], [0, 0, -1]], segments: 4, radius: 0.01, mass: 0.4, stretch: {stiffness: 50, damping: 0.1}, pins: [{node: 0}]}]
        """), "hung")
        self.geometry("hung")
        file = h5py.File(self.folder / "hung/frames.h5")
        x0, x1 = (file[f"frames/{frame}/position"][:] for frame in ("000000", "000200"))
        cloth, thread = (file[f"surfaces/00000{k}/cells"][:] for k in (0, 1))
        surface = Surface(self.folder / "hung/geometry/000200.vtp")
        lengths = [np.linalg.norm(x[thread[:, 1]] - x[thread[:, 0]], axis=1) for x in (x0, x1)]
        stretch = surface.cells["stretch"]
        self.assertTrue(np.allclose(stretch[:4], lengths[1] / lengths[0], rtol=1e-6))
        # Each segment bears the nodes below it, of 0.1 kg each and 0.05 kg at the end, and is longer by that over its stiffness.
        self.assertTrue(np.allclose(stretch[:4], 1 + 9.81 * np.array([0.35, 0.25, 0.15, 0.05]) / 50 / 0.25, rtol=1e-3), stretch[:4])
        angle = np.linspace(0, np.pi, 2001)
        for k, cell in enumerate(cloth):
            # Unit vectors in the plane of the triangle as it was, and where its motion takes them.
            a, b = x0[cell[1]] - x0[cell[0]], x0[cell[2]] - x0[cell[0]]
            u = a / np.linalg.norm(a)
            v = b - (b @ u) * u
            v /= np.linalg.norm(v)
            image = np.linalg.solve(np.array([[a @ u, a @ v], [b @ u, b @ v]]), np.array([x1[cell[1]] - x1[cell[0]], x1[cell[2]] - x1[cell[0]]]))
            longest = np.linalg.norm(np.column_stack([np.cos(angle), np.sin(angle)]) @ image, axis=1).max()
            self.assertAlmostEqual(stretch[4 + k], longest, delta=1e-5 * longest)
        self.geometry("hung", "--unstretched", "200", "--frame", "last")
        self.assertTrue(np.allclose(Surface(self.folder / "hung/geometry/000200.vtp").cells["stretch"], 1, atol=1e-6))
        self.assertIn("no frame 7", self.geometry("hung", "--unstretched", "7", code=1))

    def test_strain_of_solids(self):
        """Beside the columns of the report, and of a block that flies as it is."""
        self.good(self.scene("""
            time: {frame: 0.01, frames: 30}
            output: {every: 15}
            materials: {jelly: {friction: 0.5}, stone: {friction: 0.5}}
            bodies: [{shape: {plane: {normal: [0, 0, 1]}}}]
            solids:
              - {block: {size: [0.4, 0.3, 0.2], cells: [4, 3, 2]}, density: 1000, youngs_modulus: 2.0e+4, poissons_ratio: 0.3, thickness: 0.01,
                 position: [0, 0, 0.15], material: jelly}
              - {block: {size: [0.2, 0.2, 0.2], cells: [2, 2, 2]}, density: 1000, youngs_modulus: 2.0e+4, poissons_ratio: 0.3, thickness: 0.01, position: [0, 0, 9],
                 material: stone}
        """), "solids")
        self.geometry("solids")
        with open(self.folder / "solids/report.csv", encoding="utf-8") as file:
            last = list(csv.DictReader(file))[-1]
        cells = self.cells_of_solids(self.folder / "solids/geometry/solids_000030.vtu")
        for number, material in enumerate(("jelly", "stone")):
            of = cells["surface"] == number
            self.assertGreater(of.sum(), 30)
            for column, found in (("strain_max", cells["greatest_strain"][of].max()), ("volume_min", cells["volume"][of].min()),
                                  ("volume_max", cells["volume"][of].max())):
                told = float(next(value for name, value in last.items() if name.startswith(f"{column}[{material}]")))
                self.assertAlmostEqual(found, told, delta=1e-6, msg=f"{column} of {material}")
        jelly = cells["surface"] == 0
        self.assertGreater(cells["greatest_strain"][jelly].max(), 0.005)
        tensor = cells["strain"][jelly][:, [0, 5, 4, 5, 1, 3, 4, 3, 2]].reshape(-1, 3, 3)
        self.assertTrue(np.allclose(np.abs(np.linalg.eigvalsh(tensor)).max(1), cells["greatest_strain"][jelly], atol=1e-9))
        # det(1 + 2 E) is the square of the volume's ratio.
        self.assertTrue(np.allclose(np.linalg.det(np.eye(3) + 2 * tensor), cells["volume"][jelly] ** 2, atol=1e-9))
        self.assertTrue((self.folder / "solids/solids.pvd").exists())

    def cells_of_solids(self, path):
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(path))
        reader.Update()
        arrays = reader.GetOutput().GetCellData()
        return {arrays.GetArrayName(k): vtk_to_numpy(arrays.GetArray(k)) for k in range(arrays.GetNumberOfArrays())}

    def test_stress_balances_weight(self):
        """At rest the stresses, each times its cell's volume, sum up to the loads times the ways from where the body is held: of a
        solid of two regions and one of the paper's law on a floor without friction, of a membrane, and of a
        thread the stress of each segment."""
        self.good(self.scene("""
            time: {frame: 0.02, frames: 150}
            output: {every: 150}
            solver: {iterations: 400, form: total}
            materials: {smooth: {friction: 0}}
            bodies: [{shape: {plane: {normal: [0, 0, 1]}}, material: smooth}]
            solids:
              - {block: {size: [0.2, 0.2, 0.4], cells: [2, 2, 4]}, density: 1000, youngs_modulus: 3.0e+4, poissons_ratio: 0.3, thickness: 0.01, damping: 0.1,
                 position: [0, 0, 0.205], material: smooth, regions: [{within: {min: [-1, -1, 0.2], max: [1, 1, 1]}, youngs_modulus: 1.0e+5, poissons_ratio: 0.1}]}
              - {block: {size: [0.2, 0.2, 0.4], cells: [2, 2, 4]}, density: 1000, youngs_modulus: 3.0e+4, poissons_ratio: 0.3, thickness: 0.01, damping: 0.1,
                 position: [2, 0, 0.205], material: smooth, energy_volume: current}
            cloths:
              - {grid: {size: [0.4, 0.3], nodes: [5, 4]}, mass: 0.4, thickness: 0.01, position: [0, 5, 5], orientation: {axis: [1, 0, 0], angle: 90},
                 membrane: {youngs_modulus: 3.0e+3, poissons_ratio: 0.3, damping: 0.1}, pins: [PINS]}
            threads: [{points: [[0, 9, 5], [0, 9, 4]], segments: 4, radius: 0.01, mass: 0.4, stretch: {youngs_modulus: 5.0e+4, damping: 0.1}, pins: [{node: 0}]}]
        """.replace("PINS", ", ".join(f"{{node: [{i}, 3]}}" for i in range(5)))), "loads")
        self.geometry("loads", "--frame", "last")
        file = h5py.File(self.folder / "loads/frames.h5")
        x, mass, surfaces = file["frames/000150/position"][:], file["bodies/mass"][:], file["surfaces"]
        self.assertLess(np.abs(file["frames/000150/velocity"][:]).max(), 2e-4)
        kinds = {key: "solid" if "tetrahedra" in group else "thread" if group["cells"].shape[1] == 2 else "cloth" for key, group in surfaces.items()}
        self.assertEqual(sorted(kinds.values()), ["cloth", "solid", "solid", "thread"])
        on_surfaces = Surface(self.folder / "loads/geometry/000150.vtp").cells
        in_solids = self.cells_of_solids(self.folder / "loads/geometry/solids_000150.vtu")
        solids = 0
        for number, key in enumerate(sorted(surfaces)):
            stress, group = on_surfaces["stress"][on_surfaces["surface"] == number], surfaces[key]
            nodes = np.unique(group["cells"][:] if kinds[key] != "solid" else group["tetrahedra"][:])
            if kinds[key] == "thread":
                expected = 9.81 * np.array([0.35, 0.25, 0.15, 0.05]) / (np.pi * 0.01**2)
                self.assertTrue(np.allclose(stress[:, 2], expected, rtol=1e-3), stress)
                self.assertTrue((np.abs(stress[:, [0, 1, 3, 4, 5]]) < 1e-3 * expected[3]).all(), stress)
                continue
            if kinds[key] == "cloth":
                corners = x[group["cells"][:]]
                volumes = 0.01 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
                held = 5.15
            else:
                corners = x[group["tetrahedra"][:]]
                volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
                of = in_solids["surface"] == number
                on_skin, stress, solids = stress, in_solids["stress"][of], solids + 1
                # A triangle of the surface has the stress of the one tetrahedron that has its corners.
                skin = group["cells"][:]
                for k in range(0, len(skin), 7):
                    below = [t for t, tetrahedron in enumerate(group["tetrahedra"][:]) if set(skin[k]) <= set(tetrahedron)]
                    self.assertTrue(len(below) == 1 and np.array_equal(on_skin[k], stress[below[0]]))
                held = 0.005  # half of the thickness
            load = -9.81 * (mass[nodes] * (x[nodes, 2] - held)).sum()
            total = (volumes[:, None] * stress).sum(0)
            self.assertAlmostEqual(total[2], load, delta=2e-3 * abs(load), msg=f"{kinds[key]} {number}: {total}")
            if kinds[key] == "solid":
                self.assertTrue((np.abs(total[:2]) < 2e-3 * abs(load)).all(), total)
        self.assertEqual(solids, 2)

    def test_stress_of_stretched_and_turned_cells(self):
        """Beside the closed forms of one direction without Poisson's effect: St. Venant-Kirchhoff's E l (l^2 - 1) / 2, the paper's law's
        E / 8 (l^2 - 1) (5 l^2 - 1), along the direction in which the cell now lies."""
        sys.path.insert(0, os.path.join(SOURCE, "scripts", "rendering"))
        import stress  # pylint: disable=import-error,import-outside-toplevel
        angle, modulus = 0.7, 5e4
        turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        corners = np.array([[[0.1, 0.2, 0.3], [0.5, 0.3, 0.2], [0.2, 0.7, 0.4], [0.0, 0.1, 0.9]]])
        for stretch in (0.6, 0.9, 1.3):
            for law, nominal in (("rest", modulus * stretch * (stretch**2 - 1) / 2),
                                 ("current", modulus / 8 * (stretch**2 - 1) * (5 * stretch**2 - 1))):
                now = corners * [stretch, 1, 1] @ turn.T
                found = stress.of_tetrahedra(now, corners, np.array([[modulus, 0]]), law)[0]
                along = turn[:, 0]
                tensor = found[[0, 5, 4, 5, 1, 3, 4, 3, 2]].reshape(3, 3)
                self.assertAlmostEqual(along @ tensor @ along, nominal, delta=1e-9 * modulus)
                self.assertAlmostEqual(np.abs(tensor @ along - nominal * along).max(), 0, delta=1e-9 * modulus)
        # A membrane in the plane z = 0, stretched and contracted so that nothing pulls across: the strains' ratio is Poisson's.
        triangle, poisson, stretch = corners[:, :3] * [1, 1, 0], 0.3, 1.2
        across = np.sqrt(1 - poisson * (stretch**2 - 1))
        found = stress.of_triangles(triangle * [stretch, across, 1] @ turn.T, triangle, np.array([[modulus, poisson]]))[0]
        tensor = found[[0, 5, 4, 5, 1, 3, 4, 3, 2]].reshape(3, 3)
        expected = modulus * (stretch**2 - 1) / 2 * stretch / across * np.outer(turn[:, 0], turn[:, 0])
        self.assertLess(np.abs(tensor - expected).max(), 1e-9 * modulus)
        self.assertTrue(np.isnan(stress.of_tetrahedra(corners * [-1, 1, 1], corners, np.array([[modulus, 0.3]]), "rest")).all())

    def test_the_series_has_the_frames_at_their_times(self):
        self.flight()
        sets = xml.etree.ElementTree.parse(self.folder / "run/geometry.pvd").getroot().findall("Collection/DataSet")
        self.assertEqual([float(s.get("timestep")) for s in sets], [0.0, 0.03, 0.06])
        for s in sets:
            self.assertEqual(len(Surface(self.folder / "run" / s.get("file")).of(0)), 12)

    def test_forces_and_bodies_that_leave(self):
        self.good(self.scene(PILE), "pile")
        self.geometry("pile")
        before, after = (Surface(self.folder / f"pile/geometry/{n}.vtp") for n in ("000050", "000100"))
        self.assertEqual((len(before.of(3)) > 0, len(after.of(3))), (True, 0))
        self.assertTrue(np.isnan(before.cells["pressure"]).all() and (before.cells["coordination"] == -1).all())
        self.geometry("pile", "--frame", "0")
        self.assertEqual(set(Surface(self.folder / "pile/geometry/000000.vtp").cells), set(after.cells))
        with h5py.File(self.folder / "pile/contacts.h5") as file:
            frame = file["frames/000100"]
            for k, body in enumerate(frame["body_ids"][:]):
                cells = after.cells["body"] == body
                self.assertTrue((after.cells["coordination"][cells] == frame["coordination"][k]).all())
        # The upper box stands on its face: the force of its weight acts half an edge below its centre, over the box's volume. The
        # lower one bears two weights below and one above.
        for body, weights in ((2, 1), (1, 3)):
            pressure = after.cells["pressure"][after.cells["body"] == body]
            self.assertTrue(np.allclose(pressure, weights * 9.81 * 0.1 / 0.2**3 / 3, rtol=0.01), pressure[:3])

    def test_joints(self):
        """A hanging weight on a rod of two links, and a pair that has broken: where they are joined, and the weights that they bear."""
        self.good(self.scene("""
            time: {frame: 0.01, frames: 20, substeps: 2}
            output: {every: 20, joints: true}
            bodies:
              - {shape: {box: {size: [0.1, 0.1, 0.4]}}, mass: 2, position: [1, 2, -0.2], name: upper}
              - {shape: {box: {size: [0.1, 0.1, 0.4]}}, mass: 3, position: [1, 2, -0.6], name: lower}
              - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [5, 0, 0], name: weight}
            joints:
              - {type: hinge, bodies: [upper, world], anchor: [1, 2, 0], axis: [0, 1, 0]}
              - {type: ball, bodies: [upper, lower], anchor: [1, 2, -0.4]}
              - {type: fixed, bodies: [weight, world], anchor: [5, 0, 0.1], strength: {force: 1, duration: 0}}
        """), "rod")
        self.geometry("rod")
        before, after = (self.lines(self.folder / f"rod/geometry/joints_{n}.vtp") for n in ("000000", "000020"))
        self.assertEqual((before[1]["joint"].tolist(), after[1]["joint"].tolist()), ([0, 1, 2], [0, 1]))
        self.assertEqual(before[1]["type"].tolist(), [1, 0, 3])
        expected = [[[1, 2, -0.2], [1, 2, 0], [1, 2, 0]], [[1, 2, -0.2], [1, 2, -0.4], [1, 2, -0.6]]]
        self.assertTrue(np.allclose(after[0], expected, atol=1e-5))
        self.assertTrue(np.allclose(after[1]["force"], [[0, 0, 5 * 9.81], [0, 0, -3 * 9.81]], atol=0.01), after[1]["force"])
        sets = xml.etree.ElementTree.parse(self.folder / "rod/joints.pvd").getroot().findall("Collection/DataSet")
        self.assertEqual([(float(s.get("timestep")), s.get("file")) for s in sets],
                         [(0.0, "geometry/joints_000000.vtp"), (0.2, "geometry/joints_000020.vtp")])

    def lines(self, path):
        """Of each line its three points, and the arrays of the lines."""
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(path))
        reader.Update()
        data, cells = reader.GetOutput(), reader.GetOutput().GetCellData()
        points = vtk_to_numpy(data.GetPoints().GetData())[vtk_to_numpy(data.GetLines().GetConnectivityArray()).reshape(-1, 3)]
        return points, {cells.GetArrayName(k): vtk_to_numpy(cells.GetArray(k)) for k in range(cells.GetNumberOfArrays())}

    def test_refusals(self):
        self.assertIn("cannot read frames", self.geometry("nothing", code=1))
        self.good(self.scene(FLIGHT), "run")
        self.assertIn("no frame 5 in", self.geometry("run", "--frame", "5", code=1))
        self.assertIn("--facets 6, expected a multiple of 4", self.geometry("run", "--facets", "6", code=1))
        self.assertIn("--every 0, expected a number from 1 on", self.geometry("run", "--every", "0", code=1))
        for box in ("0,0,0,1,1", "0,0,0,1,1,x", "0,0,2,1,1,1"):
            self.assertIn(f"--box {box}, expected X0,Y0,Z0,X1,Y1,Z1", self.geometry("run", "--box", box, code=1))
        self.assertFalse((self.folder / "run/geometry").exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
