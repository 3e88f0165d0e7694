#!/usr/bin/python3
"""The tables of keys as told by -settings, -schema and the pages of scenes. (tests/python/test_scene_keys.py has what the reader refuses.)"""
import json
import re
import unittest

import jsonschema
import yaml

from unibody_runs import SCENES, SOURCE, ProgramTest, unibody


class Loader(yaml.SafeLoader):
    """YAML 1.2, as the program reads it: `on` is a text."""


Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:bool"]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()}
Loader.add_implicit_resolver("tag:yaml.org,2002:bool", re.compile(r"^(?:true|false)$"), list("tf"))

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
        cls.settings = {key: row for key, row in rows(told("-settings")).items() if "." in key}

    def faults(self, scene):
        return [".".join(map(str, e.absolute_path)) for e in self.validator.iter_errors(scene)]

    def test_every_scene_holds_to_it(self):
        scenes = sorted(SCENES.glob("*.yaml"))
        self.assertGreater(len(scenes), 30)
        for scene in scenes:
            with self.subTest(scene.name):
                self.assertEqual(self.faults(yaml.load(scene.read_text(), Loader)), [])

    def test_defaults_are_what_a_scene_has_without_them(self):
        options = []
        for key, (_, default) in self.settings.items():
            if key not in ("time.frames", "solver.stabilisation"):  # those of the scene; of the velocity level alone
                options += ["-set", f"{key}={default}"]
        plain, told_all = self.good(self.scene(SMALL), "plain"), self.good(self.scene(SMALL), "told", *options)
        self.assertEqual(plain.state, told_all.state)

    def test_the_reference_page_says_the_same(self):
        page = rows((SOURCE / "docs" / "scene.md").read_text())
        for key, told_of in self.settings.items():
            with self.subTest(key):
                self.assertEqual(page.get(key, page.get(key.removeprefix("solver."))), told_of)


if __name__ == "__main__":
    unittest.main()
