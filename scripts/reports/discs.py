"""Figure 9: how the error falls with the iterations of a step, on 100 discs, in the paper's measure and in honest ones."""
import os
import statistics

from page import Section, Table, draw

TITLE = 'Figure 9: convergence of three solvers on 100 discs'
SOLVERS = {'gauss_seidel': 'GS', 'accelerated_jacobi': 'AJ', 'jacobi': 'J'}
COLD = ['solver.stages=position', 'solver.warm_start=0']
# Independent code, own trajectories, mu = .3 (notes' table): mean of err_k / max_k err at k = 1, 5, 10, 20, 50.
INDEPENDENT = {'GS': {1: .635, 5: .401, 10: .315, 20: .228, 50: .126}, 'J': {1: .949, 5: .895, 10: .869, 20: .835, 50: .760},
               'AJ': {1: .777, 5: .529, 10: .404, 20: .292, 50: .082}}


def solver_of(name, iterations):
    return COLD + [f'solver.name={name}', f'solver.iterations={iterations}']


def one_step(state, frame, name, iterations):
    """The wish for one step from a checkpoint, with the distance to the converged step."""
    return {'scene': 'planar_discs_100', 'settings': solver_of(name, iterations) + [f'time.frames={frame + 1}', 'output.checkpoint_every=-1'],
            'start': os.path.join(state), 'options': ('-error_estimate', str(frame + 1))}


def errors(maker, counts, frames, own):
    """{solver: {k: ([penetration L2 of each sampled frame], [relative distance to the converged step], [natural residual (m)])}}; own: along each
    solver's own trajectory of 50 iterations, else from the states of a reference of 300."""
    wishes, keys = [], []
    for name in SOLVERS:
        for frame in frames:
            state = maker.state('planar_discs_100', solver_of(name, 50) if own else solver_of('gauss_seidel', 300), frame)
            for k in counts:
                wishes.append(one_step(state, frame, name, k))
                keys.append((name, k))
    result = {name: {k: ([], [], []) for k in counts} for name in SOLVERS}
    for (name, k), run in zip(keys, maker.together(wishes)):
        for of, column in zip(result[name][k], ('penetration_l2', 'error_relative', 'natural_residual')):
            of.append(run.column(column)[0])
    return result


def paper_measure(of_solver):
    """Mean over frames of err_k over the largest err of that frame's step: {k: value}; frames without penetration do not count."""
    counts = list(of_solver)
    frames = list(zip(*(of_solver[k][0] for k in counts)))
    frames = [f for f in frames if max(f) > 0]
    return {k: statistics.mean(f[n] / max(f) for f in frames) if frames else 0. for n, k in enumerate(counts)}


def make(maker):
    counts = maker.pick((1, 3), (1, 2, 5, 10, 20, 50), (1, 2, 3, 5, 7, 10, 14, 20, 28, 35, 50))
    frames = maker.pick((20,), tuple(range(25, 200, 35)), tuple(range(5, 200, 5)))
    own, same = errors(maker, counts, frames, True), errors(maker, counts, frames, False)
    rows = []
    for name, short in SOLVERS.items():
        relative = paper_measure(own[name])
        for k in counts:
            rows.append([
                short, k, relative[k], INDEPENDENT[short].get(k), 1e3 * statistics.mean(own[name][k][0]),
                1e3 * statistics.mean(same[name][k][0]), statistics.median(same[name][k][1]),
                1e3 * statistics.median(same[name][k][2])])
    table = Table(
        'discs',
        f'penetration after k iterations of a step, means over {len(frames)} frames',
        [
            'solver', 'k', "the paper's measure", 'the same, independent code', 'own trajectory, L2 (mm)', 'same states, L2 (mm)',
            'same states, distance to the converged step / of the prediction (median)',
            'same states, natural residual (mm, median)'],
        rows,
        'scripts/report discs',
    )

    def paint(axes):
        for name, short in SOLVERS.items():
            relative = paper_measure(own[name])
            axes[0].plot(counts, [relative[k] for k in counts], marker='.', label=short)
            axes[1].semilogy(counts, [statistics.median(same[name][k][1]) for k in counts], marker='.', label=short)
            axes[2].semilogy(counts, [1e3 * statistics.median(same[name][k][2]) for k in counts], marker='.', label=short)
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
                ' count friction and over-pushing too. Position level, cold, as in the paper.'
            ),
            (
                'Our maximum is over the iterations sampled, from k = 1 on; the independent code counts the state before the'
                ' first iteration too, so its first values are lower. Why the result agrees in kind: accelerated Jacobi passes'
                ' Gauss-Seidel at some 40 iterations, Jacobi stays far behind.'
            ),
        ],
        [table],
        [plot],
    )
