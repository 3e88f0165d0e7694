"""2000 boxes at rest: what is left of penetration and motion, however many iterations a step has."""
import json
import os

from runs import BUILD, OUT, command, folder, line, publish, say, table, unibody

SCENE = 'boxes_2000'
REST, GO_ON = 800, 100  # frames with SETTLER until nothing moves any more; with each setting from there
SETTLER = ['solver.name=gauss_seidel', 'solver.iterations=40']
CHAINS = {'gauss_seidel': (10, 20, 40, 80), 'accelerated_jacobi': (20, 40, 80, 160)}
KINETIC = 3e-4  # J a body, at most, from here on


def rest(arguments):
    path, frames = folder('floor'), arguments.frames or REST
    say(f'{SCENE}: {frames} frames until they rest')
    unibody(SCENE, SETTLER + ['output.every=0', 'output.checkpoint_every=0'], path, 1, arguments.core, frames)
    return os.path.join(path, 'checkpoint.h5'), frames


def go_on(solver, iterations, start, frames, core):
    """Medians of the last 100 frames, judged from the poses."""
    say(f'floor: {solver} {iterations}')
    path = folder('floor_on')
    unibody(SCENE, [f'solver.name={solver}', f'solver.iterations={iterations}'], path, 1, core, frames + GO_ON, start)
    return json.loads(command([os.path.join(BUILD, 'scripts', 'rivals', 'measure'), '--json', os.path.join(path, 'frames.h5')]))


def floor(arguments):
    start, frames = rest(arguments)
    lines = table(['solver', 'iterations', 'RMS mm', 'max mm', 'KE/body J', 'lost'])
    verdicts, all_found = [], {}
    for solver, counts in CHAINS.items():
        found = [go_on(solver, k, start, frames, arguments.core) for k in counts]
        for k, e in zip(counts, found):
            lines.append(line(solver, k, f'{e["rms_mm"]:.2g}', f'{e["max_mm"]:.2g}', f'{e["kinetic_j"]:.1e}', e['lost']))
        all_found[solver] = [{'iterations': k, 'rms_mm': e['rms_mm'], 'kinetic_j': e['kinetic_j']} for k, e in zip(counts, found)]
        falls = all(a['rms_mm'] > b['rms_mm'] for a, b in zip(found, found[1:]))
        verdicts.append(line(f'{solver}: RMS falls with each doubling of the iterations', 'met' if falls else 'MISSED'))
        slow = [k for k, e in zip(counts, found) if e['kinetic_j'] > KINETIC]
        verdicts.append(line(f'{solver}: KE/body <= {KINETIC} J', f'MISSED with {", ".join(map(str, slow))}' if slow else 'met'))
    with open(os.path.join(OUT, 'floor.json'), 'w', encoding='utf-8') as file:
        json.dump(all_found, file, indent=1)
    publish('floor.md', lines + [''] + table(['target', '']) + verdicts)
