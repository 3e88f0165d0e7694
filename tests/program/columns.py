#!/usr/bin/python3
"""Columns of report.csv and joints.csv on cases whose numbers are known in closed form: stretch and strain by material, residuals by
type, forces and torques of joints."""
import math
import re
import unittest

import h5py
import numpy as np

from unibody_runs import ProgramTest, report

# All nodes are held, half of them by bodies that move: a cloth of links is stretched along x, one of a membrane is sheared, a block
# is stretched along x, and another one is pressed along y and then turned inside out.
MATERIALS = """
    time: {frame: 0.125, frames: 2}
    gravity: [0, 0, 0]
    materials: {rag: {friction: 0.1}, silk: {friction: 0.2}, jelly: {friction: 0.3}, cork: {friction: 0.4}}
    bodies:
      - {name: slow, shape: {sphere: {radius: 0.01}}, motion: kinematic, position: [0, 0, 90], velocity: [0.2, 0, 0]}
      - {name: fast, shape: {sphere: {radius: 0.01}}, motion: kinematic, position: [0, 5, 90], velocity: [0, -4.8, 0]}
    cloths:
      - {grid: {size: [1, 0.75], nodes: [2, 2]}, mass: 1, thickness: 0.01, material: silk, links: {stiffness: 1000},
         pins: [{node: [0, 0]}, {node: [0, 1]}, {node: [1, 0], to: slow}, {node: [1, 1], to: slow}]}
      - {grid: {size: [1, 1], nodes: [2, 2]}, mass: 1, thickness: 0.01, material: rag, position: [0, 0, 10],
         membrane: {youngs_modulus: 1.0e+5, poissons_ratio: 0.3},
         pins: [{node: [0, 0]}, {node: [1, 0]}, {node: [0, 1], to: slow}, {node: [1, 1], to: slow}]}
    solids:
      - {block: {size: [0.5, 1, 1], cells: [1, 1, 1]}, density: 1000, youngs_modulus: 1.0e+5, poissons_ratio: 0.3, thickness: 0.01,
         material: cork, position: [0, 0, 20],
         pins: [{within: {min: [-0.25, -1, 0], max: [-0.25, 1, 30]}}, {within: {min: [0.25, -1, 0], max: [0.25, 1, 30]}, to: slow}]}
      - {block: {size: [1, 1, 1], cells: [1, 1, 1]}, density: 1000, youngs_modulus: 2.0e+5, poissons_ratio: 0.25, thickness: 0.01,
         material: jelly, position: [0, 0, 30],
         pins: [{within: {min: [-1, -0.5, 0], max: [1, -0.5, 40]}}, {within: {min: [-1, 0.5, 0], max: [1, 0.5, 40]}, to: fast}]}
"""

# One iteration of Jacobi's from rest, m = 2 kg at the middle node and 1 kg at the free end.
HANGING = """
    time: {frame: 0.01, frames: 1}
    gravity: [0, 0, -10]
    solver: {name: jacobi, iterations: 1, stages: position, tolerance: 0}
    materials: {air: {friction: 0}, string: {friction: 0.5}}
    threads:
      - {points: [[0, 0, 0], [0, 0, -2]], segments: 2, radius: 0.01, mass: 4, pins: [{node: 0}], bending: {stiffness: 5000}, material: string}
"""


