#!/usr/bin/python3
"""Runs LAMMPS (its granular package) from the first frame of a frames.h5 and records its frames in the same format: as liggghts.py.

   lammps.py INPUT.h5 OUTPUT.h5 [--kn 3.7e4] [--dt 1e-3] [--ranks 1] [--frames 400] [--friction 0.3] [--from-last]

The same linear springs: pair_style gran/hooke/history, whose damping is in units of the effective mass, half of a sphere's.
"""
import numpy as np

from liggghts import main, plane_axis


def deck(arguments, scene, steps, dump):
    spheres, planes = scene['shape'] == 0, scene['shape'] == 2
    if not np.all(spheres | planes):
        raise SystemExit('lammps.py: only spheres and planes')
    if np.any(scene['velocity'][spheres]) or np.any(scene['angular_velocity'][spheres]):
        raise SystemExit('lammps.py: the spheres move at the start')
    radius, mass = scene['size'][spheres, 0], scene['mass'][spheres]
    if np.ptp(radius) > 0 or np.ptp(mass) > 0:
        raise SystemExit('lammps.py: the spheres differ')
    density = mass[0] / (4 / 3 * np.pi * radius[0] ** 3)
    x = scene['position'][spheres]
    low, high = x.min(0) - 5 * radius[0], x.max(0) + 5 * radius[0]
    walls = {}
    for p, q in zip(scene['position'][planes], scene['orientation'][planes]):
        axis = plane_axis(q)
        low[axis], high[axis] = min(low[axis], p[axis] - .1), max(high[axis], p[axis] + .1)
        walls.setdefault(axis, []).append(p[axis])
    gamma = 2 * .69 * (arguments.kn / .5) ** .5
    model = f'{arguments.kn:.17g} {arguments.kn * 2 / 7:.17g} {gamma:.17g} {gamma * 2 / 7:.17g} {arguments.friction:.17g} 1'
    lines = [
        'units si', 'atom_style sphere', 'atom_modify map array', 'boundary m m m', 'newton off', 'comm_modify vel yes',
        f'processors {arguments.ranks} 1 1',
        'region all block ' + ' '.join(f'{a:.17g} {b:.17g}' for a, b in zip(low, high)) + ' units box', 'create_box 1 all',
        f'neighbor {.2 * radius[0]:.6g} bin', 'neigh_modify delay 0', f'pair_style gran/hooke/history {model}', 'pair_coeff * *']
    lines += [f'create_atoms 1 single {a:.17g} {b:.17g} {c:.17g} units box' for a, b, c in x]
    lines += [
        f'set group all diameter {2 * radius[0]:.17g}', f'set group all density {density:.17g}',
        f'fix gravity all gravity {arguments.gravity:.17g} vector 0 0 -1']
    for axis, at in walls.items():
        sides = f'{min(at):.17g} NULL' if len(at) == 1 else f'{min(at):.17g} {max(at):.17g}'
        lines.append(f'fix wall{axis} all wall/gran hooke/history {model} {"xyz"[axis]}plane {sides}')
    lines += ['fix move all nve/sphere', f'timestep {arguments.frame_time / steps:.17g}', f'thermo {100 * steps}',
              f'dump d all custom {steps} {dump} id x y z vx vy vz omegax omegay omegaz',
              'dump_modify d sort id format line "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"', f'run {arguments.frames * steps}']
    return '\n'.join(lines) + '\n'


if __name__ == '__main__':
    main(('lmp',), deck)
