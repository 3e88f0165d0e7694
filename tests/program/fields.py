#!/usr/bin/python3
"""scripts/fields: masses, momenta and forces times branches are kept by the grid, and a column of grains is stressed by its weight."""
import subprocess
import unittest

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

from unibody_runs import SOURCE, ProgramTest

FLIGHT = """
    time: {frame: 0.01, frames: 4}
    gravity: [0, 0, 0]
    output: {every: 4}
    bodies:
      - {lattice: {count: 60, columns: [4, 5], spacing: [0.3, 0.3, 0.3], height: 1}, shape: {sphere: {radius: 0.1}}, density: 500, velocity: [1, -2, 0.5]}
      - {shape: {box: {size: [9, 9, 1]}}, motion: fixed, position: [0, 0, -3]}
"""

# Smooth walls bear no weight.
COLUMN = """
    time: {frame: 0.01, frames: 250, substeps: 4}
    solver: {iterations: 100}
    output: {every: 250, contacts: 250}
    materials: {grain: {friction: 0.5}, wall: {friction: 0}, pairs: [{between: [grain, wall], friction: 0}]}
    bodies:
      - {container: {size: [0.5, 0.5]}, material: wall}
      - {lattice: {count: 600, columns: [7, 7], spacing: [0.066, 0.066, 0.066], height: 0.05, jitter: 0.004}, shape: {sphere: {radius: 0.03}}, density: 2000, material: grain}
"""


class Fields(ProgramTest):
    def fields(self, name, *options, code=0):
        done = subprocess.run([str(SOURCE / "scripts/fields"), str(self.folder / name), *options], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        if code != 0:
            return done.stderr
        reader = vtkXMLImageDataReader()
        reader.SetFileName(done.stdout.split(":")[0])
        reader.Update()
        image = reader.GetOutput()
        x, y, z = (n - 1 for n in image.GetDimensions())
        cells = {image.GetCellData().GetArrayName(k): vtk_to_numpy(image.GetCellData().GetArray(k)) for k in range(image.GetCellData().GetNumberOfArrays())}
        shaped = {name: values.reshape(z, y, x, -1).squeeze() for name, values in cells.items()}
        return image.GetOrigin(), image.GetSpacing()[0], shaped

    def test_what_flies_together(self):
        self.good(self.scene(FLIGHT), "run")
        _, cell, fields = self.fields("run", "--cell", "0.07", "--width", "0.09")
        mass = 60 * 500 * 4 / 3 * np.pi * 0.001
        self.assertAlmostEqual(fields["density"].sum() * cell ** 3, mass, delta=0.01 * mass)  # 3 widths hold all but 0.3 % on each side
        full = fields["density"] > 1e-6 * fields["density"].max()
        np.testing.assert_allclose(fields["velocity"][full], [[1, -2, 0.5]] * full.sum(), rtol=1e-6)
        self.assertLess(fields["temperature"][full].max(), 1e-6)
        self.assertNotIn("stress", fields)
        # Half of the space holds half of the mass, since the places are the same on both sides of x = 0 but for the flight.
        _, cell, half = self.fields("run", "--cell", "0.05", "--width", "0.05", "--box", "0.04,-9,-1,9,9,9", "--out", str(self.folder / "half.vti"))
        self.assertAlmostEqual(half["density"].sum() * cell ** 3, mass / 2, delta=1e-3 * mass)

    def test_a_column_of_grains(self):
        self.good(self.scene(COLUMN), "run", timeout=300)
        origin, cell, fields = self.fields("run", "--cell", "0.03", "--width", "0.03", "--box=-0.4,-0.4,-0.3,0.4,0.4,1.2")
        with h5py.File(self.folder / "run/contacts.h5") as file:
            frame = file["frames/000250"]
            force, places = frame["force"][:], frame["places"][:].reshape(-1, 2, 3)
        moments = np.einsum("ki,kj->ij", force, places[:, 0] - places[:, 1])
        volume = cell ** 3
        for part, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]):
            self.assertAlmostEqual(fields["stress"][..., part].sum() * volume, 0.5 * (moments[i, j] + moments[j, i]), delta=1e-4 * np.trace(moments))
        # At a height in the middle, averaged over the section: the weight of what is above it.
        weight_above = np.cumsum((fields["density"].sum(axis=(1, 2)) * volume * 9.81)[::-1])[::-1]
        force_through = fields["stress"][..., 2].sum(axis=(1, 2)) * cell ** 2
        heights = origin[2] + (np.arange(len(force_through)) + 0.5) * cell
        for k in np.flatnonzero((heights > 0.12) & (heights < 0.3)):
            above = weight_above[k] - 0.5 * (weight_above[k] - weight_above[k + 1])
            self.assertAlmostEqual(force_through[k], above, delta=0.05 * weight_above[0])
        self.assertGreater(weight_above[0], 1200)

    def test_bad_options(self):
        self.good(self.scene(FLIGHT), "run")
        self.assertIn("found --frame 3, expected last, all or one of 0, 4", self.fields("run", "--frame", "3", code=2))
        self.assertIn("found -1, expected a length > 0 (m)", self.fields("run", "--cell=-1", code=2))
        self.assertIn("found 0,0,0,1,1,0, expected x,y,z,x,y,z", self.fields("run", "--box", "0,0,0,1,1,0", code=2))
        self.assertIn("expected at most 50,000,000", self.fields("run", "--cell", "0.0001", code=2))
        self.assertIn("frames.h5", self.fields("nowhere", code=2))


if __name__ == "__main__":
    unittest.main()
