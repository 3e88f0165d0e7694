"""Figure 9: how the error falls with the iterations of a step, on 100 discs, in the paper's measure and in honest ones."""
import os
import statistics

import h5py
import numpy as np

from page import Section, Table, draw

TITLE = 'Figure 9: convergence of three solvers on 100 discs'
# The paper's accelerated Jacobi has Nesterov's momentum; `optimized` is the same solver with the other acceleration.
SOLVERS = {'gauss_seidel': 'GS', 'accelerated_jacobi': 'AJ', 'optimized': 'AJ optimized', 'jacobi': 'J'}
ACCELERATION = {'accelerated_jacobi': 'nesterov', 'optimized': 'optimized'}
# As the paper's: at position level, cold, all of a penetration taken out in one step, at any speed.
COLD = ['solver.stages=position', 'solver.warm_start=0', 'solver.recovery_time=0', 'solver.recovery_speed=0']
STEP, GRAVITY, RADIUS = .016, 9.8, .1
# Independent code, own trajectories, mu = .3: mean of err_k / max_k err at k = 1, 5, 10, 20, 50.
INDEPENDENT = {'GS': {1: .635, 5: .401, 10: .315, 20: .228, 50: .126}, 'J': {1: .949, 5: .895, 10: .869, 20: .835, 50: .760},
               'AJ': {1: .777, 5: .529, 10: .404, 20: .292, 50: .082}}


def solver_of(name, iterations):
    way = ['solver.order=sequential'] if name == 'gauss_seidel' else [f'solver.acceleration={ACCELERATION[name]}'] if name in ACCELERATION else []
    return COLD + way + [f'solver.name={"accelerated_jacobi" if name in ACCELERATION else name}', f'solver.iterations={iterations}']


def one_step(state, frame, name, iterations, estimate):
    """The wish for one step from a checkpoint; `estimate`: with the distance to the converged step."""
    return {'scene': 'planar_discs_100', 'settings': solver_of(name, iterations) + [f'time.frames={frame + 1}', 'output.checkpoint_every=-1'],
            'start': state, 'options': ('-error_estimate', str(frame + 1)) if estimate else ()}


def penetration(places):
    """L2 (m) of the penetrations of discs at `places` (m, [n][3]) with each other, the floor, and walls at x = 0 and 3 m."""
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)[np.triu_indices(len(places), 1)] - 2 * RADIUS
    gaps = np.concatenate([apart, places[:, 2] - RADIUS, places[:, 0] - RADIUS, 3 - places[:, 0] - RADIUS])
    return float(np.linalg.norm(np.minimum(gaps, 0)))


def before_solving(folder, frame):
    """The penetration (L2, m) where the step after `frame` would end without contacts."""
    with h5py.File(os.path.join(folder, 'frames.h5')) as file:
        moves, state = file['bodies/motion'][:] == 0, file[f'frames/{frame:06d}']
        return penetration(state['position'][:][moves] + STEP * (state['velocity'][:][moves] - [0, 0, STEP * GRAVITY]))


def states_of(maker, name, frames, own):
    """Folders with a checkpoint of each frame."""
    way = solver_of(name, 50) if own else solver_of('gauss_seidel', 300)
    return maker.at_once(
        maker.folder_of, [{'scene': 'planar_discs_100', 'settings': way + [f'output.every={frame}'], 'frames': frame} for frame in frames])


def errors(maker, counts, frames, own):
    """{solver: {k: ([penetration L2 of each sampled frame], [relative distance to the converged step], [natural residual (m)])}}; own: along each
    solver's own trajectory of 50 iterations, with the first alone, and also for k = 0; else from the states of a reference of 300."""
    result = {name: {k: ([], [], []) for k in counts} for name in SOLVERS}
    wishes, keys = [], []
    for name in SOLVERS:
        states = states_of(maker, name, frames, own)
        if own:
            result[name][0] = ([before_solving(folder, frame) for frame, folder in zip(frames, states)],)
        for frame, folder in zip(frames, states):
            for k in counts:
                wishes.append(one_step(os.path.join(folder, 'checkpoint.h5'), frame, name, k, not own))
                keys.append((name, k))
    for (name, k), run in zip(keys, maker.together(wishes)):
        for of, column in zip(result[name][k], ('penetration_l2', *(() if own else ('error_relative', 'natural_residual')))):
            of.append(run.column(column)[0])
    return result


def paper_measure(of_solver):
    """Mean over frames of err_k over the largest err of that frame's step: {k: value}; frames without penetration do not count."""
    counts = list(of_solver)
    frames = list(zip(*(of_solver[k][0] for k in counts)))
    frames = [f for f in frames if max(f) > 0]
    return {k: statistics.mean(f[n] / max(f) for f in frames) if frames else 0. for n, k in enumerate(counts)}


def passing(counts, ahead, behind):
    """The least of `counts` from which on `ahead` has no larger values than `behind`, both by count; None: at the last it has."""
    found = None
    for k in counts:
        if ahead[k] > behind[k]:
            found = None
        elif found is None:
            found = k
    return found


