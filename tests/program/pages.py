#!/usr/bin/python3
"""The pages: links lead to what is there, the README is short, and what it shows works as it says."""
import csv
import re
import shlex
import subprocess
import sys
import unittest

import h5py
import yaml

from unibody_runs import SOURCE, ProgramTest, unibody

PAGES = sorted(p for folder in (".", "docs", "scenes") for p in (SOURCE / folder).glob("*.md"))
LINK = re.compile(r"\]\(([^)\s]+)\)")


def prose(path):
    return re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)


def anchors(path):
    """As sites that show Markdown make them of headings."""
    titles = re.findall(r"^#+ (.*)$", prose(path), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", re.sub(r"\]\([^)]*\)", "", title).lower()).replace(" ", "-") for title in titles}


class Pages(unittest.TestCase):
    def test_links_lead_somewhere(self):
        count = 0
        for page in PAGES:
            for link in LINK.findall(prose(page)):
                if link.startswith("http"):
                    continue
                name, _, anchor = link.partition("#")
                target = (page.parent / name).resolve() if name else page
                self.assertTrue(target.exists(), f"{page}: {link}")
                if anchor:
                    self.assertIn(anchor, anchors(target), f"{page}: {link}")
                count += 1
        self.assertGreater(count, 60)

    def test_the_readme_is_short(self):
        self.assertLessEqual((SOURCE / "README.md").stat().st_size, 8192)

    def test_every_page_can_be_found_from_the_readme(self):
        seen, left = set(), [SOURCE / "README.md"]
        while left:
            page = left.pop()
            if page in seen or page.suffix != ".md":
                continue
            seen.add(page)
            left += [(page.parent / link.partition("#")[0]).resolve() for link in LINK.findall(prose(page))
                     if not link.startswith(("http", "#"))]
        self.assertEqual(set(PAGES) - seen, set())

    def test_scripts_that_are_named_are_there(self):
        for page in PAGES:
            for name in re.findall(r"(?:^|[`\s(])(scripts/[a-z_]+(?:[/.-][a-z_]+)*)(?=[`\s,.;):]|$)", page.read_text(encoding="utf-8"), re.MULTILINE):
                self.assertTrue((SOURCE / name.rstrip(".")).exists(), f"{page}: {name}")

    def test_options_that_are_named_are_known(self):
        """The table of options and -help tell of the same ones."""
        told = subprocess.run([str(SOURCE / "scripts" / "run"), "-h"], capture_output=True, text=True, check=True).stdout
        self.assertIn("-output", told)
        table = re.findall(r"^\|([^|]*)\|", (SOURCE / "docs" / "program.md").read_text(encoding="utf-8"), re.MULTILINE)
        listed = {word for row in table for word in re.findall(r"`(-[a-z_]+)", row)}
        helped = {line.split()[0].rstrip(",") for line in unibody("-help", ranks=1).out.splitlines() if line.startswith("  -")}
        self.assertEqual(helped - listed - {"-settings", "-schema"}, set())
        self.assertEqual(listed - helped, set())


class FirstScene(ProgramTest):
    def test_it_runs_and_does_what_its_title_says(self):
        text = re.search(r"```yaml\n(.*?)```", (SOURCE / "README.md").read_text(encoding="utf-8"), re.DOTALL).group(1)
        self.assertLessEqual(len(text.splitlines()), 12)
        self.assertEqual(len(yaml.safe_load(text)["bodies"]), 3)
        run = self.good(self.scene(text), "first")
        self.assertIn("41 dynamic (40 sphere, 1 box)", run.out)
        with open(self.folder / "first/report.csv", encoding="ascii") as file:
            header, *rows = [line.strip().split(",") for line in file]
        energy = header.index("kinetic_energy (J)")
        self.assertEqual(len(rows), 300)
        self.assertLess(float(rows[-1][energy]), 0.05)  # J: they have come to rest
        self.assertGreater(max(float(row[energy]) for row in rows), 5)  # the plate fell by more than a metre


