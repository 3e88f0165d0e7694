"""Triangle surfaces from files: reading, coarsening, what is open in them, and the signed distance to them."""
import os

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

READERS = {".obj": vtk.vtkOBJReader, ".stl": vtk.vtkSTLReader, ".ply": vtk.vtkPLYReader}


class Surface:
    """Points (n x 3) and triangles (m x 3), counterclockwise from the outside."""

    def __init__(self, points, triangles):
        self.points, self.triangles = points, triangles

    def corners(self):
        return [self.points[self.triangles[:, k]] for k in range(3)]

    def volume(self):
        a, b, c = self.corners()
        return np.einsum("ij,ij->", a, np.cross(b, c)) / 6

    def edge_faults(self):
        """How many edges have one triangle, and how many three or more."""
        t = self.triangles
        edges = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
        counts = np.unique(edges, axis=0, return_counts=True)[1]
        return int((counts == 1).sum()), int((counts > 2).sum())

    def poly_data(self):
        points, cells, data = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
        points.SetData(numpy_to_vtk(self.points, deep=True))
        offsets = np.arange(0, 3 * len(self.triangles) + 1, 3)
        cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(self.triangles.ravel(), deep=True))
        data.SetPoints(points)
        data.SetPolys(cells)
        return data


def from_poly_data(data):
    """Points that coincide become one; triangles that lose a corner by that go."""
    clean, triangulate = vtk.vtkCleanPolyData(), vtk.vtkTriangleFilter()
    clean.SetTolerance(0)
    clean.SetInputData(data)
    triangulate.SetInputConnection(clean.GetOutputPort())
    triangulate.PassVertsOff()
    triangulate.PassLinesOff()
    triangulate.Update()
    data = triangulate.GetOutput()
    if data.GetNumberOfCells() == 0:
        return Surface(np.zeros((0, 3)), np.zeros((0, 3), int))
    return Surface(vtk_to_numpy(data.GetPoints().GetData()).astype(float),
                   vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64))


def read(path):
    reader = READERS[os.path.splitext(path)[1].lower()]()
    reader.SetFileName(path)
    reader.Update()
    return from_poly_data(reader.GetOutput())


def coarsened(surface, triangles):
    """About so many triangles, by quadric decimation."""
    decimate = vtk.vtkQuadricDecimation()
    decimate.SetInputData(surface.poly_data())
    decimate.SetTargetReduction(max(0.0, 1 - triangles / len(surface.triangles)))
    decimate.VolumePreservationOn()
    decimate.Update()
    return from_poly_data(decimate.GetOutput())


class Distance:
    """Nearest points, and the side by the generalized winding number (Jacobson et al. 2013), which holes barely change."""

    def __init__(self, surface):
        self.locator = vtk.vtkStaticCellLocator()
        self.data = surface.poly_data()
        self.locator.SetDataSet(self.data)
        self.locator.BuildLocator()
        self.winding = Winding(surface)

    def nearest(self, points):
        generic, cell, part, squared = vtk.vtkGenericCell(), vtk.mutable(0), vtk.mutable(0), vtk.mutable(0.0)
        found, place = np.empty_like(points), [0.0, 0.0, 0.0]
        for i, point in enumerate(points):
            self.locator.FindClosestPoint(point, place, generic, cell, part, squared)
            found[i] = place
        return found

    def inside(self, points):
        return np.abs(self.winding.of(points)) > 0.5  # or inside out


class Winding:
    """Triangles near a point count by their solid angles, clusters of distant ones as one dipole each (Barill et al. 2018)."""

    FAR = 3.0  # radii of a cluster

    def __init__(self, surface):
        a, b, c = surface.corners()
        centres = (a + b + c) / 3
        low = centres.min(0)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        cell = np.sqrt(2 * area / (4 * np.sqrt(len(a))))  # clusters: some times the square root of the triangles
        keys = np.floor((centres - low) / cell).astype(np.int64)
        keys = np.ravel_multi_index(keys.T, keys.max(0) + 1)
        order = np.argsort(keys, kind="stable")
        self.corners = [x[order] for x in (a, b, c)]
        self.starts = np.flatnonzero(np.diff(keys[order], prepend=-1))
        self.sizes = np.diff(self.starts, append=len(a))
        a, b, c = self.corners
        normals = np.cross(b - a, c - a) / 2
        areas = np.linalg.norm(normals, axis=1)
        self.normals = np.add.reduceat(normals, self.starts)
        areas = np.maximum(areas, 1e-300)
        self.centres = np.add.reduceat(areas[:, None] * (a + b + c) / 3, self.starts)
        self.centres /= np.add.reduceat(areas, self.starts)[:, None]
        cluster = np.repeat(np.arange(len(self.starts)), self.sizes)
        reach = np.max([np.linalg.norm(x - self.centres[cluster], axis=1) for x in self.corners], axis=0)
        self.radii = np.maximum.reduceat(reach, self.starts)

    def of(self, points):
        step = max(1, 2_000_000 // len(self.starts))
        return np.concatenate([self._of(points[i:i + step]) for i in range(0, len(points), step)] or [np.zeros(0)])

    def _of(self, points):
        offset = self.centres[None] - points[:, None]
        distance = np.linalg.norm(offset, axis=2)
        far = distance > self.FAR * self.radii
        dipole = np.einsum("pcx,cx->pc", offset, self.normals) / np.where(far, distance, 1) ** 3
        winding = np.where(far, dipole, 0).sum(1)
        point, cluster = np.nonzero(~far)
        step = 20_000
        for i in range(0, len(point), step):
            p, c = point[i:i + step], cluster[i:i + step]
            sizes = self.sizes[c]
            first = np.cumsum(sizes) - sizes
            triangle = np.arange(sizes.sum()) + np.repeat(self.starts[c] - first, sizes)
            owner = np.repeat(p, sizes)
            winding += np.bincount(owner, self._solid_angles(points[owner], triangle), len(points))
        return winding / (4 * np.pi)

    def _solid_angles(self, points, triangle):
        """By van Oosterom and Strackee (1983)."""
        a, b, c = (x[triangle] - points for x in self.corners)
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        dot = lambda x, y: np.einsum("ij,ij->i", x, y)
        return 2 * np.arctan2(dot(a, np.cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
