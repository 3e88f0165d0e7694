"""Soft solids: distance to the converged step against time for every solver, and how soft an unconverged solid is."""
import os
import statistics

import h5py
import matplotlib
import numpy as np

from runs import OUT, column, folder, line, publish, say, slowdown, table, unibody

matplotlib.use('Agg')
from matplotlib import pyplot  # noqa: E402

STEP, GRAVITY = .016, np.array([0, 0, -9.81])
BLOCKS = {'1,080': [6, 6, 5], '10,368': [12, 12, 12], '101,400': [26, 26, 25]}  # tetrahedra of a cube of 1 m
MODULI = (1e5, 5e8)  # Pa
# The total form is implicit Euler where it converges; it is refused where it is known to diverge.
SOLVERS = {'accelerated_jacobi': 'AJ', 'gauss_seidel': 'GS', 'gauss_seidel, form=total': 'GS total', 'jacobi': 'J'}
ITERATIONS = (5, 10, 20, 50, 100, 200, 500)


def thrown_block(cells, modulus, solver, iterations, more=()):
    """The settings of scenes/soft_cantilever.yaml that make it a cube of 1 m, held at one face and thrown downwards."""
    return ['solids[0].block.size=[1, 1, 1]', f'solids[0].block.cells={cells}', 'solids[0].velocity=[0, 0, -2]', 'solids[0].position=[0.5, 0.5, 0.5]',
            'solids[0].pins=[{within: {min: [0, 0, 0], max: [0, 1, 1]}}]', f'solids[0].youngs_modulus={modulus:.1e}', f'time.frame={STEP}',
            *(f'solver.{word}' for word in f'name={solver}'.split(', ')), f'solver.iterations={iterations}', 'solver.tolerance=0', *more]


def first_step(path):
    """Places at the end of the first step, where they would be without forces, and masses."""
    with h5py.File(os.path.join(path, 'frames.h5')) as file:
        free = file['bodies/motion'][:] == 0
        start = file['frames/000000']
        predicted = start['position'][:] + STEP * (start['velocity'][:] + STEP * GRAVITY)
        return file['frames/000001/position'][:][free], predicted[free], file['bodies/mass'][:][free]


def distance(places, exact, mass):
    return float(np.sqrt((mass[:, None] * (places - exact) ** 2).sum()))


def run(cells, modulus, solver, iterations, ranks, arguments, frames):
    path = folder('soft')
    rows = unibody('soft_cantilever', thrown_block(cells, modulus, solver, iterations, ['output.every=1']), path, ranks, arguments.core, frames)
    return first_step(path), 1e3 * statistics.median(column(rows, 'wall_solve')[1:])


def curve(name, cells, modulus, arguments):
    """(solver, ranks, iterations, ms a frame, relative distance to the converged step) of every setting."""
    say(f'{name} tetrahedra, E = {modulus:.0e}: newton')
    (exact, predicted, mass), newton_ms = run(cells, modulus, 'newton', 50, 1, arguments, 2)
    whole = distance(predicted, exact, mass)
    found = [('newton', 1, 1, newton_ms, 0.)]
    for solver in SOLVERS:
        if 'form=total' in solver and STEP * (2 + STEP * 9.8) * max(cells) > .5:
            continue  # refused: the nodes next to those that are held move by more than half an edge
        for iterations in ITERATIONS:
            for ranks in (1, 2) if solver in ('accelerated_jacobi', 'gauss_seidel') and iterations == 50 else (1,):
                say(f'{name} tetrahedra, E = {modulus:.0e}: {solver} {iterations} on {ranks}')
                (places, _, _), ms = run(cells, modulus, solver, iterations, ranks, arguments, arguments.frames or 4)
                found.append((solver, ranks, iterations, ms, distance(places, exact, mass) / whole))
    return found


def beside(cells, arguments):
    settings = thrown_block(cells, 1e5, 'accelerated_jacobi', 50)

    def one(core):
        rows = unibody('soft_cantilever', settings, folder(f'soft_{core}'), 1, core, arguments.frames or 10)
        return statistics.median(column(rows, 'wall_solve')[1:])

    return slowdown(one, arguments.core)


