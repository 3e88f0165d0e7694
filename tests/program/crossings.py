#!/usr/bin/python3
"""The tool that counts crossings of cloths and threads, on results of runs: valid ones, ones with crossings known by hand, and
files that it must refuse. tests/collide compares the search itself with brute force."""
import os
import re
import unittest

import h5py
import numpy as np

from unibody_runs import SOURCE, ProgramTest, execute

TOOL = os.environ.get("UNIBODY_CROSSINGS", str(SOURCE / "build" / "release" / "crossings"))

# A cloth of 8 x 8 nodes, 1 m apart, that hangs from two corners.
HANGING = """
    title: a cloth by itself
    time: {frame: 0.016, frames: 6}
    output: {every: 2}
    cloths:
      - {name: sheet, grid: {size: [7, 7], nodes: [8, 8]}, mass: 1, thickness: 0.02, pins: [{node: [0, 0]}, {node: [7, 0]}]}
"""
FRAMES = [0, 2, 4, 6]

# A flat cloth and, turned upright into the plane x = 0.3 and reaching from y = -1.4 to 1.6, one of 7 columns that goes through it; a
# rope through both, and one beside them. Of the upright cloth its columns (7) and a diagonal of each cell between them (6) pass
# the flat one; of the flat one's lines and diagonals, 3 each pass the upright one: its nodes are at whole numbers and a half.
# A stitch of `needle` goes through the flat cloth, and another one through the upright one.
THROUGH = """
    title: cloths and ropes through each other
    time: {frame: 1.0e-6, frames: 1}
    cloths:
      - {name: flat, grid: {size: [7, 7], nodes: [8, 8]}, mass: 1, thickness: 0.002}
      - name: upright
        grid: {size: [2.4, 3], nodes: [5, 7]}
        mass: 1
        thickness: 0.002
        position: [0.3, 0.1, 0.1]
        orientation: {axis: [0, 1, 0], angle: 90}
    threads:
      - {name: needle, points: [[1.31, 0.12, -0.71], [1.31, 0.12, 0.7], [-0.4, 0.23, 0.72]], segments: 3, radius: 0.001, mass: 0.1}
      - {name: beside, points: [[9, 0, -1], [9, 0, 1]], segments: 4, radius: 0.001, mass: 0.1}
"""


def brute_force(position, cells):
    """Every edge with every face that has none of its nodes. For nodes in general position: nothing may just touch."""
    edges = np.unique(np.sort(np.concatenate([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]]), axis=1), axis=0)
    e, f = (k.ravel() for k in np.indices((len(edges), len(cells))))
    apart = (edges[e][:, :, None] != cells[f][:, None, :]).all((1, 2))
    p, q = position[edges[e[apart]]].transpose(1, 0, 2)
    a, b, c = position[cells[f[apart]]].transpose(1, 0, 2)

    def side(u, v, w, x):
        return np.einsum("ij,ij->i", np.cross(v - u, w - u), x - u) > 0

    ab, bc, ca = side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)
    return int(((side(a, b, c, p) != side(a, b, c, q)) & (ab == bc) & (bc == ca)).sum())


class CrossingsTest(ProgramTest):
    def check(self, *arguments):
        return execute([TOOL, *map(str, arguments)], timeout=60)

    def table(self, run):
        """Frame, time and the three counts of each line, and the total's three."""
        lines = run.out.splitlines()
        self.assertEqual(lines[0].split(), ["frame", "time", "crossings", "self", "between"])
        rows = [tuple(map(float, line.split())) for line in lines[1:-1] if ":" not in line]
        match = re.fullmatch(r"total: (\d+) crossings in (\d+) frames?, (\d+) of a surface with itself, (\d+) between surfaces",
                             lines[-1])
        self.assertIsNotNone(match, run.out)
        total, frames, own, between = map(int, match.groups())
        self.assertEqual(frames, len(rows))
        self.assertEqual([sum(row[k] for row in rows) for k in (2, 3, 4)], [total, own, between])
        return rows, (total, own, between)

    def refused(self, *arguments, says):
        run = self.check(*arguments)
        self.assertEqual(run.code, 2, run.out + run.err)
        self.assertEqual(len(run.err.splitlines()), 1, run.err)
        self.assertTrue(run.err.startswith("crossings: "), run.err)
        for text in says:
            self.assertIn(str(text), run.err)
        self.assertNotIn("total", run.out)


