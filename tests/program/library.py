#!/usr/bin/python3
"""The installed tree: a program of somebody else finds it, builds with the shared and the static library, and takes the program's steps."""
import os
import pathlib
import re
import subprocess
import unittest

from unibody_runs import SCENES, SOURCE, ProgramTest, command, execute

BUILD = pathlib.Path(os.environ["UNIBODY_PROGRAM"]).parent


class Library(ProgramTest):
    def checked(self, *words):
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def installed(self):
        self.checked("cmake", "--install", BUILD, "--prefix", self.folder / "tree")
        return self.folder / "tree"

    def test_the_program_on_the_page(self):
        page = (SOURCE / "docs/library.md").read_text(encoding="utf-8")
        source, build = self.folder / "source", self.folder / "build"
        source.mkdir()
        for kind, name in (("cmake", "CMakeLists.txt"), ("cpp", "drop.cpp")):
            (source / name).write_text(re.search(rf"```{kind}\n(.*?)```", page, re.DOTALL).group(1), encoding="utf-8")
        self.checked("cmake", "-S", source, "-B", build, f"-DCMAKE_PREFIX_PATH={self.installed()}")
        self.checked("cmake", "--build", build)
        done = execute([str(build / "drop") if word == os.environ["UNIBODY_PROGRAM"] else word for word in command([], 1)])
        self.assertEqual(done.code, 0, done.err)
        height, force = (float(word) for word in re.match(r"z = (\S+) m, force on the floor (\S+) N", done.out).groups())
        self.assertAlmostEqual(height, 0.1, delta=0.002)  # it fell by 1.9 m in 0.62 s, and does not bounce
        self.assertAlmostEqual(force, -9.81, delta=0.1)

    def test_a_program_of_somebody_else(self):
        tree, build = self.installed(), self.folder / "build"
        self.checked("cmake", "-S", SOURCE / "tests/library", "-B", build, f"-DCMAKE_PREFIX_PATH={tree}")
        self.checked("cmake", "--build", build, "--parallel", "2")
        scene = SCENES / "boxes_500.yaml"
        expected = self.good(scene, "program", "-set", "time.frames=12").state
        for kind in ("with_unibody", "with_unibody_static"):
            for ranks in (1, 2):
                with self.subTest(kind, ranks=ranks):
                    words = [build / kind if word == os.environ["UNIBODY_PROGRAM"] else word for word in command([], ranks)]
                    done = execute([str(word) for word in words], folder=self.folder)
                    self.assertEqual(done.code, 0, done.err)
                    done = execute([str(word) for word in [*words, scene, "12"]], folder=self.folder)
                    self.assertEqual(done.state, expected, done.err)
        # The program is in the tree as well.
        self.assertIn("unibody 0.", self.checked(tree / "bin/unibody", "-version"))
        # The shared library shows its own names alone.
        names = self.checked("nm", "-D", "--defined-only", "-C", next((tree / "lib").rglob("libunibody.so")))
        shown = [line.split(" ", 2)[2] for line in names.splitlines()]
        self.assertTrue(any("unibody::api::Simulation::step" in name for name in shown))
        self.assertEqual([name for name in shown if "unibody::" in name and "unibody::api::" not in name], [])


if __name__ == "__main__":
    unittest.main()
