"""Rigid bodies beside other programs, in turn on the same core, and what of it meets its target."""
import csv
import json
import os
import statistics
import sys
from dataclasses import dataclass

import targets
from runs import BUILD, DEFAULTS, OUT, ROOT, command, frame_ms, publish, say, table, unibody

SCENES = {'B2000': 'boxes_2000', 'B5000': 'boxes_5000', 'BW2000': 'boxes_walled_2000', 'S5000': 'spheres_5000', 'T2000': 'towers_2000'}


@dataclass
class Setting:
    name: str
    family: str           # GS, AJ, Bullet, LIGGGHTS
    iterations: int       # a step
    options: list         # values of the scene (unibody) or options of the driver
    quick: bool = False
    scenes: tuple = ()    # only these; none: all
    control: bool = False  # shows what something is good for: not held to coming to rest


def gauss_seidel(iterations, quick=False, scenes=(), more=(), says='', control=False):
    values = ['solver.name=gauss_seidel', f'solver.iterations={iterations}', *more]
    return Setting(f'GS {iterations}{says}', 'GS', iterations, values, quick, scenes, control)


def accelerated_jacobi(iterations, quick=False, scenes=(), more=(), says=''):
    values = ['solver.name=accelerated_jacobi', f'solver.iterations={iterations}', *more]
    return Setting(f'AJ {iterations}{says}', 'AJ', iterations, values, quick, scenes)


def one_stage(share):
    """The position stage alone, from a share of the old multipliers."""
    return ['solver.stages=position', f'solver.warm_start={share}']


UNIBODY = [
    gauss_seidel(4, scenes=('B2000',)), gauss_seidel(6), gauss_seidel(10, quick=True), gauss_seidel(20, quick=True), gauss_seidel(40),
    gauss_seidel(80, scenes=('B2000',)), gauss_seidel(100, scenes=('B2000',)),
    gauss_seidel(20, scenes=('B2000',), more=one_stage(0), says=' one stage, cold', control=True),
    gauss_seidel(20, scenes=('B2000',), more=one_stage(.5), says=' one stage, warm .5', control=True),
    accelerated_jacobi(10, scenes=('T2000',)), accelerated_jacobi(20, quick=True), accelerated_jacobi(50, quick=True),
    accelerated_jacobi(100, scenes=('S5000',)), accelerated_jacobi(50, scenes=('S5000',), more=['solver.leak=0.2'], says=' leak .2'),
    *(accelerated_jacobi(k, more=['solver.velocity_share=0.5', 'solver.leak=0'], says=' halves, no leak') for k in (20, 50)),
    Setting('GS 4x5', 'GS substeps', 5, ['solver.name=gauss_seidel', 'solver.iterations=5', 'time.substeps=4']),
    Setting('as shipped', 'defaults', 50, DEFAULTS),
]
TWO_RANKS = ('GS 10', 'GS 20', 'AJ 50')  # of these also on 2 ranks
BULLET = [
    Setting('Bullet 10', 'Bullet', 10, ['--iterations', '10'], quick=True),
    Setting('Bullet 4x5', 'Bullet', 5, ['--iterations', '5', '--substeps', '4']),
    Setting('Bullet 4x50', 'Bullet', 50, ['--iterations', '50', '--substeps', '4'], scenes=('T2000',), quick=True),
]
LIGGGHTS = [
    Setting('LIGGGHTS kn=3.7e4', 'LIGGGHTS', 0, ['--kn', '3.7e4', '--dt', '1e-3'], scenes=('S5000',), quick=True),
    Setting('LIGGGHTS kn=2e6', 'LIGGGHTS', 0, ['--kn', '2e6', '--dt', '1.333e-4'], scenes=('S5000',)),
]
# With so many iterations, so many frames until it has been at rest for 100.
SETTLING = {'B2000': (80, 560)}


def run_once(scene, setting, ranks, core, write, frames):
    """One run: (ms a frame, the file with its frames). unibody writes one only if asked to."""
    output = os.path.join(OUT, 'runs', scene)
    start, file = os.path.join(output, 'start', 'frames.h5'), os.path.join(output, setting.family + '.h5')
    count = ['--frames', str(frames)] if frames else []
    driver = {'Bullet': 'bullet', 'LIGGGHTS': 'liggghts.py'}.get(setting.family)
    if driver:
        folder = BUILD if setting.family == 'Bullet' else ROOT
        said = command([os.path.join(folder, 'scripts', 'rivals', driver), start, file] + setting.options + count, 0, core)
        if '_ms' not in said:
            sys.exit(f'{setting.name} on {scene}: no time, it said: {said.strip()}')
        return float(said.split('_ms')[1]), file
    folder = os.path.join(output, 'unibody')
    rows = unibody(SCENES[scene], setting.options + ([] if write else ['output.every=0']), folder, ranks, core, frames)
    return frame_ms(rows), os.path.join(folder, 'frames.h5')


