#!/usr/bin/python3
"""A gripper that closes until it holds, and then lifts: the controller is this script.

    scripts/python scripts/examples/gripper.py

Two jaws slide on a carriage, each moved by a motor of 60 N. The controller knows nothing of the crate between them: it closes at
0.1 m/s until both motors have to give most of their force, then lifts the carriage by 0.3 m and holds still for a second. Friction
holds the crate of 3 kg: 2 x 0.8 x 60 N are three times its weight. The script ends with exit code 1 where the crate was not lifted.
"""
import sys

import unibody

STEP = 0.005  # s
FORCE = 60  # N


def jaw(name, x):
    return {"name": name, "shape": {"box": {"size": [0.04, 0.2, 0.16]}}, "density": 500, "material": "rubber",
            "position": [x, 0, 0.1]}


def slider(name, x, axis):
    return {"type": "slider", "bodies": [name, "carriage"], "anchor": [x, 0, 0.1], "axis": axis,
            "motor": {"speed": 0, "max_force": FORCE}}


SCENE = unibody.Scene({
    "title": "a gripper with a controller",
    "time": {"frame": STEP, "frames": 1000},
    "solver": {"iterations": 100},
    "materials": {"rubber": {"friction": 0.8}},
    "bodies": [
        {"name": "ground", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": "rubber"},
        {"name": "carriage", "shape": {"box": {"size": [0.6, 0.1, 0.04]}}, "motion": "kinematic", "position": [0, 0, 0.4]},
        jaw("left", -0.25), jaw("right", 0.25),
        {"name": "crate", "shape": {"box": {"size": [0.2, 0.2, 0.2]}}, "mass": 3, "position": [0.01, 0, 0.1],
         "material": "rubber"},
    ],
    "joints": [slider("left", -0.25, [1, 0, 0]), slider("right", 0.25, [-1, 0, 0])]})

CARRIAGE, CRATE = (int(SCENE.ids(name)[0]) for name in ("carriage", "crate"))


def main():
    with unibody.Simulation(SCENE) as simulation:
        for joint in range(2):
            simulation.set_motor(joint, 0.1)  # along the slider's axis, which points inwards
        simulation.step()
        while min(simulation.joints()["motor"]) < 0.8 * FORCE:
            simulation.step()
            if simulation.time > 4:
                sys.exit("the jaws met nothing")
        print(f"{simulation.time:.3f} s: the jaws hold, at {simulation.positions[[2, 3], 0].round(4)} m")
        simulation.set_velocity(CARRIAGE, [0, 0, 0.3])
        simulation.step(round(1 / STEP))
        simulation.set_velocity(CARRIAGE, [0, 0, 0])
        simulation.step(round(1 / STEP))
        height = simulation.positions[CRATE, 2] - 0.1
        print(f"{simulation.time:.3f} s: the crate hangs {height:.4f} m above where it stood")
    if abs(height - 0.3) > 0.01:
        sys.exit(1)


if __name__ == "__main__":
    main()
