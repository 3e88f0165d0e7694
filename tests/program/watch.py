#!/usr/bin/python3
"""The page of scripts/watch tells what a run has written, also while it computes; a browser draws it."""
import csv
import json
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import unittest
import urllib.error
import urllib.request
import zlib

import h5py
import numpy as np

from unibody_runs import SOURCE, ProgramTest

WATCH = SOURCE / "scripts" / "watch"
SCENE = """
    time: {frame: 0.01, frames: 30}
    output: {every: 10}
    bodies:
      - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}
      - {name: step, shape: {box: {size: [1, 1, 0.2]}}, motion: fixed}
      - {name: ball, shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 3], velocity: [0, 0, -2]}
"""


class Watched:
    def __init__(self, folder):
        self.process = subprocess.Popen([sys.executable, WATCH, folder, "--port", "0"], stdout=subprocess.PIPE, text=True)
        self.address = re.search(r"http://127\.0\.0\.1:\d+/", self.process.stdout.readline()).group(0)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        self.code = self.process.wait(timeout=20)
        self.process.stdout.close()

    def get(self, path=""):
        with urllib.request.urlopen(self.address + path, timeout=20) as answer:
            return answer.read()

    def state(self):
        return json.loads(self.get("state.json"))


def pixels_of(path):
    """A PNG file's points, (height, width, channels), 8 bits a channel, each line filtered as the format says."""
    data, place, image = path.read_bytes(), 8, b""
    while place < len(data):
        length, kind = struct.unpack(">I4s", data[place:place + 8])
        body = data[place + 8:place + 8 + length]
        if kind == b"IHDR":
            width, height, _, colour = struct.unpack(">IIBB", body[:10])
        image += body if kind == b"IDAT" else b""
        place += 12 + length
    channels = {2: 3, 6: 4}[colour]
    lines = np.frombuffer(zlib.decompress(image), np.uint8).reshape(height, 1 + width * channels)
    out = np.zeros((height, width, channels), np.int64)
    for y, line in enumerate(lines):
        row = line[1:].reshape(width, channels).astype(np.int64)
        above = out[y - 1] if y else np.zeros_like(row)
        if line[0] in (0, 2):
            out[y] = (row + (above if line[0] == 2 else 0)) % 256
            continue
        left, corner = np.zeros(channels, np.int64), np.zeros(channels, np.int64)
        for x in range(width):
            up = above[x]
            guess = left + up - corner
            near = [abs(guess - left), abs(guess - up), abs(guess - corner)]
            paeth = np.where((near[0] <= near[1]) & (near[0] <= near[2]), left, np.where(near[1] <= near[2], up, corner))
            out[y, x] = (row[x] + {1: left, 3: (left + up) // 2, 4: paeth}[line[0]]) % 256
            left, corner = out[y, x], up
    return out


class Watch(ProgramTest):
    def test_it_tells_what_was_written(self):
        self.good(self.scene(SCENE), "out")
        with Watched(self.folder / "out") as watched:
            page, state = watched.get().decode(), watched.state()
            self.assertRaises(urllib.error.HTTPError, watched.get, "frames.h5")
        self.assertEqual(watched.code, 0)
        self.assertNotRegex(page, r"(src|href)=\"(?!data:)|https?://")  # nothing from elsewhere
        with h5py.File(self.folder / "out/frames.h5") as file:
            place = file["frames/000030/position"][2]
            speed = np.linalg.norm(file["frames/000030/velocity"][2])
        frame = state["frame"]
        self.assertEqual((frame["frame"], frame["bodies"], len(frame["places"])), (30, 3, 2))  # the plane is not drawn
        np.testing.assert_allclose(frame["places"][1], place, atol=1e-6)
        np.testing.assert_allclose(frame["speeds"], [0, speed], atol=1e-6)
        self.assertEqual(frame["fixed"], [True, False])
        self.assertAlmostEqual(frame["radii"][1], 0.1)
        with open(self.folder / "out/report.csv", encoding="utf-8") as file:
            columns, *rows = csv.reader(line for line in file if not line.startswith("#"))
        self.assertEqual(state["report"]["columns"], columns)
        self.assertEqual(state["report"]["rows"], [[float(word) for word in row] for row in rows])

    def test_it_follows_a_run_and_bears_what_is_half_written(self):
        self.good(self.scene(SCENE), "done")
        folder = self.folder / "growing"
        folder.mkdir()
        with Watched(folder) as watched:
            self.assertEqual((watched.state()["frame"], watched.state()["report"]), (None, None))
            whole = (self.folder / "done/report.csv").read_text(encoding="utf-8")
            (folder / "report.csv").write_text(whole[:-40], encoding="utf-8")  # the last row is half written
            (folder / "frames.h5").write_bytes(b"not yet a file of HDF5")
            state = watched.state()
            self.assertEqual((state["frame"], state["report"]["rows"][-1][0]), (None, 29))
            shutil.copy(self.folder / "done/frames.h5", folder / "frames.h5")
            (folder / "report.csv").write_text(whole, encoding="utf-8")
            state = watched.state()
            self.assertEqual((state["frame"]["frame"], state["report"]["rows"][-1][0]), (30, 30))

    def test_a_browser_draws_it(self):
        browser = shutil.which("chromium")
        if not browser:
            self.skipTest("there is no chromium")
        self.good(self.scene(SCENE), "out")
        picture = self.folder / "page.png"
        with Watched(self.folder / "out") as watched:
            subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--window-size=600,300", "--virtual-time-budget=4000",
                            f"--user-data-dir={self.folder / 'browser'}", f"--screenshot={picture}", watched.address],
                           check=True, capture_output=True, timeout=120, env=dict(os.environ, HOME=str(self.folder)))
        pixels = pixels_of(picture)
        left, right = pixels[:, :360], pixels[:, 360:]
        red = (left[..., 0] > 150) & (left[..., 1] < 110) & (left[..., 2] < 110)
        blue = right[..., 2] > right[..., 0] + 40
        self.assertGreater(red.sum(), 50)  # the ball is the fastest body
        self.assertGreater(blue.sum(), 100)  # the curves

    def test_what_cannot_be_shown_is_refused(self):
        for words, told in (([self.folder / "nothing"], "found no folder"), ([self.folder, "--port", "99999"], "found port 99999")):
            ended = subprocess.run([sys.executable, WATCH, *words], capture_output=True, text=True, check=False, timeout=60)
            self.assertEqual(ended.returncode, 1)
            self.assertIn(told, ended.stderr)


if __name__ == "__main__":
    unittest.main()
