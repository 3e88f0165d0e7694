#!/usr/bin/python3
"""Scenes made at random from everything that may be mixed have the same state on any number of ranks.

Which contacts stand beside each other in the solver's memory depends on the rank: only where contacts of all kinds meet is every
kind tried beside every other.
"""
import json
import random
import unittest

from unibody_runs import ProgramTest

SCENES = 24


def number(random_, low, high):
    return round(random_.uniform(low, high), 3)


def vector(random_, extent):
    return [number(random_, -extent, extent) for _ in range(3)]


def shape(random_):
    size = lambda: number(random_, 0.04, 0.1)
    edge = 2 * size()
    return random_.choice([
        {"sphere": {"radius": size()}},
        {"box": {"size": [2 * size(), 2 * size(), 2 * size()]}},
        {"box": {"size": [edge, edge, edge]}},
        {"capsule": {"radius": size(), "length": size()}},
        {"cylinder": {"radius": size(), "length": 2 * size()}},
        {"hull": {"points": [vector(random_, 0.1) for _ in range(10)]}},
        {"compound": {"parts": [{"shape": {"sphere": {"radius": 0.05}}, "position": [0, 0, 0.05]},
                                {"shape": {"box": {"size": [0.08, 0.08, 0.1]}}, "position": [0, 0.03, -0.04]}]}},
        {"particle": {"radius": 0.05}}])


def materials(random_):
    compliance = random_.choice([{}, {}, {}, {"stiffness": 1e5, "damping_ratio": 0.2}, {"elastic_modulus": 1e6, "damping_ratio": 0.1}])
    made = {}
    for name in "ab":
        made[name] = {"friction": random_.choice([0, 0.2, 0.6]), **compliance}
        if not compliance:
            made[name]["restitution"] = random_.choice([0, 0, 0.5, 1])
        for share, more in ((0.3, {"rolling_friction": 0.005}), (0.2, {"spinning_friction": 0.003}), (0.15, {"adhesion": 0.5}),
                            (0.15, {"stiction": made[name]["friction"] + 0.2, "stiction_speed": 0.05})):
            if random_.random() < share:
                made[name].update(more)
    return made


def ground(random_):
    return random_.choice([
        {"shape": {"plane": {"normal": [0, 0, 1]}}},
        {"shape": {"box": {"size": [4, 4, 0.2]}}, "motion": "fixed", "position": [0, 0, -0.1], "surface_velocity": [0, 0.7, 0]},
        {"shape": {"mesh": {"height_field": {"size": [4, 4], "cells": [20, 20], "hills": 0.1, "seed": 3}}}, "position": [0, 0, -0.2]},
        {"shape": {"mesh": {"tube": {"radius": 1.2, "length": 2, "sides": 24}}}, "motion": "kinematic", "position": [0, 0, 1.2],
         "orientation": {"axis": [1, 0, 0], "angle": 90}, "angular_velocity": [0, random_.choice([1, 3]), 0]}])


def bodies_and_joints(random_):
    bodies, joints = [], []
    for k in range(random_.choice([12, 30, 60])):
        place = [round(-0.6 + 0.3 * i + number(random_, -0.02, 0.02), 3) for i in (k % 5, k // 5 % 5)] + [round(0.5 + 0.3 * (k // 25), 3)]
        body = {"name": f"b{k}", "shape": shape(random_), "mass": number(random_, 0.5, 3), "position": place,
                "material": random_.choice("ab"), "velocity": vector(random_, 3)}
        if "particle" not in body["shape"]:
            body["angular_velocity"] = vector(random_, 5)
            if random_.random() < 0.1:
                body["anisotropic_friction"] = {"axis": [1, 0, 0], "across": 0.4}
        bodies.append(body)
        if k % 5 and random_.random() < 0.15:
            before = bodies[-2]
            turn = not any("particle" in b["shape"] for b in (before, body))
            joint = {"type": random_.choice(["ball", "hinge", "fixed"]) if turn else "ball", "bodies": [before["name"], body["name"]],
                     "anchor": [(x + y) / 2 for x, y in zip(place, before["position"])]}
            if joint["type"] == "hinge":
                joint["axis"] = [0, 1, 0]
            joints.append(joint)
    return bodies, joints


def scene_of(seed):
    random_ = random.Random(seed)
    bodies, joints = bodies_and_joints(random_)
    scene = {"time": {"frame": 0.016, "frames": 25, "substeps": random_.choice([1, 1, 2])}, "output": {"every": 0},
             "materials": materials(random_), "bodies": [{**ground(random_), "material": "a"}, *bodies],
             "solver": {"name": random_.choice(["accelerated_jacobi", "jacobi", "gauss_seidel"]), "iterations": random_.choice([10, 20])}}
    if joints and random_.random() < 0.6:
        scene["joints"] = joints
    if random_.random() < 0.2:
        scene["threads"] = [{"points": [[-0.7, 0.1, 1.3], [0.7, 0.1, 1.3]], "segments": 20, "radius": 0.01, "mass": 0.2, "material": "a"}]
    if random_.random() < 0.2:
        scene["solids"] = [{"block": {"size": [0.3, 0.3, 0.3], "cells": [2, 2, 2]}, "youngs_modulus": 1e5, "poissons_ratio": 0.3,
                            "density": 800, "thickness": 0.01, "position": [0, 0, 1.9], "material": "a"}]
    if random_.random() < 0.15:
        scene["solver"]["accuracy"] = random_.choice([0.01, 0.001])
    return scene


class RandomScenes(ProgramTest):
    def test_the_state_does_not_depend_on_the_ranks(self):
        touching = 0
        for seed in range(SCENES):
            with self.subTest(seed=seed):
                scene = self.scene(json.dumps(scene_of(seed)), f"{seed}.yaml")
                one = self.good(scene, "on_1", "-overwrite", ranks=1)
                summary = json.loads((self.folder / "on_1" / "summary.json").read_text())
                touching += summary["final"]["contacts"]
                for ranks, more in ((2, []), (3, ["-partition", "random:3"])):
                    self.assertEqual(self.good(scene, f"on_{ranks}", "-overwrite", *more, ranks=ranks).state, one.state, f"on {ranks} ranks")
        self.assertGreater(touching, 50 * SCENES)


if __name__ == "__main__":
    unittest.main()
