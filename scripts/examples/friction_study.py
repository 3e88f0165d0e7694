#!/usr/bin/python3
"""How far a column of grains runs out, over the friction between them: 20 runs in one process.

    scripts/python scripts/examples/friction_study.py [--quick] [PLOT]

600 spheres stand in a column on a floor until its walls are gone, at the start of the run. Printed is, for each coefficient of
friction, the distance from the axis within which nine tenths of the mass lie when all has come to rest. The plot is run_out.png,
or the file that the argument names. --quick: five runs.
"""
import argparse

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

import unibody  # noqa: E402

RADIUS = 0.02  # m


def column(friction):
    return unibody.Scene({
        "title": "a column of grains collapses",
        "time": {"frame": 0.01, "frames": 150, "substeps": 2},
        "materials": {"grain": {"friction": friction, "rolling_friction": 0.1 * RADIUS}},
        "bodies": [
            {"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": "grain"},
            {"name": "grain", "shape": {"sphere": {"radius": RADIUS}}, "density": 2500, "material": "grain",
             "lattice": {"count": 600, "columns": [6, 6], "spacing": [0.041, 0.041, 0.041], "height": 0.021, "jitter": 0.0004}},
        ]})


def run_out(scene):
    with unibody.Simulation(scene) as simulation:
        simulation.step(scene.frames * scene.substeps)
        places = simulation.positions[scene.ids("grain")]
    from_axis = np.sort(np.hypot(places[:, 0], places[:, 1]))
    return from_axis[int(0.9 * len(from_axis))]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plot", metavar="PLOT", nargs="?", default="run_out.png")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    frictions = np.linspace(0, 0.95, 5 if options.quick else 20)
    distances = []
    print("friction  run-out (m)")
    for friction in frictions:
        distances.append(run_out(column(friction)))
        print(f"{friction:8.2f}  {distances[-1]:.4f}", flush=True)
    figure, axes = pyplot.subplots()
    axes.plot(frictions, distances, "o-")
    axes.set(xlabel="coefficient of friction", ylabel="distance that holds nine tenths of the mass (m)")
    figure.savefig(options.plot, dpi=120)


if __name__ == "__main__":
    main()