class Columns(ProgramTest):
    def rows(self, name, text):
        self.good(self.scene(text), name)
        header, rows = report(self.folder / name / "report.csv")
        rows = [dict(zip(header, map(float, row))) for row in rows]
        for row in rows:
            kinds = [row[f"{kind}_energy (J)"] for kind in ("kinetic", "potential", "elastic")]
            self.assertAlmostEqual(row["total_energy (J)"], sum(kinds), delta=1e-12 * sum(map(abs, kinds)))
        return rows

    def check(self, row, expected):
        found = {name: value for name, value in row.items() if re.match("stretch|strain|volume|inverted|elastic|residual", name)}
        self.assertEqual(set(found), set(expected))
        for name, value in expected.items():
            self.assertAlmostEqual(found[name], value, delta=1e-12 * max(1, abs(value)), msg=name)

    def test_stretch_and_strain_are_of_the_material_that_is_named(self):
        for k, row in enumerate(self.rows("held", MATERIALS), 1):
            moved = 0.2 * 0.125 * k
            diagonal = math.hypot(1 + moved, 0.75) - 1.25
            energy = 1000 / 2 * (2 * moved**2 + 2 * diagonal**2)  # of the links, then of the membrane: simple shear
            across, along, thickness = moved / 2, moved**2 / 2, 0.01
            energy += thickness / 2 * 1e5 / (1 - 0.3**2) * (along**2 + 2 * (1 - 0.3) * across**2)
            links = [moved, moved, 0, 0] + 2 * [math.hypot(1 + moved, 0.75) / 1.25 - 1]  # along x, along y, across
            shear = [math.sqrt(1 + moved**2 / 4) + sign * moved / 2 - 1 for sign in (-1, 1)]
            expected = {"residual_distance (m)": 0, "residual_membrane (m)": 0, "residual_tetrahedron (m)": 0}
            for name, stretches in ("silk", links), ("rag", shear):
                expected[f"stretch_max[{name}] (1)"] = max(map(abs, stretches))
                expected[f"stretch_rms[{name}] (1)"] = math.sqrt(sum(s * s for s in stretches) / len(stretches))
            for name, size, stretch, young, poisson in ("cork", 0.5, 1 + moved / 0.5, 1e5, 0.3), ("jelly", 1, 1 - 0.6 * k, 2e5, 0.25):
                strain = (stretch**2 - 1) / 2
                modulus = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))
                expected.update({f"strain_max[{name}] (1)": abs(strain), f"volume_min[{name}] (1)": stretch, f"volume_max[{name}] (1)": stretch,
                                 f"inverted[{name}] (1)": 5 * (stretch < 0), f"elastic_energy[{name}] (J)": size * modulus * strain**2 / 2})
                energy += size * modulus * strain**2 / 2
            expected["elastic_energy (J)"] = energy
            self.check(row, expected)

    def test_residuals_are_those_of_each_type(self):
        """The upper segment bears half of what it must, the other one nothing, and the bending link, whose compliance is four times
        the inverse mass of its end, a quarter: the nodes have fallen by 1/2 and 3/4 of h^2 g."""
        fall = 0.01**2 * 10
        (row,) = self.rows("hanging", HANGING)
        self.check(row, {"residual_distance (m)": fall / 2, "residual_bending_link (m)": fall * (3 / 4 - 1 / 2),
                         "elastic_energy (J)": 5000 / 2 * (fall * 3 / 4)**2,  # of the bending link; the others are stiff
                         "stretch_max[string] (1)": fall / 2, "stretch_rms[string] (1)": fall * math.sqrt((1 / 4 + 1 / 16) / 2)})


