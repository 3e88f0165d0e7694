#!/usr/bin/python3
"""The folders of the sources lie in layers: none includes a folder above it, so that no two include each other."""
import re
import unittest

from unibody_runs import SOURCE

# From the ground up. A folder may include those before it alone.
LAYERS = ["core", "world", "meshes", "collide", "constraints", "joints", "scene", "partition", "coarse", "solve", "step", "changes", "checkpoint", "report",
          "app", "tools", "library", "python"]


def folder_of(path):
    parts = path.relative_to(SOURCE).parts
    return "partition" if parts[0] == "partition" else parts[1]


def sources():
    return [p for root in ("src", "partition") for p in sorted((SOURCE / root).rglob("*.[hc]pp")) if p.parent.name != "src"]


class Layers(unittest.TestCase):
    def test_every_folder_has_its_layer(self):
        self.assertEqual({folder_of(p) for p in sources()}, set(LAYERS))

    def test_no_folder_includes_one_above_it(self):
        for path in sources():
            for name in re.findall(r'^#include "([^"/]+)/', path.read_text(), re.MULTILINE):
                self.assertLessEqual(LAYERS.index(name), LAYERS.index(folder_of(path)), f"{path} includes {name}/")


if __name__ == "__main__":
    unittest.main()
