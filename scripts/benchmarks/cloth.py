"""Cloths: time a frame beside stretch for every solver; error against size at fixed work; stages beside contacts."""
import statistics

from runs import column, folder, frame_ms, line, publish, say, slowdown, table, unibody

# RMS and max stretch of the PositionBasedDynamics library (float, coloured Gauss-Seidel, no bending) on the same cloths, h and frames:
# (nodes a side, setting): figures of its own run on another machine, so that its errors can be compared and its times can't.
LIBRARY = {(50, '50'): (.0117, .26), (50, '10 substeps of 1'): (.0074, .16), (100, '50'): (.045, 1.7),
           (100, '10 substeps of 1'): (.0216, .81), (150, '50'): (.058, 3.2), (150, '10 substeps of 1'): (.048, 2.6)}
HALF_A_DIGIT = .005  # of the largest stretches above, which are given to two digits
ROUNDS = 9  # of the two sides of each verdict
NODE_FRAMES = 2_500_000  # of each run: less than half a second is still the start of its processes
SET_UP = 5  # of a step, in sweeps
DIAGONALS = ('alternating', 'both')  # the library's cloths, and the paper's
PAPER = {50: 2.33, 100: 1.45}  # Frâncu & Moldoveanu, tables 1 and 2: accelerated Jacobi on two cores against Gauss-Seidel on one


def hanging_cloth(nodes, diagonals, solver, iterations, more=()):
    """The settings of scenes/cloth_50.yaml that make it this cloth, held at two corners."""
    return [f'cloths[0].grid.nodes=[{nodes}, {nodes}]', f'cloths[0].pins=[{{node: [0, 0]}}, {{node: [{nodes - 1}, 0]}}]',
            f'cloths[0].links.diagonals={diagonals}', f'cloths[0].mass={nodes * nodes}', 'solver.stages=position', f'solver.name={solver}',
            f'solver.iterations={iterations}', *more]


def settings_of_cloth():
    """(name, solver, iterations a step, steps a frame, share of the old multipliers)."""
    for solver, short in (('gauss_seidel', 'GS'), ('accelerated_jacobi', 'AJ'), ('jacobi', 'J')):
        for total in (10, 20, 50) if solver != 'accelerated_jacobi' else (8, 10, 12, 14, 16, 18, 20, 22, 26, 30, 34, 40, 50):
            yield f'{short} {total}', solver, total, 1, 'auto'
        for substeps, each in ((5, 2), (10, 1), (10, 2), (10, 5)):
            yield f'{short} {substeps}x{each}', solver, each, substeps, 'auto'
    for total in (10, 20, 50):  # as the library: Gauss-Seidel, cold
        yield f'GS {total} cold', 'gauss_seidel', total, 1, '0'
    yield 'GS 10x1 cold', 'gauss_seidel', 1, 10, '0'


def stretch_of(rows):
    """RMS and max of the relative stretch: medians of the last 100 frames."""
    names = [next(h for h in rows[0] if h.startswith(kind)) for kind in ('stretch_rms', 'stretch_max')]
    return [statistics.median(float(row[name]) for row in rows[-100:]) for name in names]


def link_count(nodes, diagonals):
    return 2 * nodes * (nodes - 1) + (2 if diagonals == 'both' else 1) * (nodes - 1) ** 2


def measure(nodes, diagonals, arguments):
    """Each setting on 1 and 2 ranks, all of them in turn as often as asked; medians."""
    entries = [(setting, ranks) for setting in settings_of_cloth() for ranks in (1, 2)]
    found = {}
    for run in range(arguments.runs):
        for (name, solver, iterations, substeps, warm), ranks in entries:
            say(f'cloth of {nodes} x {nodes}, {diagonals}, {name} on {ranks}, run {run + 1}/{arguments.runs}')
            more = ['output.every=0', f'time.substeps={substeps}', f'solver.warm_start={warm}']
            rows = unibody('cloth_50', hanging_cloth(nodes, diagonals, solver, iterations, more), folder('cloth'), ranks, arguments.core,
                           arguments.frames)
            solve = 1e9 * statistics.median(column(rows, 'wall_solve')) / (link_count(nodes, diagonals) * iterations * substeps)
            found.setdefault((name, ranks), []).append((frame_ms(rows), solve, *stretch_of(rows)))
    return {key: [statistics.median(values) for values in zip(*runs)] for key, runs in found.items()}


