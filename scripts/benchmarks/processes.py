"""Three processes on which programs of discrete elements are compared (Dosta et al., Computer Physics Communications 2024, 109066), at a size at
which soft spheres of 1 GPa end in minutes: the same spheres, settled by unibody, go on in unibody, LIGGGHTS and YADE."""
import json
import os
import shutil
import sys

import h5py
import numpy as np
import yaml
import runs
from runs import ROOT, command, folder, line, publish, report_rows, say, table

sys.path.append(os.path.join(ROOT, 'scripts'))
sys.path.append(os.path.join(ROOT, 'scripts', 'rendering'))
from bodies import rotate  # noqa: E402
from frame_rows import rows_of  # noqa: E402

RIVALS = os.path.join(ROOT, 'scripts', 'rivals')
YOUNG, POISSON, GRAVITY = 1e9, 0.3, 9.81
STEP = 2e-6  # s, of the soft spheres: 0.12 of Rayleigh's time
VARIANTS = {'unibody': [], 'unibody, margin 0.1 mm': ['solver.margin=0.0001'],
            'unibody, margin 0.1 mm, 16 steps a frame': ['solver.margin=0.0001', 'time.substeps=16']}
FINER = {'intruder': {'unibody, margin 0.1 mm, 60 steps a frame': ['solver.margin=0.0001', 'time.substeps=60'],
                      'unibody, 200 steps a frame': ['time.substeps=200']}}
M2 = ['materials.M1.friction=0.4', 'materials.M1.restitution=0.4', 'bodies[2].density=2000']
SMALL = ['bodies[0].shape.mesh.revolve.profile=[[0.008, 0], [0.022, 0], [0.022, 0.12]]']
# name: scene, settings, when the rivals start (s), for how long (s), how often places are compared (s)
PROCESSES = {
    'silo M1, 20 mm': ('silo_emptying', [], 0.5, 1.5, 0.02),
    'silo M1, 20 mm, second start': ('silo_emptying', ['bodies[2].lattice.seed=2'], 0.5, 1.5, 0.02),
    'silo M1, 20 mm, third start': ('silo_emptying', ['bodies[2].lattice.seed=3'], 0.5, 1.5, 0.02),
    'silo M2, 16 mm': ('silo_emptying', M2 + SMALL, 0.5, 1.5, 0.02),
    'drum': ('drum_mixing', [], 0.3, 5.0, 0.05),
    'intruder': ('intruder', [], 0.5, 0.2, 0.01),
}


def materials_of(scene):
    """Names, and friction and restitution of all pairs."""
    names = [name for name in scene['materials'] if name != 'pairs']
    friction, restitution = (np.zeros((len(names), len(names))) for _ in range(2))
    for values, key in ((friction, 'friction'), (restitution, 'restitution')):
        for k, name in enumerate(names):
            values[k, k] = scene['materials'][name][key]
        for pair in scene['materials']['pairs']:
            i, j = (names.index(name) for name in pair['between'])
            values[i, j] = values[j, i] = pair[key]
    return names, friction, restitution


def set_in(scene, setting):
    """What -set does, of settings of this file."""
    path, value = setting.split('=', 1)
    for part in path.replace('[', '.').replace(']', '').split('.')[:-1]:
        scene = scene[int(part) if part.isdigit() else part]
    scene[path.rsplit('.', 1)[1]] = yaml.safe_load(value)