def draw(curves):
    figure, axes = pyplot.subplots(len(MODULI), len(curves) // len(MODULI), figsize=(4 * len(curves) // len(MODULI), 7), squeeze=False, sharey='row')
    for axis, ((name, modulus), found) in zip(axes.T.flat, curves.items()):
        for solver, short in SOLVERS.items():
            of = [(ms, error) for s, ranks, _, ms, error in found if s == solver and ranks == 1]
            if of:
                axis.loglog(*zip(*of), marker='.', label=short)
        axis.axvline(found[0][3], color='k', linestyle=':', label='Newton')
        axis.set(title=f'{name} tetrahedra, E = {modulus:.0e} Pa', xlabel='ms a step', ylabel='distance to the converged step')
        axis.grid(True, alpha=.3)
    axes[0][0].legend()
    figure.tight_layout()
    figure.savefig(os.path.join(OUT, 'soft.png'), dpi=100)


def soft(arguments):
    lines = table(['tetrahedra', 'E (Pa)', 'program', 'ranks', 'ms a step', 'ns a tetrahedron and iteration', 'distance to the converged step'])
    curves = {}
    for name, cells in list(BLOCKS.items())[:2 if arguments.quick else 3]:
        for modulus in MODULI:
            curves[name, modulus] = curve(name, cells, modulus, arguments)
            for solver, ranks, iterations, ms, error in curves[name, modulus]:
                each = 1e6 * ms / (iterations * 6 * np.prod(cells))
                lines.append(line(name, f'{modulus:.0e}', f'{SOLVERS[solver]} {iterations}' if solver in SOLVERS else 'Newton', ranks, f'{ms:.3g}',
                                  f'{each:.0f}' if solver in SOLVERS else '-', f'{error:.2g}' if error else '-'))
            publish('soft.md', lines, show=False)
        if os.cpu_count() > 1:
            slower = beside(cells, arguments)
            lines += ['', f'{name} tetrahedra: a step takes {slower:.2f} times as long while the other core does the same, so that 2 ranks could be '
                      f'{2 / slower:.2f} times as fast at best.', ''] + lines[:2]
    publish('soft.md', lines + [''] + softness(arguments))
    draw(curves)


def sag(settings, frames, arguments):
    """m, how far the free end's middle hangs below its place: the mean of the last quarter."""
    path = folder('softness')
    unibody('soft_cantilever', ['solids[0].youngs_modulus=5.0e8', 'solids[0].poissons_ratio=0.2', *settings], path, 1, arguments.core, frames)
    with h5py.File(os.path.join(path, 'frames.h5')) as file:
        names = sorted(file['frames'], key=int)
        x = file['frames/000000/position'][:]
        end = np.isclose(x[:, 0], x[:, 0].max())
        heights = [file[f'frames/{n}/position'][:][end, 2].mean() for n in names]
        return x[end, 2].mean() - statistics.mean(heights[-max(1, len(names) // 4):])


def softness(arguments):
    """Rubber of 5e8 Pa at 16 ms: an unconverged solid is softer than its modulus; what substeps and a warm start do to it."""
    exact = sag(['solver.name=newton', 'time.frame=1.0e+4'], 1, arguments)
    lines = table(['cantilever of rubber, E = 5e8 Pa, 16 ms', 'sag over the exact sag of the same mesh'])
    for solver in ('accelerated_jacobi', 'gauss_seidel'):
        for iterations, substeps in ((50, 1), (10, 5), (5, 10), (200, 1), (50, 10)):
            for share in ('0', 'auto', '0.5') if substeps == 1 and iterations == 50 else ('auto',):
                name = (
                    f'{SOLVERS[solver]} '
                    + (f'{substeps}x{iterations}' if substeps > 1 else str(iterations))
                    + {'0': ' cold', '0.5': ', share .5'}.get(share, '')
                )
                say(f'softness: {name}')
                found = sag([f'solver.name={solver}', f'solver.iterations={iterations}', f'time.substeps={substeps}', f'solver.warm_start={share}',
                             'output.every=1'], arguments.frames or 400, arguments)
                lines.append(line(name, f'{found / exact:.3g}'))
    return lines
