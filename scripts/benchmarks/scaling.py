"""How time and memory grow: two ranks against one beside what the two cores give, time a contact and iteration and bytes a sphere
against the number of spheres."""
import os
import statistics

from runs import column, folder, frame_ms, line, publish, say, slowdown, table, unibody

SOLVERS = {'GS 10': ['solver.name=gauss_seidel', 'solver.iterations=10'], 'GS 30': ['solver.name=gauss_seidel', 'solver.iterations=30'],
           'AJ 50': ['solver.name=accelerated_jacobi', 'solver.iterations=50']}
SPEED_UP = {'B5000': 1.7, 'spheres_100k': 1.85}  # at least
GROWTH = 1.2  # at most: time a contact and iteration, the largest over the smallest
BYTES = 2048  # under, a sphere


def spheres(count, columns, width):
    """scenes/spheres_5000.yaml in another width at the same depth, so that as many touch a sphere."""
    lattice = [f'bodies[1].lattice.count={count}', f'bodies[1].lattice.columns=[{columns}, {columns}]']
    return ['spheres_5000', [f'bodies[0].container.size=[{width}, {width}]', *lattice]]


# name: scene, its changes, frames until all lies on each other
SCENES = {'B5000': ['boxes_5000', [], 150], '5,000 spheres': [*spheres(5000, 13, 1.5), 90], '20,000 spheres': [*spheres(20000, 27, 3.04), 90],
          'spheres_100k': ['spheres_100k', [], 90]}


class Pile:
    """A scene that has come down: what is timed starts there, from the same state with every solver."""

    def __init__(self, name, arguments):
        self.name, self.core = name, arguments.core
        self.scene, self.changes, self.begin = SCENES[name]
        self.begin = arguments.frames or self.begin
        self.frames = self.begin + (6 if arguments.quick else 20)
        path = folder(f'scaling_{name.replace(" ", "_")}')
        say(f'{name}: {self.begin} frames until they lie')
        unibody(self.scene, self.changes + SOLVERS['GS 10'] + ['output.every=0', 'output.checkpoint_every=0'], path, 1, self.core, self.begin)
        self.start = os.path.join(path, 'checkpoint.h5')

    def rows(self, solver, ranks, core=None):
        """The report of the frames from there; the first one makes room and is left out."""
        core = self.core if core is None else core
        changes = self.changes + SOLVERS[solver] + ['output.every=0']
        return unibody(self.scene, changes, folder(f'scaling_{core}'), ranks, core, self.frames, self.start)[1:]

    def ms(self, solver, ranks, core=None):
        return frame_ms(self.rows(solver, ranks, core))


def nanoseconds(rows):
    """A contact and iteration, of the solve phase."""
    each = [1e9 * s / (c * i) for s, c, i in zip(column(rows, 'wall_solve'), column(rows, 'contacts'), column(rows, 'iterations')) if c * i > 0]
    return statistics.median(each)


def ranks_table(piles, arguments, verdicts):
    lines = table(['scene', 'solver', 'ms a frame: 1 rank', '2 ranks', 'speed-up', 'two runs of one rank at once'])
    for name, least in SPEED_UP.items():
        for solver in ('GS 10', 'AJ 50'):
            pairs = []
            for run in range(arguments.runs):
                say(f'{name} {solver} on 1 and 2 ranks, run {run + 1}/{arguments.runs}')
                pairs.append((piles[name].ms(solver, 1), piles[name].ms(solver, 2)))
            one, two = (statistics.median(ms) for ms in zip(*pairs))
            at_best = 2 / slowdown(lambda core, of=solver, pile=piles[name]: pile.ms(of, 1, core), arguments.core)
            lines.append(line(name, solver, f'{one:.1f}', f'{two:.1f}', f'{one / two:.2f}', f'{at_best:.2f}'))
            target = f'{name}, {solver}: 2 ranks at least {least} times as fast'
            verdicts.append((target, f'{one / two:.2f} of {at_best:.2f} at best', one / two >= least))
    return lines


def size_table(piles, arguments, verdicts):
    lines = table([
        'spheres', 'contacts a sphere', 'GS 10: ns a contact and iteration', 'of these the iterations alone', 'AJ 50',
        'bytes a sphere: GS', 'AJ'])
    each, most_bytes = {'GS 10': [], 'AJ 50': []}, 0
    for name in ('5,000 spheres', '20,000 spheres', 'spheres_100k'):
        found, nbytes = {solver: [] for solver in SOLVERS}, {}
        for run in range(arguments.runs):
            say(f'{name}: time a contact, run {run + 1}/{arguments.runs}')
            for solver, times in found.items():
                rows = piles[name].rows(solver, 1)
                times.append(nanoseconds(rows))
                contacts, nbytes[solver] = column(rows, 'contacts')[-1], column(rows, 'bytes_per_body')[-1]
        ns = {solver: statistics.median(times) for solver, times in found.items()}
        for solver, values in each.items():
            values.append(ns[solver])
        most_bytes = max(most_bytes, *nbytes.values())
        count = 100000 if name == 'spheres_100k' else int(name.split()[0].replace(',', ''))
        alone = (30 * ns['GS 30'] - 10 * ns['GS 10']) / 20
        lines.append(line(
            f'{count:,}', f'{contacts / count:.2f}', f'{ns["GS 10"]:.1f}', f'{alone:.1f}', f'{ns["AJ 50"]:.1f}',
            f'{nbytes["GS 10"]:.0f}', f'{nbytes["AJ 50"]:.0f}'))
    for solver, values in each.items():
        growth = max(values) / min(values)
        target = f'{solver}: time a contact and iteration within {GROWTH - 1:.0%} from 5,000 to 100,000 spheres'
        verdicts.append((target, f'{growth - 1:.0%}', growth <= GROWTH))
    verdicts.append((f'under {BYTES} bytes a sphere', f'{most_bytes:.0f}', most_bytes < BYTES))
    return lines


def scaling(arguments):
    piles = {name: Pile(name, arguments) for name in SCENES}
    verdicts = []
    lines = size_table(piles, arguments, verdicts) + ['']
    if os.cpu_count() > 1:
        lines += ranks_table(piles, arguments, verdicts) + ['']
    lines += table(['target', 'measured', '']) + [line(target, measured, 'met' if met else 'MISSED') for target, measured, met in verdicts]
    publish('scaling.md', lines)
