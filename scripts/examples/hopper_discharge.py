#!/usr/bin/python3
"""The rate at which grains leave a hopper, while it runs.

    scripts/python -n 2 scripts/examples/hopper_discharge.py

The scene is scenes/silo_gate.yaml: its gate opens at 2 s and shuts at 4 s. Every tenth of a second the script prints how many grains
have passed the outlet, and their mass per second. It runs on any number of processes, and prints the same numbers on each number.
An argument is the time (s) at which it ends (default 4.5).
"""
import pathlib
import sys

import unibody

SCENE = pathlib.Path(__file__).resolve().parents[2] / "scenes" / "silo_gate.yaml"


def main():
    end = float(sys.argv[1]) if len(sys.argv) > 1 else 4.5
    scene = unibody.Scene.load(str(SCENE))
    with unibody.Simulation(scene) as simulation:
        is_first = simulation.rank == 0
        steps = round(0.1 / simulation.step_length)
        if is_first:
            print("time (s)  grains  rate (kg/s)")
        before = 0.0
        while simulation.time < end - 1e-9:
            simulation.step(steps)
            outlet = simulation.probe("outlet")
            if is_first:
                print(f"{simulation.time:8.2f}  {outlet['count (1)']:6.0f}  {(outlet['mass (kg)'] - before) / 0.1:11.3f}", flush=True)
            before = outlet["mass (kg)"]


if __name__ == "__main__":
    main()
