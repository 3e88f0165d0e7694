#!/usr/bin/python3
"""scripts/usd: the file is of USD's grammar and its schemas' types, and holds the bodies and nodes where frames.h5 has them."""
import ast
import re
import subprocess
import unittest

import h5py
import numpy as np

from geometry import FLIGHT, PILE
from unibody_runs import SOURCE, ProgramTest

# Of the schemas of OpenUSD's UsdGeom: the types of the attributes that a prim of each type may have here.
SCHEMAS = {
    "Xform": {}, "Scope": {},
    "PointInstancer": {"prototypes": "rel", "protoIndices": "int[]", "ids": "int64[]", "positions": "point3f[]", "orientations": "quath[]",
                       "orientationsf": "quatf[]", "scales": "float3[]", "velocities": "vector3f[]", "angularVelocities": "vector3f[]",
                       "invisibleIds": "int64[]", "primvars:body": "int[]", "primvars:material": "int[]", "primvars:displayColor": "color3f[]"},
    "Sphere": {"radius": "double"}, "Cube": {"size": "double"}, "Cylinder": {"radius": "double", "height": "double", "axis": "token"},
    "Capsule": {"radius": "double", "height": "double", "axis": "token"},
    "Mesh": {"faceVertexCounts": "int[]", "faceVertexIndices": "int[]", "points": "point3f[]", "subdivisionScheme": "token", "doubleSided": "bool"},
    "BasisCurves": {"curveVertexCounts": "int[]", "type": "token", "points": "point3f[]"}}
STATEMENT = re.compile(r'(?:uniform )?([\w\[\]]+) ([\w:]+)(\.timeSamples)? = (.*?)(?: \(interpolation = "varying"\))?')


class Prim:
    def __init__(self, kind):
        self.kind, self.values, self.children = kind, {}, {}

    def array(self, name, code=None):
        value = self.values[name]
        return np.array(value if code is None else value[code], dtype=float)


def value_of(text):
    if text.startswith("[<"):
        return re.findall(r"<([^>]+)>", text)
    return ast.literal_eval(text.replace("true", "True").replace("nan", "None"))


def parse(path):
    """The metadata of the layer and its root prim; fails where a line is none of the grammar's."""
    head, rest = path.read_text(encoding="ascii").split(")\n\n", 1)
    magic, opening, *metadata = head.splitlines()
    assert (magic, opening) == ("#usda 1.0", "("), head
    layer = {name: ast.literal_eval(value) for name, value in (line.strip().split(" = ") for line in metadata)}
    root, stack, lines = Prim("root"), [], iter(rest.splitlines())
    stack.append(root)
    for line in lines:
        line = line.strip()
        start = re.fullmatch(r'def (\w+) "([A-Za-z_]\w*)"', line)
        if start:
            assert next(lines).strip() == "{"
            prim = Prim(start[1])
            assert start[2] not in stack[-1].children, line
            stack[-1].children[start[2]] = prim
            stack.append(prim)
        elif line == "}":
            stack.pop()
        else:
            kind, name, sampled, text = STATEMENT.fullmatch(line).groups()
            prim = stack[-1]
            assert SCHEMAS[prim.kind][name] == kind and name not in prim.values, line[:80]
            prim.values[name] = value_of(text)
            assert isinstance(prim.values[name], dict) == bool(sampled), line[:80]
    assert stack == [root]
    return layer, root.children["World"]


def turned(q, v):
    return v + 2 * np.cross(q[1:], np.cross(q[1:], v) + q[0] * v)