def case_of(scene, file, frame, end, every):
    """The spheres, triangles and planes of a frame of frames.h5, for spheres_case.py. What a sphere that comes later has is the scene's."""
    names, friction, restitution = materials_of(scene)
    kinds = file['bodies'].attrs['shape_names'].decode().split()
    shape, size, mass, number = (file['bodies'][key][:] for key in ('shape', 'size', 'mass', 'material'))
    position, velocity, orientation = (rows_of(file, file['frames'][frame], key) for key in ('position', 'velocity', 'orientation'))
    shape_number = file['bodies/shape_number'][:] if 'shape_number' in file['bodies'] else None
    case = {'young': YOUNG, 'poisson': POISSON, 'gravity': GRAVITY, 'step': STEP, 'end': end, 'every': every, 'materials': names,
            'friction': friction.tolist(), 'restitution': restitution.tolist(), 'spheres': [], 'meshes': [], 'planes': [], 'ids': []}
    for k, kind in enumerate(kinds[s] for s in shape):
        material = int(number[k])
        if kind == 'sphere':
            radius = float(size[k, 0])
            case['ids'].append(k)
            case['spheres'].append({'radius': radius, 'density': float(mass[k] / (4 / 3 * np.pi * radius**3)), 'material': material,
                                    'position': position[k].tolist(), 'velocity': velocity[k].tolist()})
        elif kind == 'mesh':
            own = file[f'shapes/mesh_{shape_number[k]}']
            corners = position[k] + rotate(orientation[k][None], own['nodes'][:])
            spin = next((body['angular_velocity'][1]['table'][-1][1] for body in scene['bodies'] if 'angular_velocity' in body), 0)
            case['meshes'].append({'triangles': corners[own['triangles'][:]].tolist(), 'material': material, 'spin': spin, 'axis': [0, 1, 0],
                                   'point': position[k].tolist()})
        elif kind == 'plane':
            normal = rotate(orientation[k][None], np.array([[0., 0, 1]]))[0]
            axis = int(np.argmax(abs(normal)))
            case['planes'].append({'axis': axis, 'place': float(position[k, axis]), 'normal': int(np.sign(normal[axis])), 'material': material})
    return case


def unibody(scene_name, settings, out, core, start=None):
    words = [os.path.join(runs.BUILD, 'unibody'), os.path.join(ROOT, 'scenes', scene_name + '.yaml'), '-output', out, '-overwrite']
    words += ['-start_from', start] if start else []
    for setting in settings:
        words += ['-set', setting]
    command(words, 0, core)


def own_run(name, core, variants):
    """unibody's runs of a process, by variants of its settings: times from where the rivals start, places of the spheres, and seconds; and the
    case for the others. What all start from is settled with many iterations: spheres of 1 GPa that overlap by a hundredth of a millimetre fly apart."""
    scene_name, settings, start, end, every = PROCESSES[name]
    with open(os.path.join(ROOT, 'scenes', scene_name + '.yaml'), encoding='utf-8') as file:
        scene = yaml.safe_load(file)
    for setting in settings:
        set_in(scene, setting)
    frame = scene['time']['frame']
    settled = folder('process_' + short(name) + '_settled')
    unibody(scene_name, settings + [f'time.frames={round(start / frame)}', 'time.substeps=10', 'solver.iterations=1000'], settled, core)
    with h5py.File(os.path.join(settled, 'frames.h5')) as file:
        last = sorted(file['frames'])[-1]
        case = case_of(scene, file, last, end, every)
        if scene_name == 'intruder':  # which comes now
            case['spheres'][-1] |= {'position': scene['bodies'][-1]['position'], 'velocity': scene['bodies'][-1]['velocity']}
    return {variant: own_variant(name, settings + [f'output.every={round(every / frame)}'] + more, settled, case, core)
            for variant, more in variants.items()}, case


def own_variant(name, settings, settled, case, core):
    scene_name, _, start, end, _ = PROCESSES[name]
    out = folder('process_' + short(name))
    unibody(scene_name, settings, out, core, os.path.join(settled, 'checkpoint.h5'))
    seconds = sum(float(row[key]) for row in report_rows(out) for key in row if key.split(' ')[0] in ('wall_collide', 'wall_solve', 'wall_halo'))
    times, places = [0.], [np.array([sphere['position'] for sphere in case['spheres']])]
    with h5py.File(os.path.join(out, 'frames.h5')) as file:
        for key in sorted(file['frames']):
            time = float(file['frames'][key].attrs['time']) - start
            if 1e-9 < time <= end + 1e-9:
                times.append(time)
                places.append(rows_of(file, file['frames'][key], 'position')[case['ids']])
    return {'time': np.array(times), 'position': np.array(places), 'seconds': seconds}


