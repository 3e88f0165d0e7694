#!/usr/bin/python3
"""How much of its grains' weight the base of a silo bears, for several fills, beside Janssen's law.

    scripts/python [-n RANKS] scripts/examples/silo_pressure.py [--quick] [--solver NAME] [--plot FILE]

The scene is scenes/janssen.yaml: once the silo is full its base sinks, so that friction at the walls is fully mobilised. The load
is the mean over 1 s of that. Janssen's law has one parameter, the weight W' that the base bears under a silo without end; it is
taken from all fills, by least squares. --quick: two small fills.
"""
import argparse
import os

import numpy as np

import unibody

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def loads(count, settings):
    """N: the weight of so many grains, and the part of it that the base bears while it sinks; and whether this process is the first."""
    scene = unibody.Scene.load(os.path.join(ROOT, "scenes", "janssen.yaml"), set={"bodies[2].lattice.count": count, **settings})
    with unibody.Simulation(scene) as simulation:
        simulation.step(int(round(2.5 / simulation.step_length)))
        measured = []
        while simulation.time < 3.5:
            simulation.step()
            measured.append(-simulation.probe("base")["force_z (N)"])
        return 9.81 * simulation.probe("grains")["mass (kg)"], float(np.mean(measured)), simulation.rank == 0


def janssen(weight, saturated):
    return saturated * (1 - np.exp(-weight / saturated))


def fitted(weights, borne):
    """W' (N) by least squares of the shares that the base bears."""
    trials = np.geomspace(0.2 * borne.max(), 20 * borne.max(), 4000)
    faults = [np.sum(((janssen(weights, trial) - borne) / weights) ** 2) for trial in trials]
    return trials[int(np.argmin(faults))]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--solver", default="accelerated_jacobi")
    parser.add_argument("--plot", metavar="FILE")
    options = parser.parse_args()
    settings = {"solver.name": options.solver}
    pairs = [(count, *loads(count, settings)) for count in ((250, 1000) if options.quick else (250, 500, 1000, 2000))]
    weights, borne = np.array([p[1] for p in pairs]), np.array([p[2] for p in pairs])
    saturated = fitted(weights, borne)
    law = janssen(weights, saturated)
    if not pairs[0][3]:
        return
    print(f"W' = {saturated:.1f} N")
    print("grains  weight (N)  base (N)  share  Janssen")
    for (count, weight, load, _), by_law in zip(pairs, law):
        print(f"{count:6d}  {weight:10.2f}  {load:8.2f}  {load / weight:5.3f}  {by_law / weight:7.3f}")
    if options.plot:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        figure, axes = pyplot.subplots(figsize=(5, 4))
        fill = np.linspace(0, 1.05 * weights.max(), 200)[1:]
        axes.plot(fill, fill, "k:", label="all of it")
        axes.plot(fill, janssen(fill, saturated), label=f"Janssen, W' = {saturated:.1f} N")
        axes.plot(weights, borne, "o", label="unibody")
        axes.set(xlabel="weight of the grains (N)", ylabel="load of the base (N)", ylim=(0, 1.6 * saturated))
        axes.legend()
        figure.tight_layout()
        figure.savefig(options.plot)


if __name__ == "__main__":
    main()