class HopperTutorial(ProgramTest):
    def test_it_works_as_written(self):
        text = (SOURCE / "docs" / "tutorial-hopper.md").read_text(encoding="utf-8")
        scene = self.scene(re.search(r"```yaml\n(.*?)```", text, re.DOTALL).group(1), "hopper.yaml")
        script = self.folder / "rate.py"
        script.write_text(re.search(r"```python\n(.*?)```", text, re.DOTALL).group(1), encoding="utf-8")
        self.good(scene, "hopper")
        told = subprocess.run([sys.executable, script, self.folder / "hopper/report.csv"], capture_output=True, text=True, check=True).stdout
        rows = [[float(word) for word in line.split()] for line in told.splitlines()[1:]]
        self.assertEqual([row[1] for row in rows[:4]], [0, 0, 0, 0], "the gate was not shut")
        self.assertEqual(sum(row[1] for row in rows), 800)
        steady = [row[2] for row in rows[5:9]]  # 1.25 to 2.25 s
        for rate in steady:
            self.assertAlmostEqual(rate, sum(steady) / 4, delta=0.1 * sum(steady) / 4, msg="the rate depends on the filling")
        self.check_other_grains(text, scene, script)

    def check_other_grains(self, text, scene, script):
        table = re.findall(r"^\| (0\.\d) \| ([\d.]+) \|$", text, re.MULTILINE)
        self.assertEqual(len(table), 2)
        commands = [shlex.split(line)[2:] for line in text.splitlines() if line.startswith("scripts/run hopper.yaml") and "-set" in line]
        self.assertEqual([words[words.index("-output") + 1] for words in commands], ["results/fill", "results/rough", "results/slippery"])
        for words in commands:
            run = unibody(scene, *words, ranks=1, folder=self.folder)
            self.assertEqual(run.code, 0, run.err)
        for name, (friction, told) in zip(("rough", "slippery"), table):
            report = self.folder / f"results/{name}/report.csv"
            lines = subprocess.run([sys.executable, script, report], capture_output=True, text=True, check=True).stdout.splitlines()
            rates = [float(line.split()[2]) for line in lines[2:5]]
            self.assertAlmostEqual(sum(rates) / 3, float(told), delta=0.051, msg=friction)


class GripperTutorial(ProgramTest):
    def run_with(self, force):
        """The report's rows by column, and how high the box is at the end (m)."""
        text = (SOURCE / "docs" / "tutorial-gripper.md").read_text(encoding="utf-8")
        scene = self.scene(re.search(r"```yaml\n(.*?)```", text, re.DOTALL).group(1), "gripper.yaml")
        self.good(scene, "run", "-overwrite", *(word for k in (0, 1) for word in ("-set", f"joints[{k}].motor.max_force={force}")))
        with open(self.folder / "run/report.csv", encoding="ascii") as file:
            rows = list(csv.DictReader(file))
        with h5py.File(self.folder / "run/frames.h5") as file:
            height = file["frames/000300/position"][1, 2]
        return {name: [float(row[name] or 0) for row in rows] for name in rows[0]}, height

    def test_statics_and_the_page_say_the_same(self):
        columns, height = self.run_with(30)
        press, carry = columns["finger_force_x (N)"], columns["finger_force_z (N)"]
        self.assertAlmostEqual(press[-1], 30, delta=1e-3 * 30)
        self.assertAlmostEqual(carry[-1], 9.81, delta=1e-3 * 9.81)
        self.assertAlmostEqual(max(carry), 9.81 + 1.8, delta=0.02 * 11.6)  # the mean of a frame in which the acceleration falls
        self.assertAlmostEqual(height, 0.4, delta=2e-4)

    def test_less_force_slips_and_still_less_does_not_lift(self):
        # The box has 22 / 2 - 9.81 = 1.19 m/s^2 until it is as fast as the hand, whose acceleration is 1.8 (1 - 2 t) m/s^2.
        caught_up = (1.8 - 1.19) / 1.8
        slip = (1.8 - 1.19) / 2 * caught_up ** 2 - 1.8 / 3 * caught_up ** 3
        self.assertAlmostEqual(slip, 0.012, delta=0.0005)  # as the page says
        self.assertAlmostEqual(0.4 - self.run_with(22)[1], slip, delta=0.05 * slip)
        columns, height = self.run_with(18)
        self.assertEqual(max(columns["lifted_count (1)"]), 0)
        self.assertAlmostEqual(height, 0.1, delta=1e-4)


