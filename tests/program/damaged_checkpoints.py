#!/usr/bin/python3
"""Checkpoints in which something is not what it should be, their seals made anew so that they are read: every attribute and table, of
another type, shape or size, and every number of a body out of its range. Each is refused, on all ranks, before anything is written."""
import shutil
import struct
import unittest

import h5py
import numpy as np

from unibody_runs import ProgramTest, contents, tree, unibody

SCENE = """
    time: {frames: 6}
    output: {every: 0, checkpoint_every: 2}
    materials: {wood: {friction: 0.5, rolling_friction: 0.01}}
    bodies:
      - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}
      - {name: box, lattice: {count: 8, columns: [2, 2], spacing: [0.16, 0.16, 0.19], height: 0.08}, shape: {box: {size: [0.12, 0.12, 0.15]}}, mass: 1}
      - {name: arm, shape: {box: {size: [0.2, 0.1, 0.1]}}, mass: 1, position: [3, 0, 3]}
    joints: [{type: hinge, bodies: [arm, world], anchor: [3, 0, 3.2], axis: [0, 1, 0]}]
    cloths:
      - {grid: {size: [1, 1], nodes: [3, 3]}, mass: 1, thickness: 0.01, position: [5, 0, 5], pins: [{node: [0, 0]}]}
"""
MASK = (1 << 64) - 1
SEAL = 512


def mix(x):
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9 & MASK
    x = (x ^ x >> 27) * 0x94d049bb133111eb & MASK
    return x ^ x >> 31


def hash_of(words):
    """As core/hash.hpp."""
    state = 0x756e69626f6479
    for k, word in enumerate(words, 1):
        state = mix(state ^ mix((word + k * 0x9e3779b97f4a7c15) & MASK))
    return mix(state ^ len(words))


def seal(path):
    """Writes the first block anew, so that it fits what follows (report/checkpoint_seal.hpp)."""
    data = contents(path)[SEAL:]
    total = 0
    for number in range(0, len(data), 1 << 20):
        block = data[number:number + (1 << 20)]
        padded = block + bytes(-len(block) % 8)
        total += hash_of([number >> 20, len(block), *struct.unpack(f"<{len(padded) // 8}Q", padded)])
    text = f"unibody checkpoint 5\nbytes behind this block: {len(data)}\nhash of them: {total & MASK:016x}\n".encode()
    with open(path, "r+b") as file:
        file.write(text + bytes(SEAL - len(text)))