def told_passing(counts, measure, of_solver):
    k = passing(counts, of_solver['accelerated_jacobi'], of_solver['gauss_seidel'])
    if k is None:
        return f'{measure} Gauss-Seidel is ahead at {counts[-1]} iterations still'
    return f'{measure} accelerated Jacobi is no worse than Gauss-Seidel from {k} iterations on' if k > counts[0] else (
        f'{measure} accelerated Jacobi is nowhere worse than Gauss-Seidel')


def against_independent(paper, counts):
    """How far the paper's measure is from the independent code's, solver by solver."""
    told = []
    for name, short in SOLVERS.items():
        if short not in INDEPENDENT:
            continue
        ratios = [paper[name][k] / INDEPENDENT[short][k] for k in counts if k in INDEPENDENT[short]]
        told.append(f'{short} {min(ratios):.2f} to {max(ratios):.2f}')
    return f'Ours over its figures: {", ".join(told)}.'


def make(maker):
    counts = maker.pick((1, 3), (1, 5, 10, 20, 50), (1, 2, 3, 5, 7, 10, 14, 20, 28, 35, 50))
    frames = maker.pick((20,), tuple(range(5, 200, 20)), tuple(range(2, 200, 3)))  # of the paper's measure
    sampled = maker.pick((20,), tuple(range(25, 200, 35)), tuple(range(5, 200, 5)))
    own, same = errors(maker, counts, frames, True), errors(maker, counts, sampled, False)
    paper = {name: paper_measure(own[name]) for name in SOLVERS}
    distance, residual = ({name: {k: statistics.median(same[name][k][n]) for k in counts} for name in SOLVERS} for n in (1, 2))
    rows = [
        [
            short, k, paper[name][k], INDEPENDENT.get(short, {}).get(k), 1e3 * statistics.mean(own[name][k][0]),
            1e3 * statistics.mean(same[name][k][0]), distance[name][k], 1e3 * residual[name][k]]
        for name, short in SOLVERS.items()
        for k in counts]
    table = Table(
        'discs',
        f'penetration after k iterations of a step, means over {len(frames)} frames of each solver\'s own trajectory; from the same'
        f' states, {len(sampled)} frames',
        [
            'solver', 'k', "the paper's measure", 'the same, independent code', 'own trajectory, L2 (mm)', 'same states, L2 (mm)',
            'same states, distance to the converged step / of the prediction (median)',
            'same states, natural residual (mm, median)'],
        rows,
        'scripts/report discs',
    )

    def paint(axes):
        for name, short in SOLVERS.items():
            axes[0].plot([0, *counts], [paper[name][k] for k in (0, *counts)], marker='.', label=short)
            axes[1].semilogy(counts, [distance[name][k] for k in counts], marker='.', label=short)
            axes[2].semilogy(counts, [1e3 * residual[name][k] for k in counts], marker='.', label=short)
        axes[0].set(xlabel='iteration', ylabel='penetration / its own maximum', title="the paper's measure")
        axes[1].set(xlabel='iteration', ylabel='relative distance to the converged step', title='from the same states')
        axes[2].set(xlabel='iteration', ylabel='natural residual (mm)', title='from the same states')
        axes[0].legend()

    plot = draw(
        'discs', 'Convergence on 100 discs: in the paper\'s measure, and from the same states as distance to the converged step and as'
        ' natural residual', paint, wide=3, command='scripts/report discs')
    return Section(
        TITLE,
        [
            (
                'The paper divides each solver\'s penetration by its own maximum and follows each along its own trajectory: a'
                ' solver that pushes everything apart scores best. Beside it: absolute penetration, the same from equal states'
                ' (those of a run of 300 iterations), and the distance to the converged step and the natural residual, which'
                ' count friction and over-pushing too. Position level, cold, a penetration taken out in one step at any speed,'
                ' and a sequential Gauss-Seidel, as in the paper, whose accelerated Jacobi (AJ) has Nesterov\'s momentum; AJ'
                ' optimized is the same solver with `solver.acceleration: optimized`.'
            ),
            (
                'The maximum counts the state before the first iteration, as the independent code has it. ' + against_independent(paper, counts) +
                ' What is not the same: our Gauss-Seidel sweeps back and forth, which converges more slowly at first and is what'
                ' keeps stacks upright; our steps of k iterations are solves of their own, so that accelerated Jacobi ends each'
                ' without momentum; some frames are sampled, of a chaotic fall. With that code\'s own order, momentum and frames'
                ' our solvers give its figures (the test FallingDiscs).'
            ),
            ('; '.join([
                told_passing(counts, 'In the paper\'s measure', paper), told_passing(counts, 'by distance to the converged step', distance),
                told_passing(counts, 'by natural residual', residual)]) + f'. Jacobi\'s at {counts[-1]} iterations:' + ''.join(
                    f' {of["jacobi"][counts[-1]] / of["accelerated_jacobi"][counts[-1]]:.2g} times accelerated Jacobi\'s {measure}{end}'
                    for of, measure, end in ((paper, 'in the first', ','), (distance, 'in the second', ','), (residual, 'in the third', '.'))) +
                ' With the optimized acceleration these are' + ','.join(
                    f' {of["optimized"][counts[-1]] / of["accelerated_jacobi"][counts[-1]]:.2g}' for of in (paper, distance, residual)) +
                ' of accelerated Jacobi\'s.'),
        ],
        [table],
        [plot],
    )