def short(name):
    return name.replace(' ', '_').replace(',', '')


def rival_run(program, name, case, core):
    paths = [folder(f'process_{short(name)}_{what}') for what in ('case.json', f'{program}.npz')]
    with open(paths[0], 'w', encoding='utf-8') as file:
        json.dump(case, file)
    script = os.path.join(RIVALS, program + '_process.py')
    os.environ['UNIBODY_RIVALS'] = RIVALS
    command((['yade', '-n', '-x', '-j1', script] if program == 'yade' else ['/usr/bin/python3', script]) + paths, 0, core)
    return dict(np.load(paths[1]))


def curves(name, run, case):
    """What is compared, over time: columns by name."""
    x, z = run['position'][:, :, 0], run['position'][:, :, 2]
    if name.startswith('silo'):
        return {'share that has left': np.mean(~(z > -0.004), 1)}
    if name == 'drum':
        first = np.array([sphere['material'] == 0 for sphere in case['spheres']])
        share = {'upper left': (x < 0) & (z > 0), 'lower left': (x < 0) & (z <= 0), 'upper right': (x >= 0) & (z > 0), 'lower right': (x >= 0) & (z <= 0)}
        return {key: (inside & first).sum(1) / first.sum() for key, inside in share.items()}
    return {'height of the lowest point (mm)': 1000 * (z[:, -1] - case['spheres'][-1]['radius'])}


def plot(results):
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(2, max(2, -(-len(results) // 2)), figsize=(14, 8))
    for place, (name, programs) in zip(axes.flat, results.items()):
        for number, (program, (run, columns)) in enumerate(programs.items()):
            for k, values in enumerate(columns.values()):
                place.plot(run['time'], values, color=f'C{number}', linestyle=['-', '--', ':', '-.'][k], label=program if k == 0 else None)
        place.set(title=name, xlabel='time (s)', ylabel=' / '.join(programs['unibody'][1]) if len(programs['unibody'][1]) == 1 else 'share of M1 in each quarter')
        place.legend()
    figure.tight_layout()
    figure.savefig(os.path.join(runs.OUT, 'processes.png'))


def processes(arguments):
    wanted = ['intruder'] if arguments.quick else list(PROCESSES)
    programs = ['liggghts'] + (['yade'] if shutil.which('yade') else [])
    results = {}
    for name in wanted:
        own, case = own_run(name, arguments.core, VARIANTS | FINER.get(name, {}))
        results[name] = {variant: (run, curves(name, run, case)) for variant, run in own.items()}
        for program in programs:
            run = rival_run(program, name, case, arguments.core)
            results[name][program] = (run, curves(name, run, case))
            say(f'{name}: {program} {float(run["seconds"]):.0f} s, unibody {own["unibody"]["seconds"]:.2f} s')
        publish('processes.md', report(results), show=name == wanted[-1])
        plot(results)


def apart(a, b):
    """The root mean square of what two programs' curves differ by, over all of them and the times that both have."""
    count = min(len(a[0]['time']), len(b[0]['time']))
    return np.sqrt(np.mean([(a[1][key][:count] - b[1][key][:count])**2 for key in a[1]]))


def figure(name, run):
    """One number of a curve."""
    column = next(iter(run[1].values()))
    if name.startswith('silo'):
        return f'{np.interp(0.36, column, run[0]["time"]):.3f} s until 36 % have left'
    return f'{column[-1]:.3g} at the end ({next(iter(run[1]))})'


def report(results):
    lines = table(['process', 'program', 's of computing', 'over unibody', 'RMS from unibody', 'RMS from LIGGGHTS', 'figure'])
    for name, programs in results.items():
        for program, run in programs.items():
            seconds = float(run[0]['seconds'])
            lines.append(line(name, program, f'{seconds:.3g}', f'{seconds / float(programs["unibody"][0]["seconds"]):.0f}', f'{apart(run, programs["unibody"]):.3g}',
                              f'{apart(run, programs["liggghts"]):.3g}' if 'liggghts' in programs else '', figure(name, run)))
    return lines