def error_of(scene, setting, ranks, core, frames):
    iterations, until_rest = SETTLING.get(scene, (0, 0))
    if setting in UNIBODY and until_rest and setting.iterations >= iterations:
        frames = frames or until_rest
    file = run_once(scene, setting, ranks, core, True, frames)[1]
    return json.loads(command([os.path.join(BUILD, 'scripts', 'rivals', 'measure'), '--json', file]))


def plan(scene, quick):
    entries = [(s, 1) for s in BULLET + LIGGGHTS + UNIBODY if (not s.scenes or scene in s.scenes) and (s.quick or not quick)]
    if not quick or scene == 'B2000':
        entries += [(s, 2) for s in UNIBODY if s.name in TWO_RANKS and (s.quick or not quick)]
    return entries


def rigid(arguments):
    rows = []
    for scene in arguments.scenes:
        start = os.path.join(OUT, 'runs', scene, 'start')
        os.makedirs(os.path.dirname(start), exist_ok=True)
        unibody(SCENES[scene], ['output.every=1'], start, 1, None, 1)  # frame 0: where all programs start
        entries = plan(scene, arguments.quick)
        times, errors = [[] for _ in entries], []
        for setting, ranks in entries:
            say(f'{scene} error of {setting.name} on {ranks}')
            errors.append(error_of(scene, setting, ranks, arguments.core, arguments.frames))
        for run in range(arguments.runs):
            for k, (setting, ranks) in enumerate(entries):
                say(f'{scene} run {run + 1}/{arguments.runs} {setting.name} on {ranks}')
                times[k].append(run_once(scene, setting, ranks, arguments.core, False, arguments.frames)[0])
        for (setting, ranks), ms, e in zip(entries, times, errors):
            rows.append({'scene': scene, 'name': setting.name, 'family': setting.family, 'iterations': setting.iterations, 'ranks': ranks,
                         'ours': setting in UNIBODY, 'control': setting.control, 'ms': statistics.median(ms), 'ms_least': min(ms), 'ms_most': max(ms),
                         **{k: v for k, v in e.items() if k != 'file'}})
        publish_rigid(rows)  # after each scene: a run that is stopped keeps what it has


def publish_rigid(rows):
    for row in rows:
        peer = next((r['ms'] for r in rows if r['scene'] == row['scene'] and r['name'] == targets.BULLET), None)
        row['ratio'] = row['ms'] / peer if peer else None
    with open(os.path.join(OUT, 'rigid.json'), 'w', encoding='utf-8') as file:
        json.dump(rows, file, indent=1)
    with open(os.path.join(OUT, 'rigid.csv'), 'w', encoding='utf-8', newline='') as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    lines = table([
        'scene', 'program', 'ranks', 'frames', 'RMS mm', 'L2 mm', 'max mm', 'peak L2/max mm', 'KE/body J', 'mean height m',
        'ms a frame (least-most)', '/ Bullet 10'])
    for r in rows:
        name = ('**unibody ' + r['name'] + '**') if r['ours'] else r['name']
        lost = f' ({r["lost"]} lost)' if r['lost'] else ''
        ratio = '-' if r['ratio'] is None else f'{r["ratio"]:.2f}'
        lines.append(f'| {r["scene"]} | {name} | {r["ranks"]} | {r["frames"] - 1} | {r["rms_mm"]:.3g} | {r["l2_mm"]:.1f} | {r["max_mm"]:.2f} | '
                     f'{r["peak_l2_mm"]:.0f}/{r["peak_max_mm"]:.0f} | {r["kinetic_j"]:.1e} | {r["height_m"]:.3f}{lost} | '
                     f'{r["ms"]:.1f} ({r["ms_least"]:.1f}-{r["ms_most"]:.1f}) | {ratio} |')
    publish('rigid.md', lines)


def kept(name):
    """What a part wrote as JSON; None if it was not run."""
    path = os.path.join(OUT, name)
    if not os.path.exists(path):
        return None
    with open(path, encoding='utf-8') as file:
        return json.load(file)


def compare(_):
    rows = kept('rigid.json')
    if rows is None:
        sys.exit('bench: no results yet: scripts/bench rigid targets')
    publish('targets.md', ['| # | | scene | target | | by |', '|' + '---|' * 6] +
            ['| ' + ' | '.join(str(cell) for cell in line) + ' |' for line in targets.compare(rows, kept('floor.json'))])