class Counts(CrossingsTest):
    def test_a_valid_run_has_none(self):
        self.good(self.scene(HANGING), "results")
        run = self.check(self.folder / "results")
        self.assertEqual(run.code, 0, run.out + run.err)
        rows, total = self.table(run)
        self.assertEqual([row[0] for row in rows], FRAMES)
        np.testing.assert_allclose([row[1] for row in rows], [0.016 * frame for frame in FRAMES])
        self.assertEqual(total, (0, 0, 0))
        self.assertEqual(self.check(self.folder / "results" / "frames.h5").out, run.out)

    def test_frames_changed_afterwards(self):
        """In frames 2 and 4 the cloth is uneven, and in frame 4 two of its nodes change places."""
        self.good(self.scene(HANGING), "results")
        random = np.random.default_rng(1)
        with h5py.File(self.folder / "results" / "frames.h5", "r+") as file:
            cells = file["surfaces/000000/cells"][:]
            uneven = np.array([[k % 8, k // 8, 0] for k in range(64)]) + random.uniform(-0.2, 0.2, (64, 3))
            swapped = uneven.copy()
            swapped[[9, 46]] = uneven[[46, 9]]
            file["frames/000002/position"][:] = uneven
            file["frames/000004/position"][:] = swapped
        expected = brute_force(swapped, cells)
        self.assertEqual(brute_force(uneven, cells), 0)
        self.assertGreater(expected, 20)
        run = self.check(self.folder / "results", "--per-surface")
        self.assertEqual(run.code, 1, run.out + run.err)
        rows, total = self.table(run)
        self.assertEqual(total, (expected, expected, 0))
        self.assertEqual([row[0] for row in rows if row[2] > 0], [4])
        self.assertIn("edges of 'sheet' (0) through faces of 'sheet' (0)", run.out)
        for frame, code in (("0", 0), ("4", 1), ("last", 0), ("all", 1)):
            run = self.check(self.folder / "results", "--frames", frame)
            self.assertEqual(run.code, code, f"--frames {frame}: {run.out}{run.err}")
            shown = [row[0] for row in self.table(run)[0]]
            self.assertEqual(shown, {"last": [6], "all": FRAMES}.get(frame) or [int(frame)])

    def test_surfaces_placed_through_each_other(self):
        for precision in ("double", "single"):
            self.good(self.scene(THROUGH), precision, "-set", f"output.precision={precision}")
            run = self.check(self.folder / precision, "--frames", 0, "--per-surface")
            self.assertEqual(run.code, 1, run.out + run.err)
            self.assertEqual(self.table(run)[1], (21, 0, 21))
            pairs = re.findall(r"(\d+): edges of '(\w+)' \(\d\) through faces of '(\w+)'", run.out)
            self.assertEqual(pairs, [("6", "flat", "upright"), ("13", "upright", "flat"), ("1", "needle", "flat"),
                                     ("1", "needle", "upright")])


class Refusals(CrossingsTest):
    def file(self, *groups):
        folder = self.folder / "results"
        folder.mkdir(exist_ok=True)
        with h5py.File(folder / "frames.h5", "w") as file:
            for group in groups:
                file.create_group(group)
        return folder

    def whole_file(self, change):
        """A good file of one triangle, after `change`."""
        folder = self.file("frames/000000")
        with h5py.File(folder / "frames.h5", "r+") as file:
            file["frames/000000"].attrs["time"] = 0.0
            file["frames/000000/position"] = np.eye(3)
            file["surfaces/000000/cells"] = np.array([[0, 1, 2]])
            change(file)
        return folder

    def test_options(self):
        self.refused(says=["no folder", "usage: crossings"])
        self.refused(self.folder, "--frame", says=["--frame", "usage: crossings"])
        self.refused(self.folder, self.folder / "b", says=[self.folder / "b", "one folder"])
        self.refused(self.folder, "--frames", says=["--frames needs"])

    def test_a_frame_that_is_not_there(self):
        folder = self.whole_file(lambda file: None)
        self.assertEqual(self.check(folder).code, 0)
        self.refused(folder, "--frames", 7, says=["no frame 7", "frames.h5", "0 to 0"])
        self.refused(folder, "--frames", "-1", says=["no frame -1"])
        for text in ("first", "0x", ""):
            self.refused(folder, "--frames", text, says=[f"'{text}'", "expected 'all', 'last' or"])

    def test_no_results(self):
        self.refused(self.folder / "nowhere", says=["nowhere", "expected the output folder"])
        self.refused(self.folder, says=["no frames.h5", self.folder, "expected the output folder"])

    def test_no_hdf5_file(self):
        path = self.folder / "frames.h5"
        for text in (b"", b"frame,time\n0,0\n"):
            path.write_bytes(text)
            self.refused(self.folder, says=[path, "HDF5"])

    def test_a_file_cut_short(self):
        folder = self.whole_file(lambda file: None)
        data = (folder / "frames.h5").read_bytes()
        for size in (len(data) // 2, len(data) - 8):
            (folder / "frames.h5").write_bytes(data[:size])
            self.refused(folder, says=[folder])

    def test_hdf5_files_of_something_else(self):
        self.refused(self.file(), says=["frames.h5", "no group /frames"])
        self.refused(self.file("frames"), says=["frames.h5", "no frame"])
        self.refused(self.file("frames/first"), says=["frames.h5", "no frame"])
        self.refused(self.file("frames/000000"), says=["frames.h5", "/frames/000000/position"])

    def test_a_scene_without_cloths(self):
        self.good(self.scene("""
            time: {frames: 1}
            bodies: [{shape: {sphere: {radius: 0.1}}, mass: 1}]
        """), "results")
        self.refused(self.folder / "results", says=["frames.h5", "no group /surfaces", "cloths or threads"])

    def test_arrays_of_a_wrong_kind(self):
        def replaced(name, value):
            def change(file):
                del file[name]
                file[name] = value
            return self.whole_file(change)

        cells, position = "surfaces/000000/cells", "frames/000000/position"
        self.refused(replaced(cells, np.array([[0, 1, 3]])), says=[cells, "body 3", "expected 0 to 2"])
        self.refused(replaced(cells, np.array([[0, 1, -1]])), says=[cells, "body -1", "expected 0 to 2"])
        self.refused(replaced(cells, np.array([[0, 1, 2, 0]])), says=[cells, "[1, 4]", "[N, 3 or 2]"])
        self.refused(replaced(cells, np.array([0, 1, 2])), says=[cells, "[3]"])
        self.refused(replaced(cells, np.array([[0.5, 1, 2]])), says=[cells, "whole numbers"])
        self.refused(replaced(position, np.zeros((3, 2))), says=[position, "[3, 2]", "[N, 3]"])
        self.refused(replaced(position, np.array([[0, 0, 0], [0, np.nan, 0], [1, 1, 1]])), says=[position, "body 1", "finite"])
        self.refused(self.whole_file(lambda file: file["frames/000000"].attrs.clear()), says=["/frames/000000", "time"])
        self.refused(self.whole_file(lambda file: file.copy(file["frames/000000"], file["frames"], "000001") or
                                     file["frames/000001"].pop("position")), says=["/frames/000001/position"])
        self.refused(self.whole_file(lambda file: file["surfaces"].pop("000000")), says=["/surfaces"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
