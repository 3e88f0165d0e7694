#!/usr/bin/python3
"""The settings' table as told by -settings, -schema, scenes/README.md and by what the reader takes and refuses: all say the same."""
import json
import re
import unittest

import jsonschema
import yaml

from unibody_runs import SCENES, ProgramTest, unibody

SMALL = """
    time: {frames: 1}
    bodies:
      - {shape: {plane: {normal: [0, 0, 1]}}}
      - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 0.11]}
"""


def told(option):
    run = unibody(option, ranks=2)
    if run.code != 0:
        raise AssertionError(run.err)
    return run.out


def rows(text):
    """Of tables in Markdown: {key: (unit, default)}."""
    found = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) >= 4 and re.fullmatch(r"`[a-z_.]+`", cells[0]):
            found.setdefault(cells[0].strip("`"), (cells[1], cells[2]))
    return found


class Schema(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.schema = json.loads(told("-schema"))
        jsonschema.Draft7Validator.check_schema(cls.schema)
        cls.validator = jsonschema.Draft7Validator(cls.schema)
        cls.settings = rows(told("-settings"))

    def faults(self, scene):
        return [".".join(map(str, e.absolute_path)) for e in self.validator.iter_errors(scene)]

    def test_every_scene_holds_to_it(self):
        scenes = sorted(SCENES.glob("*.yaml"))
        self.assertGreater(len(scenes), 30)
        for scene in scenes:
            with self.subTest(scene.name):
                self.assertEqual(self.faults(yaml.safe_load(scene.read_text())), [])

    def wrong_values(self):
        """(section, key, value): one outside of every bound of every setting, a name that is none, and a text for a number."""
        for section in ("time", "output", "solver"):
            for key, value in self.schema["properties"][section]["properties"].items():
                for kind in value.get("anyOf", [value]):
                    if "minimum" in kind:
                        yield section, key, kind["minimum"] - 1
                    if "exclusiveMinimum" in kind:
                        yield section, key, kind["exclusiveMinimum"]
                    if "exclusiveMaximum" in kind:
                        yield section, key, kind["exclusiveMaximum"]
                    if "maximum" in kind:
                        yield section, key, kind["maximum"] + 1
                    if "const" not in kind:
                        yield section, key, "no_such_thing"

    def test_what_it_refuses_the_reader_refuses(self):
        wrong = list(self.wrong_values())
        self.assertGreater(len(wrong), 50)
        self.assertEqual({f"{section}.{key}" for section, key, _ in wrong}, set(self.settings))
        for section in ("bodies", "cloths", "threads", "solids", "joints"):
            entry = self.schema["properties"][section]["items"]
            good = {key: "ball" for key in entry.get("required", [])}
            self.assertEqual(self.faults({section: [good]}), [])
            self.assertTrue(self.faults({section: [{**good, "colour": 1}]}), section)
        self.assertTrue(self.faults({"joints": [{"type": "ball", "bodies": [], "motor": {}}]}), "a ball has no motor")
        self.assertEqual(self.faults({"joints": [{"type": "hinge", "bodies": [], "motor": {}}]}), [])
        for section, key, value in [*wrong, ("solver", "itertions", 3), ("output", "evry", 3)]:
            with self.subTest(f"{section}.{key}={value}"):
                scene = {"bodies": [{}], section: {key: value}}
                self.assertTrue(self.faults(scene), "the schema takes it")
                options = ["-set", f"{section}.{key}={value}"]
                if (section, key) == ("solver", "stabilisation"):
                    options += ["-set", "solver.level=velocity"]
                if (section, key) == ("solver", "warm_start"):
                    options += ["-set", "solver.level=velocity", "-set", "solver.stages=auto"]
                run = unibody(self.scene(SMALL), "-output", self.folder / "wrong", *options, ranks=1)
                self.assertEqual(run.code, 2, run.err)
                self.assertIn(f"key '{section}.{key}'", run.message[0])

    def test_defaults_are_what_a_scene_has_without_them(self):
        options = []
        for key, (_, default) in self.settings.items():
            if key not in ("time.frames", "solver.stabilisation"):  # those of the scene; of the velocity level alone
                options += ["-set", f"{key}={default}"]
        plain, told_all = self.good(self.scene(SMALL), "plain"), self.good(self.scene(SMALL), "told", *options)
        self.assertEqual(plain.state, told_all.state)

    def test_the_reference_page_says_the_same(self):
        page = rows((SCENES / "README.md").read_text())
        for key, told_of in self.settings.items():
            with self.subTest(key):
                self.assertEqual(page.get(key, page.get(key.removeprefix("solver."))), told_of)


if __name__ == "__main__":
    unittest.main()