class InTurn:
    """Short runs of what is to be compared, in turn: a machine whose speed changes from minute to minute is then the same to all."""

    def __init__(self, nodes, arguments):
        self.nodes, self.core = nodes, arguments.core
        self.settings = {name: rest for name, *rest in settings_of_cloth()}

    def ms(self, name, ranks, core=None):
        """Median of a frame."""
        solver, iterations, substeps, warm = self.settings[name]
        more = ['output.every=0', f'time.substeps={substeps}', f'solver.warm_start={warm}']
        core = self.core if core is None else core
        return frame_ms(unibody('cloth_50', hanging_cloth(self.nodes, 'alternating', solver, iterations, more), folder(f'cloth_{core}'), ranks, core,
                                max(100, NODE_FRAMES // self.nodes**2)))

    def pair(self, ours, against):
        """Two (name, ranks): the median ms of each, and the median of their ratios."""
        say(f'cloth of {self.nodes} x {self.nodes}: {ours} and {against}, {ROUNDS} rounds in turn')
        rounds = [(self.ms(*ours), self.ms(*against)) for _ in range(ROUNDS)]
        return [statistics.median(values) for values in zip(*((a, b, a / b) for a, b in rounds))]

    def best_speed_up(self, name):
        """On two ranks, as far as the two cores go: of two runs on one rank at once, each on a core, over one alone."""
        say(f'cloth of {self.nodes} x {self.nodes}: two runs of {name} at once, {ROUNDS} rounds')
        return statistics.median(2 / slowdown(lambda core: self.ms(name, 1, core), self.core) for _ in range(ROUNDS))


def cloth(arguments):
    lines = table([
        'cloth', 'links', 'program', 'ranks', 'ms a frame', 'ns a link and iteration', 'RMS stretch', 'max stretch',
        'speed-up on 2 ranks'])
    verdicts = table(['cloth', '', 'ours', 'its ms', 'against', 'its ms', 'ratio (or ns)', 'asked for', ''])
    for nodes in arguments.nodes or ((50, 100) if arguments.quick else (50, 100, 150)):
        for diagonals in DIAGONALS:
            if diagonals == 'both' and arguments.quick:
                continue
            found = measure(nodes, diagonals, arguments)
            for (name, ranks), (ms, each, rms, most) in found.items():
                gain = f'{found[name, 1][0] / ms:.2f}' if ranks == 2 else ''
                lines.append(line(f'{nodes} x {nodes}', f'{link_count(nodes, diagonals)} ({diagonals})', name, ranks, f'{ms:.2f}', f'{each:.1f}',
                                  f'{rms:.4f}', f'{most:.3f}', gain))
            if diagonals == 'alternating' and (nodes, '50') in LIBRARY:
                verdicts += compare(nodes, found, InTurn(nodes, arguments))
            publish('cloth.md', lines + [''] + verdicts)


def cheapest(found, family, rms, most):
    """The setting of a family that stretches no more than that for the least work, or None. Work is counted: times of minutes apart would
    make the choice one of chance."""
    work = {name: substeps * (iterations + SET_UP) for name, _, iterations, substeps, _ in settings_of_cloth()}
    fit = [(work[name], ms, name) for (name, ranks), (ms, _, r, m) in found.items() if ranks == 1 and name.startswith(family) and r <= rms and m <= most]
    return min(fit)[-1] if fit else None


def compare(nodes, found, timed):
    """Lines of verdicts on the cloth with alternating diagonals; found: (name, ranks) -> (ms, ns a link and iteration, RMS, max)."""
    lines = []

    def told(what, ours, ms, against, against_ms, figure, least, most):
        """The figure is to be at least or at most that, where one is given."""
        asked = f'<= {most:.3g}' if most else f'>= {least:.3g}' if least else ''
        met = figure is not None and (figure <= most if most else figure >= least if least else True)
        cells = ['-' if value is None else f'{value:.3g}' for value in (ms, against_ms, figure)]
        lines.append(line(f'{nodes} x {nodes}', what, ours or 'none', cells[0], against, cells[1], cells[2], asked,
                          ('met' if met else 'MISSED') if asked else ''))

    def cheaper(what, candidates, ranks, against, most=None):
        """Of the candidates' names the one that takes the least of the other's time."""
        own = found[against, 1][0], found[against, 1][0], 1.  # of what is compared with itself
        timings = [(name, *(own if (name, ranks) == (against, 1) else timed.pair((name, ranks), (against, 1)))) for name in candidates if name]
        ours, ms, against_ms, ratio = min(timings, key=lambda timing: timing[-1], default=(None, None, found[against, 1][0], None))
        told(what, ours, ms, against, against_ms, ratio, None, most)

    def of_both(rms, most):
        return [cheapest(found, family, rms, most) for family in ('AJ', 'GS')]

    for name in ('GS 10', 'GS 20', 'GS 50'):
        _, _, rms, most = found[name, 1]
        cheaper('AJ on 2 ranks with no more stretch than GS on 1 (asked for: the paper)', [cheapest(found, 'AJ ', rms, most)], 2, name,
                1 / PAPER[nodes] if nodes in PAPER else None)
    # The library's times are another machine's: what stands for them is our GS with the same cold sweeps over the same links.
    for setting, ours, share in (('50', 'GS 50 cold', .6 if nodes == 150 else .5), ('10 substeps of 1', 'GS 10x1 cold', 1)):
        rms, most = LIBRARY[nodes, setting]
        if nodes == 150:  # where only the root mean square is asked for
            most = float('inf')
        text = f'at the stretch of the library at {setting}: {rms}' + (f', {most}' if most < float('inf') else '')
        cheaper(text, of_both(rms, most + HALF_A_DIGIT), 1, ours, share)
    if nodes == 150:
        cheaper('RMS stretch <= .6', of_both(.6, float('inf')), 1, 'GS 10 cold', 1)
    if nodes == 50:  # small enough for the cache
        told('ns a link and iteration in cache', 'AJ 50', found['AJ 50', 1][0], '', None, found['AJ 50', 1][1], None, 8)
    two, one, ratio = timed.pair(('AJ 50', 2), ('AJ 50', 1))
    told(f'speed-up on 2 ranks, of {timed.best_speed_up("AJ 50"):.2f} that two runs at once have', 'AJ 50', two, 'AJ 50 on 1 rank', one, 1 / ratio, 1.8, None)
    return lines


def sizes(arguments):
    """Stretch against the number of nodes at the same work a link, 50 iterations a frame: what substeps and a warm start each do."""
    variants = [
        ('AJ 50 cold', 'accelerated_jacobi', 50, 1, '0'), ('AJ 50', 'accelerated_jacobi', 50, 1, 'auto'),
        ('AJ 50, share .5', 'accelerated_jacobi', 50, 1, '0.5'), ('AJ 5x10', 'accelerated_jacobi', 10, 5, 'auto'),
        ('AJ 10x5', 'accelerated_jacobi', 5, 10, 'auto'), ('GS 50 cold', 'gauss_seidel', 50, 1, '0'),
        ('GS 50', 'gauss_seidel', 50, 1, 'auto'), ('GS 10x5', 'gauss_seidel', 5, 10, 'auto'),
        ('GS 10x5 cold', 'gauss_seidel', 5, 10, '0'), ('GS 50x1', 'gauss_seidel', 1, 50, 'auto'),
        ('GS 50x1 cold', 'gauss_seidel', 1, 50, '0'), ('J 50', 'jacobi', 50, 1, 'auto')]
    sides = (25, 50, 100) if arguments.quick else (25, 50, 100, 200)
    lines = table(['50 iterations a frame'] + [f'{n} x {n}: RMS / max' for n in sides])
    for name, solver, iterations, substeps, warm in variants:
        cells = []
        for nodes in sides:
            say(f'sizes: {name}, {nodes} x {nodes}')
            more = ['output.every=0', f'time.substeps={substeps}', f'solver.warm_start={warm}']
            rows = unibody(
                'cloth_50', hanging_cloth(nodes, 'alternating', solver, iterations, more), folder('sizes'), 1, arguments.core,
                arguments.frames)
            cells.append('{:.4f} / {:.3f}'.format(*stretch_of(rows)))
        lines.append(line(name, *cells))
    publish('sizes.md', lines)


def stages(arguments):
    """What a velocity stage beside contacts does to cloths: medians of the last 20 frames."""
    lines = table(['scene, solver', 'stages', 'penetration RMS / max (mm)', 'stretch RMS / max'])
    for scene in ('boxes_on_cloth', 'cloth_stack'):
        for solver in ('accelerated_jacobi', 'gauss_seidel'):
            for kind in ('two', 'joint', 'position'):
                say(f'stages: {scene} {solver} {kind}')
                more = ['output.every=0', f'solver.name={solver}', 'solver.iterations=50', f'solver.stages={kind}']
                rows = unibody(scene, more, folder('stages'), 1, arguments.core, arguments.frames)[-20:]
                depth = [1e3 * statistics.median(column(rows, f'penetration_{k}')) for k in ('rms', 'max')]
                names = [next(h for h in rows[0] if h.startswith(kind)) for kind in ('stretch_rms', 'stretch_max')]
                stretch = [statistics.median(float(row[name]) for row in rows) for name in names]
                lines.append(line(f'{scene}, {solver}', kind, '{:.2g} / {:.2g}'.format(*depth), '{:.3f} / {:.2f}'.format(*stretch)))
    publish('stages.md', lines)
