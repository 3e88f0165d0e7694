#!/usr/bin/python3
"""Runs LIGGGHTS (soft spheres) from the first frame of a frames.h5 and records its frames in the same format.

   liggghts.py INPUT.h5 OUTPUT.h5 [--kn 3.7e4] [--dt 1e-3] [--ranks 1] [--frames 400] [--friction 0.3] [--from-last]

Linear springs: kt = 2/7 kn; damping for a restitution of about .05: gamman = 2 * .69 * sqrt(kn / .5) 1/s for bodies of 1 kg,
gammat = 2/7 gamman. All spheres must be equal and at rest at the start, planes axis-aligned. --from-last: from the places of the
last frame instead, at rest. Prints the wall time of a frame, the mean of all, writing not included.
"""
import argparse
import itertools
import os
import re
import subprocess
import sys
import tempfile

import h5py
import numpy as np


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('input')
    parser.add_argument('output')
    parser.add_argument('--kn', type=float, default=3.7e4, help='normal stiffness, N/m')
    parser.add_argument('--dt', type=float, default=1e-3, help='time step, s; rounded so that a frame holds whole steps')
    parser.add_argument('--ranks', type=int, default=1)
    parser.add_argument('--frames', type=int, default=400)
    parser.add_argument('--frame-time', type=float, default=.016)
    parser.add_argument('--friction', type=float, default=.3)
    parser.add_argument('--gravity', type=float, default=9.8)
    parser.add_argument('--from-last', action='store_true', help='start from the places of the last frame, at rest')
    return parser.parse_args()


def plane_axis(q):
    """Axis 0..2 of the normal (0, 0, 1) turned by q = (w, x, y, z)."""
    w, x, y, z = q
    normal = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    axis = int(np.argmax(abs(normal)))
    if abs(normal[axis]) < 1 - 1e-9:
        sys.exit('liggghts.py: a plane is not axis-aligned')
    return axis


def deck(arguments, scene, steps, dump):
    spheres, planes = scene['shape'] == 0, scene['shape'] == 2
    if not np.all(spheres | planes):
        sys.exit('liggghts.py: only spheres and planes')
    if np.any(scene['velocity'][spheres]) or np.any(scene['angular_velocity'][spheres]):
        sys.exit('liggghts.py: the spheres move at the start')
    radius, mass = scene['size'][spheres, 0], scene['mass'][spheres]
    if np.ptp(radius) > 0 or np.ptp(mass) > 0:
        sys.exit('liggghts.py: the spheres differ')
    density = mass[0] / (4 / 3 * np.pi * radius[0] ** 3)
    x = scene['position'][spheres]
    low, high = x.min(0) - 5 * radius[0], x.max(0) + 5 * radius[0]
    walls = []
    for p, q in zip(scene['position'][planes], scene['orientation'][planes]):
        axis = plane_axis(q)
        low[axis], high[axis] = min(low[axis], p[axis] - .1), max(high[axis], p[axis] + .1)
        walls.append((axis, p[axis]))
    gamma = 2 * .69 * (arguments.kn / .5) ** .5
    model = 'model hooke/stiffness tangential history'
    lines = [
        'units si', 'atom_style granular', 'atom_modify map array', 'boundary m m m', 'newton off', 'communicate single vel yes',
        f'processors {arguments.ranks} 1 1',
        'region all block ' + ' '.join(f'{a:.17g} {b:.17g}' for a, b in zip(low, high)) + ' units box',
        'create_box 1 all', f'neighbor {.2 * radius[0]:.6g} bin', 'neigh_modify delay 0',
        f'fix kn all property/global kn peratomtypepair 1 {arguments.kn:.17g}',
        f'fix kt all property/global kt peratomtypepair 1 {arguments.kn * 2 / 7:.17g}',
        f'fix gn all property/global gamman peratomtypepair 1 {gamma:.17g}',
        f'fix gt all property/global gammat peratomtypepair 1 {gamma * 2 / 7:.17g}',
        f'fix mu all property/global coefficientFriction peratomtypepair 1 {arguments.friction:.17g}',
        f'pair_style gran {model}', 'pair_coeff * *',
    ]
    lines += [f'create_atoms 1 single {a:.17g} {b:.17g} {c:.17g} units box' for a, b, c in x]
    lines += [f'set group all density {density:.17g} diameter {2 * radius[0]:.17g}',
              f'fix gravity all gravity {arguments.gravity:.17g} vector 0 0 -1']
    lines += [f'fix wall{k} all wall/gran {model} primitive type 1 {"xyz"[axis]}plane {at:.17g}' for k, (axis, at) in enumerate(walls)]
    lines += ['fix move all nve/sphere', f'timestep {arguments.frame_time / steps:.17g}', 'thermo_style custom step atoms ke',
              f'thermo {100 * steps}', f'dump d all custom {steps} {dump} id x y z vx vy vz omegax omegay omegaz',
              'dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"',
              f'run {arguments.frames * steps}']
    return '\n'.join(lines) + '\n'