class DrumTutorial(ProgramTest):
    def test_small_balls_gather_in_the_middle(self):
        text = (SOURCE / "docs" / "tutorial-drum.md").read_text(encoding="utf-8")
        scene = self.scene(re.search(r"```yaml\n(.*?)```", text, re.DOTALL).group(1), "drum.yaml")
        run = self.good(scene, "run", ranks=2)
        self.assertIn("inlet large: 200 bodies", run.out)
        self.assertIn("inlet small: 1400 bodies", run.out)
        with open(self.folder / "run/report.csv", encoding="ascii") as file:
            rows = list(csv.DictReader(file))
        table = re.search(r"\| small balls' part of the mass \|(.*)\|\n", text).group(1)
        told = dict(zip((75, 125, 175, 225, 300), map(float, table.split("|"))))
        for end, part in told.items():
            small, large = (sum(float(row[f"{name}_core_mass (kg)"]) for row in rows[end - 25:end]) for name in ("small", "large"))
            self.assertAlmostEqual(small / (small + large), part, delta=0.006, msg=f"frames up to {end}")
        self.assertLess(told[75], 0.55)
        self.assertGreater(told[300], 0.8)


class CapeTutorial(ProgramTest):
    def columns_of(self, name, *options):
        text = (SOURCE / "docs" / "tutorial-cape.md").read_text(encoding="utf-8")
        scene = self.scene(re.search(r"```yaml\n(.*?)```", text, re.DOTALL).group(1), "cape.yaml")
        self.good(scene, name, *options)
        with open(self.folder / name / "report.csv", encoding="ascii") as file:
            rows = list(csv.DictReader(file))
        return {column: [float(row[column] or 0) for row in rows] for column in rows[0]}

    def test_the_cape_follows_and_goes_through_nothing(self):
        columns = self.columns_of("cape")
        self.assertEqual(max(columns["crossings (1)"]), 0)
        self.assertEqual(max(columns["held_pairs (1)"]), 0)
        stretch = columns["stretch_max[wool] (1)"]
        self.assertLess(max(stretch), 0.07)
        self.assertLess(stretch[-1], 0.01)
        with h5py.File(self.folder / "cape/frames.h5") as file:
            places = [file[f"frames/{frame:06d}/position"][:] for frame in (0, 250)]
        # Half a turn about z and 1.5 m along y take (x, y, z) to (-x, 1.5 - y, z).
        edge = abs(places[0][:, 2] - 1.36) < 1e-6
        self.assertEqual(edge.sum(), 21)
        for before, after in zip(places[0][edge], places[1][edge]):
            for found, right in zip(after, (-before[0], 1.5 - before[1], before[2])):
                self.assertAlmostEqual(found, right, delta=1e-4)
        self.assertAlmostEqual(places[1][2:, 2].min(), 0.36, delta=0.01)  # it hangs down

    def test_more_iterations_stretch_it_less(self):
        # What four frames of the turn exceed: the largest of all is that of one link in one frame, by chance.
        peaks = [sorted(self.columns_of(name, "-set", f"solver.iterations={n}")["stretch_max[wool] (1)"])[-5]
                 for name, n in (("few", 50), ("more", 200))]
        self.assertLess(peaks[1], 0.6 * peaks[0])


if __name__ == "__main__":
    unittest.main()
