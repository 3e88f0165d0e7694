#!/usr/bin/python3
"""A layer of grains that flows down a rough incline without ends: what the ground feels, and how the velocity rises with the height.

    scripts/python [-n RANKS] scripts/examples/incline_flow.py [--quick] [--solver NAME] [--plot FILE]

The scene is scenes/chute.yaml, at several angles. In a steady flow the force on the ground has the incline's angle, whatever the
grains do; Bagnold's profile is u(z) = u(H) (1 - (1 - z / H)^1.5), with u(H) and H by least squares. Means are over the second half
of 8 s. --quick: one angle, for 1 s.
"""
import argparse
import os

import numpy as np

import unibody

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BED = 72  # spheres that are fixed, which come first
BINS = np.linspace(0.005, 0.105, 11)  # m, heights of layers of grains


def flow(angle, seconds, settings):
    """The mean force on the ground over the second half of the time (N, x and z), the grains' weight (N), and by layers the number of
    grains and the sum of their velocities (m/s); and whether this process is the first."""
    gravity = 9.81 * np.array([np.sin(np.radians(angle)), 0, -np.cos(np.radians(angle))])
    scene = unibody.Scene.load(os.path.join(ROOT, "scenes", "chute.yaml"), set={"gravity": gravity.tolist(), **settings})
    with unibody.Simulation(scene) as simulation:
        steps = int(round(seconds / simulation.step_length))
        simulation.step(steps // 2)
        forces, number, speed = [], np.zeros(len(BINS) - 1), np.zeros(len(BINS) - 1)
        for step in range(steps // 2):
            simulation.step()
            probe = simulation.probe("on_bed")
            forces.append([probe["force_x (N)"], probe["force_z (N)"]])
            if step % 10 == 0:
                height, along = simulation.positions[BED:, 2], simulation.velocities[BED:, 0]
                number += np.histogram(height, BINS)[0]
                speed += np.histogram(height, BINS, weights=along)[0]
        weight = 9.81 * simulation.probe("grains")["mass (kg)"]
        return np.mean(forces, axis=0), weight, number, speed, simulation.rank == 0


def bagnold(height, top, speed):
    return speed * (1 - (1 - np.clip(height / top, 0, 1)) ** 1.5)


def fitted(height, speed, number):
    """H (m) and u(H) (m/s) by least squares over the layers, by their grains, and what is left (m/s, root mean square)."""
    best = None
    for top in np.linspace(height.max(), 2 * height.max(), 101):
        shape = bagnold(height, top, 1)
        scale = np.sum(number * shape * speed) / np.sum(number * shape**2)
        left = np.sqrt(np.sum(number * (scale * shape - speed) ** 2) / np.sum(number))
        if best is None or left < best[2]:
            best = (top, scale, left)
    return best


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--solver", default="gauss_seidel")
    parser.add_argument("--plot", metavar="FILE")
    options = parser.parse_args()
    settings = {"solver.name": options.solver}
    angles, seconds = ((24,), 1) if options.quick else ((20, 22, 24, 26), 8)
    flows = [(angle, *flow(angle, seconds, settings)) for angle in angles]
    if not flows[0][5]:
        return
    print("angle  tan(angle)  along/across  across/(weight cos)  u(H) (m/s)  left of the fit")
    profiles = []
    for angle, force, weight, number, speed, _ in flows:
        filled = number > 0.2 * number.max()
        height, mean = 0.5 * (BINS[1:] + BINS[:-1])[filled], speed[filled] / number[filled]
        top, scale, left = fitted(height, mean, number[filled])
        profiles.append((angle, height, mean, top, scale))
        print(f"{angle:5d}  {np.tan(np.radians(angle)):10.4f}  {-force[0] / force[1]:12.4f}  "
              f"{-force[1] / (weight * np.cos(np.radians(angle))):19.4f}  {scale:10.3f}  {left / scale:15.3f}")
    if options.plot:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        figure, axes = pyplot.subplots(figsize=(5, 4))
        for angle, height, mean, top, scale in profiles:
            points = axes.plot(mean, height, "o", label=f"{angle} degrees")[0]
            fine = np.linspace(0, height.max(), 100)
            axes.plot(bagnold(fine, top, scale), fine, color=points.get_color())
        axes.set(xlabel="velocity along the incline (m/s)", ylabel="height (m)")
        axes.legend()
        figure.tight_layout()
        figure.savefig(options.plot)


if __name__ == "__main__":
    main()