class Usd(ProgramTest):
    def usd(self, name, *options, code=0):
        done = subprocess.run([str(SOURCE / "scripts/usd"), str(self.folder / name), *options], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stderr if code else parse(self.folder / name / "scene.usda")

    def flight(self):
        self.good(self.scene(FLIGHT), "run")
        layer, world = self.usd("run")
        return layer, world, h5py.File(self.folder / "run/frames.h5", "r")

    def test_the_layer(self):
        layer, world, _ = self.flight()
        self.assertEqual(layer, {"defaultPrim": "World", "metersPerUnit": 1, "upAxis": "Z", "startTimeCode": 0, "endTimeCode": 1.44,
                                 "timeCodesPerSecond": 24, "framesPerSecond": 24})
        self.assertEqual(sorted(world.children["bodies"].values["positions"]), [0, 0.72, 1.44])  # 0.03 s are 0.72 frames of 1/24 s
        layer, world = self.usd("run", "--fps", "100", "--every", "2")
        self.assertEqual(sorted(world.children["bodies"].values["positions"]), [0, 6])
        self.assertEqual(layer["endTimeCode"], 6)

    def test_instances_are_where_the_bodies_are(self):
        _, world, file = self.flight()
        bodies = world.children["bodies"]
        frame = file["frames/000006"]
        x, q, v, w = (frame[name][:] for name in ("position", "orientation", "velocity", "angular_velocity"))
        self.assertEqual(bodies.values["primvars:body"], [0, 1, 2, 3, 4, 5, 5])  # of the compound both parts
        self.assertEqual(bodies.values["primvars:material"], [1, 0, 0, 0, 0, 0, 0])
        places, turns = bodies.array("positions", 1.44), bodies.array("orientationsf", 1.44)
        self.assertTrue(np.allclose(places[:5], x[:5], atol=1e-7))
        self.assertTrue(np.allclose(turns[:5], q[:5], atol=1e-7))
        self.assertTrue(np.array_equal(turns, bodies.array("orientations", 1.44)))
        self.assertTrue(np.allclose(np.linalg.norm(bodies.array("velocities", 1.44)[:5] - v[:5], axis=1), 0, atol=1e-6))
        self.assertTrue(np.allclose(bodies.array("angularVelocities", 1.44)[:5], np.degrees(w[:5]), atol=1e-4))
        # The parts of the compound, 1 m apart, turn about its centre.
        ball, block = places[6], places[5]
        self.assertAlmostEqual(np.linalg.norm(block - ball), 1, delta=1e-6)
        self.assertTrue(np.allclose(block - ball, turned(turns[5], np.array([1.0, 0, 0])), atol=1e-6))
        speeds = bodies.array("velocities", 1.44)
        self.assertTrue(np.allclose(speeds[5] - speeds[6], np.cross(w[5], block - ball), atol=1e-5))

    def test_forms(self):
        _, world, _ = self.flight()
        bodies = world.children["bodies"]
        forms = [world.children["bodies"].children["Prototypes"].children[path.split("/")[-1]] for path in bodies.values["prototypes"]]
        kinds = [forms[k].kind for k in bodies.values["protoIndices"]]
        self.assertEqual(kinds, ["Cube", "Sphere", "Cylinder", "Capsule", "Mesh", "Cube", "Sphere"])
        scales = bodies.array("scales")
        self.assertTrue(np.allclose(scales, [[0.2, 0.3, 0.5], [0.3] * 3, [0.2, 0.2, 0.4], [1] * 3, [1] * 3, [0.2, 0.1, 0.1], [0.2] * 3]))
        rod, capsule, hull = (forms[bodies.values["protoIndices"][k]] for k in (2, 3, 4))
        self.assertEqual(rod.values, {"radius": 1, "height": 2, "axis": "Z"})
        self.assertEqual(capsule.values, {"radius": 0.2, "height": 0.8, "axis": "Z"})
        corners = hull.array("points")[hull.array("faceVertexIndices").astype(int)].reshape(-1, 3, 3)
        a, b, c = np.moveaxis(corners, 1, 0)
        self.assertAlmostEqual(np.einsum("ij,ij", a, np.cross(b, c)) / 6, 0.6 * 0.9 * 1.2 / 6, delta=1e-7)

    def test_cloths_and_threads(self):
        _, world, file = self.flight()
        cloth, thread = (prim for name, prim in sorted(world.children.items()) if name.startswith("surface_"))
        x = file["frames/000006/position"][:]
        cells, segments = (file[f"surfaces/00000{k}/cells"][:] for k in (0, 1))
        points = cloth.array("points", 1.44)
        self.assertTrue(np.allclose(points[cloth.array("faceVertexIndices").astype(int)], x[cells.ravel()], atol=1e-7))
        self.assertEqual(cloth.values["faceVertexCounts"], [3] * len(cells))
        self.assertEqual(thread.values["curveVertexCounts"], [2] * 5)
        self.assertTrue(np.allclose(thread.array("points", 1.44), x[segments].reshape(-1, 3), atol=1e-7))

    def test_bodies_that_leave(self):
        self.good(self.scene(PILE), "pile")
        _, world = self.usd("pile", "--fps", "100")
        bodies = world.children["bodies"]
        self.assertEqual(bodies.values["primvars:body"], [1, 2, 3])  # not the plane
        self.assertEqual({code: ids for code, ids in bodies.values["invisibleIds"].items()}, {0: [], 50: [], 100: [2]})
        self.assertTrue(np.isfinite(bodies.array("positions", 100)).all())

    def test_refusals(self):
        self.assertIn("cannot read frames", self.usd("nothing", code=1))
        self.good(self.scene(FLIGHT), "run")
        self.assertIn("--every 0", self.usd("run", "--every", "0", code=1))
        self.assertIn("--fps -1", self.usd("run", "--fps", "-1", code=1))
        self.assertFalse((self.folder / "run/scene.usda").exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
