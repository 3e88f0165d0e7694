#!/usr/bin/python3
"""How fast grains run out of a silo through orifices of several sizes, beside Beverloo's law.

    scripts/python [-n RANKS] scripts/examples/orifice_flow.py [--quick] [--solver NAME] [--plot FILE]

The scene is scenes/beverloo.yaml: an inlet fills the silo, an event removes the plate under its orifice. The rate W (kg/s) is that
from half a second after it on. Beverloo's law (Chemical Engineering Science 15, 1961) is W = C rho sqrt(g) (D - k d)^2.5, where rho is
the density of the grains in the silo before it is opened, times their solid fraction; k is about 1.4, and C 0.55 to 0.65. Of the
runs come the exponent n of (D - 1.4 d)^n by least squares, and C and k by a line through W^0.4 over D. --quick: two orifices,
fewer grains, coarser steps and a shorter flow.
"""
import argparse
import os

import numpy as np

import unibody

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DIAMETER, DENSITY, GRAVITY = 0.004, 2500, 9.81
ENOUGH = 0.3  # kg, less than a half of the grains: the rate is looked at while the orifice is well covered
K = 1.4


def flow(orifice, settings, opened, end):
    """kg/s, and the density of the grains in the silo (kg/m^3); and whether this process is the first."""
    profile = [[orifice / 2, 0], [0.05, 0], [0.05, 0.25]]
    scene = unibody.Scene.load(os.path.join(ROOT, "scenes", "beverloo.yaml"),
                               set={"bodies[0].shape.mesh.revolve.profile": profile, "events[0].when.time": opened, **settings})
    passed = []
    with unibody.Simulation(scene) as simulation:
        density = 0
        while simulation.time < end - 1e-9 and not (passed and passed[-1][1] > ENOUGH):
            simulation.step()
            if simulation.time < opened:
                density = DENSITY * simulation.probe("packed")["solid_fraction (1)"]
            if simulation.time >= opened + 0.5 - 1e-9:
                passed.append((simulation.time, simulation.probe("orifice")["mass (kg)"]))
        times, masses = np.array(passed).T
        return float(np.polyfit(times, masses, 1)[0]), density, simulation.rank == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--solver", default="accelerated_jacobi")
    parser.add_argument("--plot", metavar="FILE")
    options = parser.parse_args()
    orifices = np.array([0.018, 0.024] if options.quick else [0.02, 0.024, 0.028, 0.032])
    settings, opened, end = {"solver.name": options.solver}, 1.5, 3.5
    if options.quick:
        settings = {"time.substeps": 2, "solver.iterations": 20, "bodies[2].inlet.count": 5000, **settings}
        opened, end = 0.9, 1.9
    flows = [flow(orifice, settings, opened, end) for orifice in orifices]
    rates, densities = np.array([f[0] for f in flows]), np.array([f[1] for f in flows])
    if not flows[0][2]:
        return
    exponent = np.polyfit(np.log(orifices - K * DIAMETER), np.log(rates), 1)[0]
    slope, offset = np.polyfit(orifices, rates ** 0.4, 1)
    density = densities.mean()
    factor, k = slope ** 2.5 / (density * np.sqrt(GRAVITY)), -offset / slope / DIAMETER
    own = np.mean(rates / (density * np.sqrt(GRAVITY) * (orifices - K * DIAMETER) ** 2.5))
    print(f"n = {exponent:.2f} at k = {K}; C = {own:.3f} at k = {K}; C = {factor:.3f}, k = {k:.2f} by a line through W^0.4")
    print("D (mm)  W (kg/s)  Beverloo, that C and k  density (kg/m^3)")
    for orifice, rate, rho in zip(orifices, rates, densities):
        law = own * density * np.sqrt(GRAVITY) * (orifice - K * DIAMETER) ** 2.5
        print(f"{1000 * orifice:6.0f}  {rate:8.4f}  {law:22.4f}  {rho:16.0f}")
    if options.plot:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        figure, axes = pyplot.subplots(figsize=(5, 4))
        line = np.linspace(K * DIAMETER, 1.05 * orifices.max(), 100)
        axes.plot(1000 * line, own * density * np.sqrt(GRAVITY) * (line - K * DIAMETER) ** 2.5, label=f"Beverloo, C = {own:.2f}, k = {K}")
        axes.plot(1000 * orifices, rates, "o", label="unibody")
        axes.set(xlabel="diameter of the orifice (mm)", ylabel="rate (kg/s)")
        axes.legend()
        figure.tight_layout()
        figure.savefig(options.plot)


if __name__ == "__main__":
    main()
