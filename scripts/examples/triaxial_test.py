#!/usr/bin/python3
"""The strength of a sample of grains between pressing plates, for several numbers of iterations.

    scripts/python [-n RANKS] scripts/examples/triaxial_test.py [--quick] [--solver NAME] [--iterations N ...] [--plot FILE]

The scene is scenes/triaxial.yaml: plates press grains to a sample, and two of them then close on it at a given speed, while the others
hold their pressure. Printed are means over the second half of the run: the pressure across, the ratio r of the pressure along z
to it, the angle of friction asin((r - 1) / (r + 1)), the deepest contact over the mean diameter, and the solid fraction at the end. The
plot shows the ratio over the strain along z. --quick: fewer grains, and a shorter run.
"""
import argparse
import os

import numpy as np

import unibody

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DIAMETER = 0.0098  # m, the mean
SHEARED = 1.51  # s, when shearing begins


def sheared(settings, seconds):
    """By frames: time (s), size along z (m), pressures across and along z (Pa), deepest contact (m), solid fraction (1)."""
    scene = unibody.Scene.load(os.path.join(ROOT, "scenes", "triaxial.yaml"), set=settings)
    rows = []
    with unibody.Simulation(scene) as simulation:
        while simulation.time < seconds - 1e-9:
            simulation.step(scene.substeps)
            sample = simulation.probe("sample")
            across = 0.5 * (sample["pressure_x (Pa)"] + sample["pressure_y (Pa)"])
            deepest = simulation.measures()["penetration_max"]
            rows.append([simulation.time, sample["size_z (m)"], across, sample["pressure_z (Pa)"], deepest, sample["solid_fraction (1)"]])
        return np.array(rows), simulation.rank == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--solver", default="accelerated_jacobi")
    parser.add_argument("--iterations", type=int, nargs="+", default=[50, 300])
    parser.add_argument("--plot", metavar="FILE")
    options = parser.parse_args()
    settings, seconds = {"solver.name": options.solver}, 5.0
    if options.quick:
        size = "bodies[0].triaxial.size"
        settings.update({"bodies[1].pile.count": 200, "bodies[1].pile.columns": [5, 5], size: [0.062, 0.062, 0.12]})
        seconds = 3.0
    runs = [(n, *sheared({"solver.iterations": n, **settings}, seconds)) for n in options.iterations]
    if not runs[0][2]:
        return
    print("iterations  across (Pa)  ratio  angle (degrees)  deepest / diameter  solid fraction")
    for iterations, rows, _ in runs:
        late = rows[rows[:, 0] > (SHEARED + seconds) / 2]
        across, ratio = late[:, 2].mean(), late[:, 3].mean() / late[:, 2].mean()
        angle = np.degrees(np.arcsin((ratio - 1) / (ratio + 1)))
        print(f"{iterations:10d}  {across:11.1f}  {ratio:5.3f}  {angle:15.1f}  {np.median(late[:, 4]) / DIAMETER:18.4f}  {rows[-1, 5]:14.3f}")
    if options.plot:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        figure, axes = pyplot.subplots(figsize=(5, 4))
        for iterations, rows, _ in runs:
            shear = rows[rows[:, 0] >= SHEARED]
            strain = 1 - shear[:, 1] / shear[0, 1]
            width = 10  # frames
            smooth = np.convolve(shear[:, 3] / shear[:, 2], np.ones(width) / width, "valid")
            axes.plot(100 * strain[width - 1:], smooth, label=f"{iterations} iterations")
        axes.set(xlabel="strain along z (%)", ylabel="ratio of pressures", ylim=(0.9, None))
        axes.legend()
        figure.tight_layout()
        figure.savefig(options.plot)


if __name__ == "__main__":
    main()