class DamagedCheckpoints(ProgramTest):
    def setUp(self):
        super().setUp()
        self.scene_file = self.scene(SCENE)
        self.good(self.scene_file, "half", "-set", "time.frames=4")
        self.whole = self.good(self.scene_file, "whole").state
        self.runs = 0

    def damaged(self, change):
        path = self.folder / "damaged.h5"
        shutil.copy(self.folder / "half/checkpoint.h5", path)
        with h5py.File(path, "r+") as file:
            change(file)
        seal(path)
        return path

    def restart(self, path):
        self.runs += 1
        return unibody(self.scene_file, "-restart", path, "-output", self.folder / f"results_{self.runs}", ranks=(1, 1, 2, 1, 1, 3)[self.runs % 6], timeout=60)

    def refused(self, name, change, says="damaged"):
        with self.subTest(what=name):
            path = self.damaged(change)
            before = tree(self.folder)
            run = self.restart(path)
            self.assertEqual(run.code, 2, run.err)
            self.assertEqual(len(run.message), 1, run.err)
            self.assertIn(str(path), run.message[0])
            self.assertIn(says, run.message[0])
            self.assertEqual(tree(self.folder), before, "something was written")

    def test_the_seal_is_made_as_the_program_makes_it(self):
        path = self.damaged(lambda file: None)
        shutil.copy(self.folder / "half/checkpoint.h5", path)
        seal(path)
        self.assertEqual(contents(path), contents(self.folder / "half/checkpoint.h5"))
        for ranks in (1, 2, 3):
            run = self.restart(path)
            self.assertEqual((run.code, run.state), (0, self.whole), run.err)

    def test_bits_that_change_without_the_seal(self):
        data = contents(self.folder / "half/checkpoint.h5")
        path = self.folder / "damaged.h5"
        for at in range(0, len(data), len(data) // 10):
            changed = bytearray(data)
            changed[at] ^= 1 << at % 8
            path.write_bytes(changed)
            run = self.restart(path)
            self.assertEqual((run.code, len(run.message)), (2, 1), run.err)
        for size in (0, 100, 511, 512, 513, len(data) - 1):
            path.write_bytes(data[:size])
            self.assertEqual(self.restart(path).code, 2)

    def test_attributes(self):
        values = {"of 100 numbers": np.arange(100), "a text": "x" * 1000, "a long text": np.bytes_(b"y" * 70000), "none": None,
                  "a real": 1.5, "a list": np.array([4]), "too large": np.int64(2**62), "negative": np.int64(-3)}
        for k, name in enumerate(("format", "fingerprint", "frame", "time", "bodies")):
            for j, (what, value) in enumerate(values.items()):
                if (j + k) % 2 and what != "of 100 numbers":
                    continue  # half of them: a run takes a third of a second
                if name == "time" and what in ("a real",):
                    continue

                def change(file, name=name, value=value):
                    del file.attrs[name]
                    if value is not None:
                        file.attrs[name] = value
                if name in ("format", "fingerprint") and what == "a text":
                    continue  # of variable length: refused as another kind of text, below
                if name == "frame" and what == "too large":
                    self.refused(f"{name}: {what}", change, "frame")  # of a frame behind the run's end
                else:
                    self.refused(f"{name}: {what}", change)

    def test_tables(self):
        def replace(name, make):
            def change(file):
                data = file[name][()]
                del file[name]
                make(file, name, data)
            return change
        shapes = {
            "a number": lambda file, name, data: file.create_dataset(name, data=1.0),
            "a list": lambda file, name, data: file.create_dataset(name, data=data[:, 0]),
            "another column": lambda file, name, data: file.create_dataset(name, data=np.hstack([data, data[:, :1]])),
            "a row less": lambda file, name, data: file.create_dataset(name, data=data[:-1]),
            "a row more": lambda file, name, data: file.create_dataset(name, data=np.vstack([data, data[:1]])),
            "no row": lambda file, name, data: file.create_dataset(name, data=data[:0]),
            "single precision": lambda file, name, data: file.create_dataset(name, data=data.astype("f4")),
            "texts": lambda file, name, data: file.create_dataset(name, data=np.full(data.shape, b"x")),
            "in chunks": lambda file, name, data: file.create_dataset(name, data=data, chunks=True, compression="gzip"),
            "not written": lambda file, name, data: file.create_dataset(name, shape=(10**12, data.shape[1]), dtype=data.dtype),
            "a group": lambda file, name, data: file.create_group(name),
            "nowhere": lambda file, name, data: None,
        }
        for k, name in enumerate(("bodies", "multipliers/key", "multipliers/point", "constraints/distance/ids",
                                  "constraints/distance/multipliers", "constraints/rolling_friction/ids",
                                  "constraints/rolling_friction/multipliers", "joints")):
            for j, (what, make) in enumerate(shapes.items()):
                if k > 0 and (j + k) % 3:
                    continue  # a third of them, but for bodies: all tables are opened by the same function
                if what in ("a row less", "a row more", "no row") and name in ("joints",) and what == "a row more":
                    continue  # a joint that the scene has not is not read
                self.refused(f"{name}: {what}", replace(name, make))

    def test_numbers_of_bodies(self):
        columns = {"position": 0, "quaternion": 3, "velocity": 7, "spin": 10, "size": 13, "inertia": 16, "force": 19, "torque": 22, "mass": 25,
                   "shape": 26, "motion": 27, "material": 28, "group": 29}
        bad = {"position": (np.nan, np.inf), "quaternion": (2.0, np.nan), "velocity": (-np.inf,), "spin": (np.nan,), "size": (-0.1, 0.2, np.inf),
               "inertia": (-1.0, np.nan, 1.0), "force": (1.0, np.nan), "torque": (1.0, np.inf), "mass": (0.0, -1.0, np.nan, 2.0),
               "shape": (0.0, 9.0, 77.0, 1 + 256.0, 7 + 256.0 * 5, -1.0, 0.5, 1e300), "motion": (1.0, 3.0, 4.0, -1.0, 0.5, 1e9),
               "material": (1.0, -1.0, 0.5, 1e12), "group": (0.0, -2.0, 0.5, 1e12)}
        for field, values in bad.items():
            for value in values:
                def change(file, field=field, value=value):
                    file["bodies"][3, columns[field]] = value
                self.refused(f"{field}: {value}", change)

    def test_numbers_of_multipliers(self):
        keys = ((0, 10**6), (0, -1), (1, -1), (1, 3), (2, 10**9), (2, 0), (3, 7), (3, -1), (4, 2), (4, -1))
        for column, value in keys:
            def change(file, column=column, value=value):
                file["multipliers/key"][1, column] = value
            self.refused(f"key {column}: {value}", change)
        for column, value in ((0, 10**6), (0, -1), (1, -1), (1, 10**9), (2, 10**9), (2, 0), (2, -1)):
            def change(file, column=column, value=value):
                file["constraints/rolling_friction/ids"][0, column] = value
            self.refused(f"id {column} of rolling friction: {value}", change)
        for table, value in (("multipliers/point", np.nan), ("multipliers/point", np.inf), ("constraints/distance/multipliers", np.nan),
                             ("constraints/rolling_friction/multipliers", np.nan), ("joints", -np.inf)):
            def change(file, table=table, value=value):
                file[table][0, 0] = value
            self.refused(f"{table}: {value}", change)

    def test_older_checkpoints_and_other_files(self):
        path = self.folder / "old.h5"
        with h5py.File(path, "w") as file:
            file.attrs["format"] = "unibody checkpoint 2"
        run = self.restart(path)
        self.assertEqual((run.code, len(run.message)), (2, 1), run.err)
        self.assertIn("it does not begin with 'unibody checkpoint 5'", run.message[0])


if __name__ == "__main__":
    unittest.main(verbosity=2)
