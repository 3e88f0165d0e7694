#!/usr/bin/python3
"""Runs a case (spheres_case.py) by LIGGGHTS: Hertz and Mindlin with history.    liggghts_process.py CASE.json RESULT.npz"""
import os
import re
import subprocess
import sys
import tempfile

import numpy as np
from spheres_case import read, whole_steps


def write_stl(path, triangles):
    with open(path, 'w', encoding='ascii') as file:
        file.write('solid mesh\n')
        for triangle in np.array(triangles):
            normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
            normal /= np.linalg.norm(normal)
            file.write('facet normal %.9g %.9g %.9g\nouter loop\n' % tuple(normal))
            file.writelines('vertex %.12g %.12g %.12g\n' % tuple(corner) for corner in triangle)
            file.write('endloop\nendfacet\n')
        file.write('endsolid mesh\n')


def matrix(rows):
    return f'peratomtypepair {len(rows)} ' + ' '.join(f'{value:.17g}' for row in rows for value in row)


def deck(case, folder):
    spheres, types = case['spheres'], len(case['materials'])
    x = np.array([sphere['position'] for sphere in spheres])
    corners = [np.array(mesh['triangles']).reshape(-1, 3) for mesh in case['meshes']]
    every = np.concatenate([x, *corners])
    low, high = every.min(0) - 0.02, every.max(0) + 0.02
    for plane in case['planes']:
        low[plane['axis']], high[plane['axis']] = min(low[plane['axis']], plane['place'] - 0.01), max(high[plane['axis']], plane['place'] + 0.01)
    model = 'model hertz tangential history'
    largest = max(sphere['radius'] for sphere in spheres)
    samples, count = whole_steps(case)
    lines = ['units si', 'atom_style granular', 'atom_modify map array', 'boundary f f f', 'newton off', 'communicate single vel yes',
             'region all block ' + ' '.join(f'{a:.17g} {b:.17g}' for a, b in zip(low, high)) + ' units box', f'create_box {types} all',
             f'neighbor {0.2 * largest:.6g} bin', 'neigh_modify delay 0',
             'fix e all property/global youngsModulus peratomtype ' + ' '.join([f'{case["young"]:.17g}'] * types),
             'fix nu all property/global poissonsRatio peratomtype ' + ' '.join([f'{case["poisson"]:.17g}'] * types),
             f'fix cor all property/global coefficientRestitution {matrix(case["restitution"])}',
             f'fix mu all property/global coefficientFriction {matrix(case["friction"])}',
             f'pair_style gran {model}', 'pair_coeff * *']
    lines += [f'create_atoms {sphere["material"] + 1} single ' + ' '.join(f'{v:.17g}' for v in sphere['position']) + ' units box' for sphere in spheres]
    for k, sphere in enumerate(spheres):
        lines.append(f'set atom {k + 1} diameter {2 * sphere["radius"]:.17g} density {sphere["density"]:.17g} '
                     'vx {:.17g} vy {:.17g} vz {:.17g}'.format(*sphere['velocity']))
    lines.append(f'fix gravity all gravity {case["gravity"]:.17g} vector 0 0 -1')
    for k, mesh in enumerate(case['meshes']):
        write_stl(os.path.join(folder, f'mesh{k}.stl'), mesh['triangles'])
        lines += [f'fix mesh{k} all mesh/surface file mesh{k}.stl type {mesh["material"] + 1} curvature_tolerant yes',
                  f'fix wall_mesh{k} all wall/gran {model} mesh n_meshes 1 meshes mesh{k}']
        if mesh['spin']:
            lines.append(f'fix turn{k} all move/mesh mesh mesh{k} rotate origin {" ".join(map(str, mesh["point"]))} axis {" ".join(map(str, mesh["axis"]))} '
                         f'period {2 * np.pi / mesh["spin"]:.17g}')
    lines += [f'fix plane{k} all wall/gran {model} primitive type {plane["material"] + 1} {"xyz"[plane["axis"]]}plane {plane["place"]:.17g}'
              for k, plane in enumerate(case['planes'])]
    lines += ['fix move all nve/sphere', f'timestep {case["step"]:.17g}', 'thermo_style custom step atoms ke', f'thermo {10 * samples}',
              'thermo_modify lost ignore norm no', f'dump d all custom {samples} dump id x y z', 'dump_modify d sort id format "%d %.12g %.12g %.12g"',
              f'run {samples * count}']
    return '\n'.join(lines) + '\n'


def frames(path, count):
    with open(path, encoding='ascii') as text:
        while text.readline():
            header = [text.readline() for _ in range(8)]
            values = np.full((count, 3), np.nan)
            for _ in range(int(header[2])):
                number, *place = text.readline().split()
                values[int(number) - 1] = [float(word) for word in place]
            yield values


def main():
    case = read(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, 'deck'), 'w', encoding='ascii') as file:
            file.write(deck(case, folder))
        allowed = {f'OMPI_ALLOW_RUN_AS_ROOT{end}': '1' for end in ('', '_CONFIRM')} if os.geteuid() == 0 else {}
        done = subprocess.run(['liggghts', '-in', 'deck'], cwd=folder, text=True, env=os.environ | allowed, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              check=False)
        found = re.search(r'^Loop time of ([0-9.e+-]+)', done.stdout, re.M)
        if done.returncode != 0 or not found:
            sys.exit('liggghts failed:\n' + done.stdout[-3000:])
        places = np.array(list(frames(os.path.join(folder, 'dump'), len(case['spheres']))))
    np.savez(sys.argv[2], time=case['every'] * np.arange(len(places)), position=places, seconds=float(found[1]))


if __name__ == '__main__':
    main()
