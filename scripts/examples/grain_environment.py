#!/usr/bin/python3
"""A rover on grains, as an environment for reinforcement learning in Gymnasium's manner.

    scripts/python scripts/examples/grain_environment.py

A body of 2 kg drives on four wheels over a bed of grains. An action is the speed (rad/s, -10 to 10) of the left and of the right
wheels for a tenth of a second. An observation holds the rover's place relative to where it started (m), its orientation (w, x, y, z),
its velocity (m/s) and its angular velocity (rad/s): 13 numbers. The reward is the way made along x (m) less 1e-5 of the
action's square. The episode ends when the rover lies on its back, and is cut off after 5 s.

Where the package gymnasium is there, RoverOnGrains is one of its environments; without it the class has the same methods. Run as a
script, it drives straight on for two seconds, and ends with exit code 1 where the rover does not come forwards.
"""
import sys

import numpy as np

import unibody

try:
    import gymnasium
    Environment = gymnasium.Env
    box = gymnasium.spaces.Box
except ImportError:
    Environment = object
    box = None

GRAIN, WHEEL = 0.02, 0.06  # m, radii
WHEELS = [(x, y) for y in (0.13, -0.13) for x in (0.12, -0.12)]  # left ones first


def scene(seed):
    wheels = [{"name": f"wheel{k}", "shape": {"cylinder": {"radius": WHEEL, "length": 0.05}}, "mass": 0.2, "material": "rubber",
               "position": [x, y, 0.2], "orientation": {"axis": [1, 0, 0], "angle": 90}} for k, (x, y) in enumerate(WHEELS)]
    axles = [{"type": "hinge", "bodies": [f"wheel{k}", "rover"], "anchor": [x, y, 0.2], "axis": [0, 1, 0],
              "motor": {"speed": 0, "max_torque": 2}} for k, (x, y) in enumerate(WHEELS)]
    return unibody.Scene({
        "title": "a rover on grains",
        "time": {"frame": 0.01, "frames": 500},
        "materials": {"rubber": {"friction": 0.9}, "grain": {"friction": 0.5}},
        "bodies": [
            {"name": "bed", "container": {"size": [2, 0.8]}, "material": "grain"},
            {"name": "rover", "shape": {"box": {"size": [0.3, 0.16, 0.06]}}, "mass": 2, "position": [0, 0, 0.2],
             "material": "rubber"},
            *wheels,
            {"name": "grain", "shape": {"sphere": {"radius": GRAIN}}, "density": 2500, "material": "grain",
             "lattice": {"count": 1800, "columns": [45, 18], "spacing": [0.0425, 0.0425, 0.0425], "height": 0.021,
                         "jitter": 0.001, "seed": seed}},
        ],
        "joints": axles})


class RoverOnGrains(Environment):
    metadata = {"render_modes": []}
    steps_of_action = 10
    seconds = 5.0

    def __init__(self):
        self.simulation = None
        if box is not None:
            self.action_space = box(-10.0, 10.0, (2,), np.float64)
            self.observation_space = box(-np.inf, np.inf, (13,), np.float64)

    def reset(self, *, seed=None, options=None):
        """The rover stands still on a bed that the seed lays out. Returns the observation and a dict."""
        del options
        if box is not None:
            super().reset(seed=seed)
        self.close()
        made = scene(0 if seed is None else seed)
        self.rover = int(made.ids("rover")[0])
        self.simulation = unibody.Simulation(made)
        self.simulation.step(50)  # it sinks in
        self.start = self.simulation.positions[self.rover].copy()
        self.started = self.simulation.time
        return self.observe(), {}

    def observe(self):
        s = self.simulation
        return np.concatenate([s.positions[self.rover] - self.start, s.orientations[self.rover], s.velocities[self.rover],
                               s.angular_velocities[self.rover]])

    def step(self, action):
        """Returns the observation, the reward, whether the episode has ended, whether it was cut off, and a dict."""
        left, right = np.clip(action, -10, 10)
        for joint, speed in enumerate((left, left, right, right)):
            self.simulation.set_motor(joint, speed)
        before = self.simulation.positions[self.rover, 0]
        self.simulation.step(self.steps_of_action)
        seen = self.observe()
        reward = seen[0] + self.start[0] - before - 1e-5 * float(np.dot(action, action))
        w, x, y, z = seen[3:7]
        on_its_back = 1 - 2 * (x * x + y * y) < 0
        return seen, reward, bool(on_its_back), self.simulation.time - self.started > self.seconds - 1e-9, {}

    def close(self):
        if self.simulation is not None:
            self.simulation.close()
            self.simulation = None


def main():
    environment = RoverOnGrains()
    environment.reset(seed=1)
    for k in range(20):
        seen, reward, ended, cut, _ = environment.step([5, 5])
        if k % 5 == 4:
            print(f"{(k + 1) / 10:.1f} s: x = {seen[0]:+.4f} m, y = {seen[1]:+.4f} m, reward {reward:+.5f}", flush=True)
        if ended or cut:
            break
    environment.close()
    # Wheels that don't slip would make 0.06 m x 5 rad/s x 2 s = 0.6 m.
    if not 0.2 < seen[0] < 0.65:
        sys.exit("the rover did not come forwards")


if __name__ == "__main__":
    main()
