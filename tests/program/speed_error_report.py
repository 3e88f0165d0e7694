#!/usr/bin/python3
"""scripts/report: that its parts still run, what they say of runs, and that it goes on where it stopped."""
import csv
import importlib.util
import json
import os
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from unibody_runs import PROGRAM, SOURCE, execute

sys.path[:0] = [str(SOURCE / "scripts" / folder) for folder in ("reports", "benchmarks", "rivals")]
import rivals  # noqa: E402
import work_precision  # noqa: E402
from names import MINUTES  # noqa: E402
from parts import PARTS  # noqa: E402
from runs import COMMON, DEFAULTS  # noqa: E402


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


class Report(unittest.TestCase):
    """All parts on a few frames of small scenes: once for all tests."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="unibody_report_"))
        cls.first = cls.report()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

    @classmethod
    def report(cls, *words):
        return execute(
            [
                sys.executable, str(SOURCE / "scripts" / "report"), "--tiny", "--build", os.path.dirname(PROGRAM), "--output",
                str(cls.folder), *words],
            600,
        )

    def table(self, name):
        return rows_of(self.folder / "report" / f"{name}.csv")

    def test_every_part_is_on_one_page_with_nothing_outside_of_it(self):
        self.assertEqual(self.first.code, 0, self.first.err)
        text = (self.folder / "report.html").read_text()
        for name, part in PARTS.items():
            self.assertIn(f">{part.TITLE.replace(chr(39), '&#x27;')}</h2>", text, name)
        tables = re.findall(r'<table id="(\w+)">', text)
        self.assertEqual(sorted(tables), sorted(p.stem for p in (self.folder / "report").glob("*.csv")))
        self.assertNotRegex(text, r'(src|href)="(?!data:|#)')
        for note in re.findall(r"<(?:caption|figcaption)>(.*?)</", text):  # every table and plot names the command that makes it
            self.assertIn("<code>scripts/", note + "</code>")
        for name in tables:
            self.assertGreater(len(self.table(name)), 0, name)

    def test_the_sliding_box_stops_where_the_closed_form_says(self):
        rows = {(r["friction"], r["direction (degrees)"]): r for r in self.table("sliding_box")}
        for model, degrees, distance in (("disc", "0", 1.2356352), ("disc", "45", 1.2356352), ("saxce", "45", 1.2356352), ("box", "45", .8623613)):
            self.assertAlmostEqual(float(rows[model, degrees]["ours (m)"]) / distance, 1, 2)
            self.assertLess(float(rows[model, degrees]["lift (m)"]), 1e-3)
        for row in rows.values():
            if row["friction"] != "postprocess":  # whose closed form is a point's, not a box's
                self.assertAlmostEqual(float(row["ours (m)"]) / float(row["closed form (m)"]), 1, 2, row)
        self.assertAlmostEqual(float(rows["cone", "0"]["lift (m)"]) / .318874, 1, 2)  # the cone's own, published

    def test_the_first_iteration_of_both_jacobi_solvers_is_the_same(self):
        first = {r["solver"]: r["same states, L2 (mm)"] for r in self.table("discs") if r["k"] == "1"}
        self.assertEqual(first["AJ"], first["J"])
        self.assertEqual(first["AJ optimized"], first["J"])
        self.assertNotEqual(first["AJ"], first["GS"])

    def test_the_residual_of_figure_9_falls_with_the_iterations(self):
        residual = {(r["solver"], r["k"]): float(r["same states, natural residual (mm, median)"]) for r in self.table("discs")}
        self.assertEqual(residual["AJ", "1"], residual["J", "1"])
        for solver in ("AJ", "AJ optimized", "GS", "J"):
            self.assertLess(residual[solver, "3"], residual[solver, "1"], solver)
            self.assertGreater(residual[solver, "3"], 0)

    def test_more_iterations_end_nearer_to_the_converged_step(self):
        for scene in ("boxes", "cloth"):
            rows = [r for r in self.table("work_precision") if (r["scene"], r["substeps"], r["ranks"], r["variant"]) == (scene, "1", "1", "default")]
            for solver in ("AJ", "GS"):
                errors = {r["iterations"]: float(r["to the converged step"]) for r in rows if r["solver"] == solver}
                self.assertLess(errors["40"], errors["4"] / 3, (scene, solver))

    # The step's own error falls as the step: a quarter with four substeps, whatever solved them.
    def test_substeps_end_nearer_to_the_fine_reference(self):
        away = {(r["solver"], r["substeps"]): float(r["to the fine-step reference"]) for r in self.table("work_precision")
                if r["scene"] == "cloth" and r["iterations"] in ("", "40") and r["ranks"] == "1"}
        for solver in ("AJ", "GS", "Newton"):
            self.assertAlmostEqual(away[solver, "1"] / away[solver, "4"], 4, delta=1.2)

    # Two ways to one number: -error_estimate solves on and takes it back, the report runs a converged frame; the cloth's by Newton's
    # method, from which the converged step of the default form is some way off: a micrometre at most.
    def test_the_run_knows_its_own_error(self):
        for row in self.table("error_bars"):
            own, found, known = (float(row[c]) for c in ("its own estimate", "distance found", "known to"))
            self.assertGreater(found, 0)
            self.assertLess(abs(own - found), (1e-6 * found if row["scene"] == "boxes" else max(.05 * found, 1e-6)) + known, row)

    # And what the benchmarks set for all runs, their row of the shipped settings takes back.
    def test_the_defaults_are_those_of_the_program(self):
        def solver_of(name, values):
            folder = self.folder / name
            words = [PROGRAM, str(SOURCE / "scenes" / "boxes_500.yaml"), "-output", str(folder)]
            run = execute(words + [w for value in ["time.frames=1", "output.every=0", *values] for w in ("-set", value)], 60)
            self.assertEqual(run.code, 0, run.err)
            summary = json.loads((folder / "summary.json").read_text())
            return summary["settings"]["solver"], summary["plans"][0]["iterations"]

        found, default = solver_of("defaults", []), work_precision.DEFAULT
        self.assertEqual((found[0]["name"], found[0]["iterations"], found[1]), (default.solver, "auto", default.iterations))
        self.assertEqual(solver_of("taken_back", COMMON + DEFAULTS), found)
        self.assertNotEqual(solver_of("common", COMMON), found)
        self.assertEqual(solver_of("shipped", COMMON + work_precision.SHIPPED.values()), found)
        self.assertIn(("unibody", work_precision.SHIPPED), rivals.PILE)

    def test_siconos_and_this_program_agree(self):
        rows = self.table("contact_problems")
        theirs = rows[-1]
        if importlib.util.find_spec("siconos") is None:
            self.assertIn("not installed", theirs["solver"])
            self.skipTest("python3-siconos is not installed")
        self.assertLess(float(theirs["natural map"]), 1e-9)
        self.assertEqual(theirs["within the tolerance"], str(float(theirs["natural map"]) <= 1e-10))
        for row in rows[:5]:  # two solutions are as far apart as both leave unsolved, and what each leaves, its natural map tells
            self.assertGreater(int(row["contacts"]), 10)
            left = float(row["natural map"]) + float(theirs["natural map"])
            self.assertLess(float(row["velocities from Siconos"]), 3 * left, row)
            self.assertLess(left, 1e-8, row)
        for row in rows[2:5]:  # 500 iterations and more solve 16 contacts to round-off; what 50 leave is what the table is made to tell
            self.assertLess(float(row["natural map"]), 1e-14, row)

    def test_what_was_run_is_not_run_again(self):
        before = {p.name: p.read_bytes() for p in (self.folder / "report").glob("*.csv")}
        again = self.report("sliding", "hanging_cloth")
        self.assertIn(" 0 runs made", again.err)
        kept = sorted((self.folder / "report" / "runs").glob("*.json"))
        self.assertEqual({p.name: p.read_bytes() for p in (self.folder / "report").glob("*.csv")}, before)
        self.assertIn(" 10 runs made", self.report("--again", "sliding").err)
        self.assertEqual((self.folder / "report" / "sliding_box.csv").read_bytes(), before["sliding_box.csv"])
        for path in kept:  # as if stopped before the first run
            path.unlink()
        self.assertIn(" 10 runs made", self.report("sliding").err)

    def test_the_page_tells_of_the_measuring_not_of_the_reading(self):
        run = self.report("sliding")
        self.assertEqual(run.code, 0, run.err)
        for path in (self.folder / "report" / "runs").glob("*.json"):
            kept = json.loads(path.read_text())
            path.write_text(json.dumps(dict(kept, made="2001-02-03 04:05", load=7.0, version="of-then")))
        self.assertIn(" 0 runs made", self.report("sliding").err)
        text = (self.folder / "report.html").read_text()
        self.assertIn("2001-02-03 04:05", text)
        self.assertIn("7.0 - too busy", text)
        self.assertIn("<tr><th>program</th><td>of-then</td></tr>", text)

    def test_time_left_is_told(self):
        self.assertRegex(self.first.err, r"work_precision \(\d+ of \d+ runs left, about \d+ min\): ")
        self.assertEqual(set(PARTS), set(MINUTES["quick"]))
        self.assertEqual(set(PARTS), set(MINUTES["full"]))
        self.assertLess(sum(MINUTES["quick"].values()), 15)

    def test_an_unknown_part_is_refused(self):
        words = [sys.executable, str(SOURCE / "scripts" / "report"), "sliding", "slidding", "--output", str(self.folder / "none")]
        run = execute(words, 60)  # before anything is built
        self.assertEqual((run.code, run.out), (2, ""))
        self.assertIn("error: unknown: slidding; there are published_tables, ", run.err)

    def test_the_page_is_not_cut_down_to_a_part(self):
        before = (SOURCE / "docs/measurements.md").read_bytes()
        for words in (("sliding",), ()):  # tiny, as all runs here
            run = self.report("--measurements", *words)
            self.assertEqual(run.code, 2)
            self.assertIn("--measurements rewrites all figures", run.err)
        self.assertEqual((SOURCE / "docs/measurements.md").read_bytes(), before)


if __name__ == "__main__":
    unittest.main()