class Joints(ProgramTest):
    """joints.csv and joints.h5, columns by name: what holds, drives, stops and rubs bodies at rest and a wheel that speeds up."""
    SCENE = """
        time: {frame: 0.01, frames: 120}
        output: {every: 40, joints: true}
        solver: {iterations: 60, tolerance: 0}
        bodies:
          - {name: bar, shape: {box: {size: [0.5, 0.1, 0.1]}}, mass: 2, position: [0.25, 0, 0]}
          - {name: wheel, shape: {box: {size: [1, 0.1, 1]}}, mass: 3, position: [3, 0, 0]}
          - {name: stopped, shape: {sphere: {radius: 0.1}}, mass: 4, position: [6, 0, 0]}
          - {name: rubbed, shape: {sphere: {radius: 0.1}}, mass: 5, position: [9, 0, 0]}
          - {name: hung, shape: {sphere: {radius: 0.1}}, mass: 6, position: [12, 0, -0.3]}
          - {name: lifted, shape: {sphere: {radius: 0.1}}, mass: 7, position: [15, 0, 0]}
        joints:
          - {type: fixed, bodies: [bar, world], anchor: [0, 0, 0]}
          - {type: hinge, bodies: [wheel, world], anchor: [3, 0, 0], axis: [0, -1, 0], motor: {speed: -90, max_torque: 0.5}}
          - {type: slider, bodies: [stopped, world], anchor: [6, 0, 0], axis: [0, 0, 1], limits: [-0.2, 1]}
          - {type: slider, bodies: [rubbed, world], anchor: [9, 0, 0], axis: [0, 0, -1], friction: 60}
          - {type: rope, bodies: [hung, world], points: [[12, 0, -0.3], [12, 0, 0]], length: 0.5}
          - {type: slider, bodies: [lifted, world], anchor: [15, 0, 0], axis: [0, 0, 1], motor: {offset: 0.1, max_force: 140}}
    """

    def test_numbers_are_those_of_statics(self):
        self.good(self.scene(self.SCENE), "results", ranks=1)
        header, lines = report(self.folder / "results/joints.csv")
        rows = [dict(zip((name.split(" ")[0] for name in header), line)) for line in lines]
        self.assertEqual([(r["frame"], r["joint"]) for r in rows], [(str(f), str(j)) for f in (0, 40, 80, 120) for j in range(6)])
        self.assertEqual([r["type"] for r in rows[-6:]], ["fixed", "hinge", "slider", "slider", "rope", "slider"])
        self.assertAlmostEqual(float(rows[-1]["time"]), 1.2, delta=1e-12)
        g, inertia = 9.81, 0.5  # kg m^2, of the wheel: 3 (1 + 1) / 12
        turn = -0.5 / inertia * 0.01**2 * 120 * 121 / 2  # rad: implicit Euler's parabola
        expected = [{"force_z": 2 * g, "torque_y": -2 * g * 0.25}, {"force_z": 3 * g, "motor": -0.5, "coordinate": turn},
                    {"limit": 4 * g, "coordinate": -0.2}, {"friction": -5 * g}, {"force_z": 6 * g, "coordinate": 0.5},
                    {"motor": 7 * g, "coordinate": 0.1}]
        for row, known in zip(rows[-6:], expected):
            for name in header[4:]:
                name = name.split(" ")[0]
                self.assertAlmostEqual(float(row[name]), known.get(name, 0), delta=1e-4, msg=f"{name} of joint {row['joint']}")

        with h5py.File(self.folder / "results/joints.h5") as file:
            self.assertEqual(file.attrs["columns"].decode().split(","), header[4:])
            for frame in (0, 40, 80, 120):
                table = file[f"frames/{frame:06d}"]
                texts = [line for line in lines if line[0] == str(frame)]
                self.assertEqual(table.attrs["time"], float(texts[0][1]))
                self.assertTrue((table[:] == np.array([[float(x) for x in line[4:]] for line in texts])).all())

    def test_the_drift_of_joints_is_that_of_the_rigid_ones(self):
        """The velocity level takes out half of what a rod is too long; a spring stays as long as it is, by its law."""
        text = """
            time: {{frame: 0.01, frames: 1}}
            gravity: [0, 0, 0]
            solver: {{level: velocity, stabilisation: 0.5}}
            bodies:
              - {{name: a, shape: {{particle: {{radius: 0.1}}}}, mass: 1, position: [1.2, 0, 0]}}
              - {{name: b, shape: {{particle: {{radius: 0.1}}}}, mass: 1, position: [1.6, 5, 0]}}
            joints:
              - {{type: spring, bodies: [a, world], points: [[1.2, 0, 0], [0, 0, 0]], length: 1, {}}}
              - {{type: spring, bodies: [b, world], points: [[1.6, 5, 0], [0, 5, 0]], length: 1, compliance: 1.0e+9}}
        """
        for rigid, drift in (("collide: true", .1), ("compliance: 1.0e+9", 0)):
            self.good(self.scene(text.format(rigid)), "joints", "-overwrite", ranks=1)
            header, rows = report(self.folder / "joints" / "report.csv")
            row = dict(zip(header, rows[-1]))
            self.assertAlmostEqual(float(row["joint_drift_max (m)"]), drift, 9, rigid)
            self.assertAlmostEqual(float(row["joint_drift_rms (m)"]), drift / math.sqrt(2), 9, rigid)


if __name__ == "__main__":
    unittest.main(verbosity=2)