def frames_of(dump, count):
    """Yields arrays [count, 9] in order of id; lost spheres are NaN."""
    with open(dump) as text:
        while text.readline():
            header = [text.readline() for _ in range(8)]
            values = np.full((count, 9), np.nan)
            rows = np.fromstring(''.join(itertools.islice(text, int(header[2]))), sep=' ').reshape(-1, 10)
            values[rows[:, 0].astype(int) - 1] = rows[:, 1:]
            yield values


def main(words=('liggghts',), write_deck=deck):
    """`words`: how the program is started; it reads the deck from the file that follows -in."""
    arguments = parse()
    with h5py.File(arguments.input) as source:
        scene = {k: source['bodies'][k][:] for k in ('shape', 'size', 'mass', 'inertia', 'motion')}
        start = source['frames'][(max if arguments.from_last else min)(source['frames'], key=int)]
        scene.update({k: start[k][:] for k in ('position', 'orientation', 'velocity', 'angular_velocity')})
    if arguments.from_last:
        scene['velocity'][:], scene['angular_velocity'][:] = 0, 0
    spheres = scene['shape'] == 0
    steps = max(1, round(arguments.frame_time / arguments.dt))
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, 'deck'), 'w') as file:
            file.write(write_deck(arguments, scene, steps, 'dump'))
        allowed = {f'OMPI_ALLOW_RUN_AS_ROOT{end}': '1' for end in ('', '_CONFIRM')} if os.geteuid() == 0 else {}
        done = subprocess.run(['mpirun', '-n', str(arguments.ranks), *words, '-in', 'deck'], cwd=folder, text=True,
                              env=os.environ | allowed, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        times = {key: float(value) for key, value in re.findall(r'^(Loop|Outpt) +time[^0-9]*(?:of )?([0-9.e+-]+)', done.stdout, re.M)}
        if output := re.search(r'^Output +\|[^|]*\| *([0-9.e+-]+)', done.stdout, re.M):  # as LAMMPS says it: least, mean, most of the ranks
            times['Outpt'] = float(output[1])
        if done.returncode != 0 or 'Loop' not in times:
            sys.exit(f'{words[0]} failed:\n' + done.stdout[-3000:])
        with h5py.File(arguments.output, 'w') as target:
            for key in ('shape', 'size', 'mass', 'inertia', 'motion'):
                target['bodies/' + key] = scene[key]
            for number, values in enumerate(frames_of(os.path.join(folder, 'dump'), int(spheres.sum()))):
                group = target.create_group(f'frames/{number:06d}')
                for key, columns in (('position', slice(0, 3)), ('velocity', slice(3, 6)), ('angular_velocity', slice(6, 9))):
                    array = scene[key].copy()
                    array[spheres] = values[:, columns]
                    group[key] = array
                group['orientation'] = scene['orientation']
    print(f'mean_ms {1e3 * (times["Loop"] - times.get("Outpt", 0)) / arguments.frames:.4f}')


if __name__ == '__main__':
    main()
