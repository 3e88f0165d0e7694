#!/usr/bin/python3
"""How far columns of grains reach when they collapse in a channel, beside the law that experiments have found.

    scripts/python [-n RANKS] scripts/examples/column_collapse.py [--quick] [--solver NAME] [--iterations N] [--plot FILE]

The scene is scenes/column_collapse.yaml. A column of width d and height h = a d collapses from a wall and comes to reach to d + r. Of
sand, rice, salt and others Lube, Huppert, Sparks and Freundt (Physical Review E 72, 041301, 2005) found r / d = 1.2 a for a < 1.8 and
1.9 a^(2/3) for a > 2.8, whatever the grains. The height is that of the column at rest behind the gate, the reach that of 99 of 100
grains. --quick: one column, for 1.4 s.
"""
import argparse
import os

import numpy as np

import unibody

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
WIDTH, RADIUS = 0.12, 0.005  # m
GRAINS_OF_A_SQUARE = 990  # in a column as high as wide


def collapse(aspect, seconds, settings):
    """a, r / d, the height left at the wall over d and the mean speed (m/s) in the end; whether this process is the first."""
    count = int(round(GRAINS_OF_A_SQUARE * aspect))
    substeps = 4 if aspect < 1.2 else 8  # the higher they start, the faster they fall
    scene = unibody.Scene.load(os.path.join(ROOT, "scenes", "column_collapse.yaml"),
                               set={"bodies[4].pile.count": count, "time.substeps": substeps, **settings})
    with unibody.Simulation(scene) as simulation:
        while simulation.time < 0.6 - 1e-9:
            simulation.step()
        height = np.quantile(simulation.positions[-count:, 2], 0.99) + RADIUS
        while simulation.time < seconds - 1e-9:
            simulation.step()
        places = simulation.positions[-count:]
        speed = np.linalg.norm(simulation.velocities[-count:], axis=1).mean()
        left = places[places[:, 0] < 0.1 * WIDTH, 2].max() + RADIUS
        reach = np.quantile(places[:, 0], 0.99) + RADIUS - WIDTH
        return height / WIDTH, reach / WIDTH, left / WIDTH, speed, simulation.rank == 0


def law(aspect):
    return np.where(aspect < 1.8, 1.2 * aspect, np.where(aspect > 2.8, 1.9 * aspect ** (2 / 3), np.nan))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--solver", default="accelerated_jacobi")
    parser.add_argument("--iterations", type=int, default=50)
    parser.add_argument("--plot", metavar="FILE")
    options = parser.parse_args()
    settings = {"solver.name": options.solver, "solver.iterations": options.iterations}
    aspects, seconds = ((1,), 1.4) if options.quick else ((0.5, 1, 1.5, 3, 5), 2.4)
    columns = [collapse(aspect, seconds, settings) for aspect in aspects]
    if not columns[0][4]:
        return
    print("a  r/d  by the law  height left/d  mean speed (m/s)")
    for a, reach, left, speed, _ in columns:
        print(f"{a:.2f}  {reach:.2f}  {law(np.array(a)):.2f}  {left:.2f}  {speed:.4f}")
    if options.plot:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        figure, axes = pyplot.subplots(figsize=(5, 4))
        for part in (np.linspace(0.4, 1.8, 50), np.linspace(2.8, 7, 50)):
            axes.loglog(part, np.where(part <= 1.8, 1.2 * part, 1.9 * part ** (2 / 3)), "k", lw=1,
                        label="Lube and others" if part[0] < 1 else None)
        axes.loglog([c[0] for c in columns], [c[1] for c in columns], "o", label="unibody")
        axes.set(xlabel="height over width of the column", ylabel="reach over width")
        axes.legend()
        figure.tight_layout()
        figure.savefig(options.plot)


if __name__ == "__main__":
    main()
