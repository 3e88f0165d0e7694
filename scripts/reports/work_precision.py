"""Work against precision: how far a frame ends from its converged steps, and two frames from a fine-step reference, for the time they take."""
from dataclasses import dataclass, field, replace

from fronts import Curve, choice, costs, least, one_for_all, standing
from page import Section, Table, draw
from maker import Failed
from poses import distance_of_last
from runs import COMMON, DEFAULTS, report_rows

TITLE = 'Work against precision'
SOLVERS = {'accelerated_jacobi': 'AJ', 'gauss_seidel': 'GS', 'newton': 'Newton'}
LEVELS = (1e-2, 1e-3, 1e-4)  # of a body's size
WINDOW = 2                   # frames to the comparison with the fine reference; a few more are run for their time
VARIANTS = {
    'position stage alone': ['solver.stages=position'], 'cold': ['solver.stages=position', 'solver.warm_start=0'],
    'warm .5': ['solver.stages=position', 'solver.warm_start=0.5'],
    'joint': ['solver.stages=together'], 'velocity share .9': ['solver.velocity_share=0.9'], 'direct': ['solver.joints=direct'],
    'as shipped': [*DEFAULTS, 'solver.iterations=auto'],
    '': []}


@dataclass
class Setting:
    solver: str
    iterations: int
    substeps: int = 1
    ranks: int = 1
    variant: str = ''

    def name(self):
        return (
            SOLVERS[self.solver]
            + (f' {self.iterations}' if self.iterations else '')
            + (f' x {self.substeps} substeps' if self.substeps > 1 else '')
            + (f', {self.variant}' if self.variant else '')
            + (' on 2 ranks' if self.ranks > 1 else '')
        )

    def values(self):
        count = [f'solver.iterations={self.iterations}'] if self.iterations else []
        return [f'solver.name={self.solver}', *count, f'time.substeps={self.substeps}', *VARIANTS[self.variant]]


DEFAULT = Setting('accelerated_jacobi', 50)  # the program's in scenes of more than a hundred bodies, which the tests hold against it
SHIPPED = replace(DEFAULT, variant='as shipped')         # with what the report sets for all runs taken back
ERROR_BARS = (DEFAULT, Setting('gauss_seidel', 50))  # whose own word on their error is held against the distance found


@dataclass
class Case:
    """A scene, a state of it, and the ways to what is right there. `careful`: how that state is reached. `converged(S)`: independent
    ways to the converged frame of S substeps; one alone tells by its residual how far it is. `fine`, `finest`: the fine reference,
    which has that many substeps a frame."""
    scene: str
    size: float            # m, of a body, element or link
    second: str            # column of the other error
    careful: Setting
    fine: Setting
    settings: list = field(default_factory=list)
    frame: int = 60        # of the state from which all settings start
    finest: int = 512
    rows: str = 'contacts'  # or 'joints', 'links', 'solid', 'coupled': what is solved for

    def converged(self, maker, substeps):
        a = max(maker.pick(400, 20000, 20000) // substeps, 200)
        if self.rows == 'joints':
            return Setting('accelerated_jacobi', 30, substeps, 1, 'direct'), Setting('accelerated_jacobi', a, substeps)
        if self.rows == 'links':
            return (Setting('newton', 0, substeps),)
        if self.rows in ('solid', 'coupled'):
            return Setting('accelerated_jacobi', max(a // 10, 100), substeps), Setting('gauss_seidel', max(a // 10, 100), substeps)
        return Setting('accelerated_jacobi', a, substeps, 1, 'joint'), Setting('gauss_seidel', a, substeps, 1, 'joint')

    def variants(self, size):
        """Other shares of the old multipliers than the default third; solids have none by default, and nothing to spare."""
        return (['position stage alone'] if self.rows == 'contacts' else []) + ['cold'] + (
            ['warm .5'] if size == 'full' and self.rows != 'solid' else [])


def cases(maker):
    def pile(scene, size, settings=(), frame=60):
        return Case(
            scene, size, 'penetration_rms', Setting('accelerated_jacobi', maker.pick(20, 200, 500), 4),
            Setting('accelerated_jacobi', 100, maker.pick(16, 512, 1024), 1, 'joint'), list(settings), frame,
            maker.pick(16, 512, 1024))

    def soft(scene, size, second, rows, careful, settings=(), frame=30, finest=512):
        return Case(scene, size, second, careful, Setting('accelerated_jacobi', 60, finest), list(settings), frame, finest, rows)

    newton = Setting('newton', 0, 2)
    if maker.size == 'tiny':
        return {
            'boxes': pile('boxes_500', 0.12, ['bodies[1].lattice.count=20'], 10),  # they have just landed
            'cloth': soft(
                'cloth_50',
                0.2,
                'stretch_rms',
                'links',
                newton,
                [
                    'cloths[0].grid.nodes=[8, 8]', 'cloths[0].pins=[{node: [0, 0]}, {node: [7, 0]}]',
                    'cloths[0].links.stiffness=1.0e+4'],
                5,
                16,
            ),
        }
    count = 'bodies[1].lattice.count'
    # Jointed figures on a hanging cloth: links, joints and contacts at once. The links are elastic: inextensible ones, stretched by a long
    # step, jump in a short one.
    figures = 'bodies[1]={ragdolls: {count: 2, columns: [2, 1], spacing: [1.2, 1.2, 1.5]}, density: 100, position: [0, 0, 3.2]}'
    coupled = soft(
        'boxes_on_cloth', 0.1, 'joint_drift_rms', 'coupled', Setting('accelerated_jacobi', 100, 4),
        [figures, 'cloths[0].links.stiffness=1.0e+4'], 34)
    return {
        'boxes': pile(maker.pick(0, 'boxes_500', 'boxes_2000'), 0.12),
        'spheres': pile('spheres_5000', 0.1, maker.pick([], [f'{count}=1000'], [])),
        'cloth': soft('cloth_50', 10 / 49, 'stretch_rms', 'links', newton, ['cloths[0].links.stiffness=1.0e+4']),
        'soft block': soft(
            'soft_block_on_floor', 0.5 / 8, 'strain_max', 'solid', Setting('accelerated_jacobi', 160, 4), frame=25, finest=256
        ),
        'chain': Case(
            'chain_heavy_ball', 0.1, 'joint_drift_rms', Setting('accelerated_jacobi', 20, 4, 1, 'direct'),
            Setting('accelerated_jacobi', 4, 1024, 1, 'direct'), ['output.joints=false'], 60, 1024, 'joints'),
        'mixed': pile('mixed_pile', 0.2, maker.pick([], ['bodies[1].pile.count=300'], [])),
    } | maker.pick({}, {}, {'coupled': coupled})


def settings_of(maker, case):
    """The curve on one rank, and some of the rest; finer in the full report."""
    found = [DEFAULT]
    for solver in ('accelerated_jacobi', 'gauss_seidel'):
        if maker.size == 'tiny':
            found += [Setting(solver, k, s) for k in (4, 40) for s in (1, 4)]
            continue
        counts = maker.pick((), (10, 40, 160, 640), (5, 10, 20, 50, 100, 200, 500, 2560))
        found += [Setting(solver, k) for k in counts]
        found += [Setting(solver, k, s) for s in maker.pick((), (4,), (2, 4, 8)) for k in counts[:maker.pick(0, 3, -2)]]
        found += [Setting(solver, k, s) for s, k in ((16, 10), (16, 40), (64, 10), (64, 40), (256, 4))]
        found += [
            Setting(solver, k, s, 1, v)
            for v in case.variants(maker.size)
            for k in maker.pick((), (40,), counts[:-1])
            for s in maker.pick((), (1,), (1, 4))
        ]
        found += [Setting(solver, k, s, 1, 'joint') for k, s in ((640, 1), (2560, 1), (640, 4)) if case.rows == 'contacts']
        found += [Setting(solver, k, 1, 1, 'velocity share .9') for k in (40, 160) if case.rows == 'contacts']
        found += [Setting(solver, 2560)] if case.rows in ('links', 'solid') and maker.size == 'quick' else []
    if case.rows == 'joints' and maker.size != 'tiny':
        found += [Setting('accelerated_jacobi', k, s, 1, 'direct') for k, s in ((2, 1), (4, 1), (2, 4), (2, 16), (2, 64), (2, 256))]
    if case.rows == 'links':
        found += [Setting('newton', 0), Setting('newton', 0, 4)]
    # On two ranks the bits are the same: only the time is new.
    twice = {'tiny': (), 'quick': (50, 640), 'full': (20, 50, 100, 500)}[maker.size]
    unique = [s for n, s in enumerate(found) if s not in found[:n]]
    return unique + [replace(s, ranks=2) for s in unique if s.iterations in twice and s.substeps <= 4 and s.variant in ('', 'joint')]


def reference(maker, case, setting, last, state):
    return maker.folder_of(case.scene, case.settings + setting.values() + [f'output.every={last}'], last, start=state)


def known_to(ways):
    """How far the last frame of the first folder is known (m): its distance from that of the second, or, where it is alone, its residual."""
    return distance_of_last(ways[1], ways[0]) if len(ways) > 1 else float(report_rows(ways[0])[-1]['natural_residual (m)'])


def measure(maker, case):
    """[(setting, ms a frame, distance of a frame to its converged steps, distance to the fine reference, second error)], distances in m;
    how far these two are known; and [(setting, its own estimate, how far that is solved, the distance found)] in m."""
    state = maker.state(case.scene, case.settings + case.careful.values(), case.frame)
    wanted = settings_of(maker, case)
    converged, known = {}, [0., 0.]
    for substeps in sorted({s.substeps for s in wanted if s.substeps <= 16}):
        check = substeps <= 4  # with finer steps a step is solved with ease
        ways = [reference(maker, case, way, case.frame + 1, state) for way in case.converged(maker, substeps)[:None if check else 1]]
        converged[substeps] = ways[0]
        known[0] = max(known[0], known_to(ways) if check else 0)
    fine = reference(maker, case, case.fine, case.frame + WINDOW, state)
    known[1] = distance_of_last(reference(maker, case, replace(case.fine, substeps=case.finest // 2), case.frame + WINDOW, state), fine)
    found = []
    for s in wanted:
        alone = next((f for f in found if s.ranks > 1 and f[0] == replace(s, ranks=1)), None)
        settings = case.settings + s.values() + [f'time.frames={case.frame + maker.pick(WINDOW, 4, 6)}']
        if alone is None:
            settings.append('output.every=1')
        look = ['away', *([converged[s.substeps]] if s.substeps in converged else []), fine]
        try:
            run = maker.run(case.scene, settings, s.ranks, start=state, look=look if alone is None else None)
        except Failed as fault:  # a setting that this scene can't take
            maker.say(f'{s.name()}: {str(fault).splitlines()[-1]}')
            continue
        errors = alone[2:] if alone else (run.seen[0] if len(run.seen) > 1 else None, run.seen[-1], run.column(case.second)[-1])
        found.append((s, run.frame_ms(1), *errors))
    bars = []
    for s in ERROR_BARS:
        settings = case.settings + s.values() + [f'time.frames={case.frame + 1}', 'output.every=1']
        run = maker.run(case.scene, settings, 1, ('-error_estimate', str(case.frame + 1)), state, ['away', converged[1]])
        bars.append((s, run.column('error_estimate')[0], run.column('error_reference_residual')[0], run.seen[0]))
    return found, known, bars


ERRORS = ('the solver', 'solver and step')
LEAST_DRAWN = 1e-12  # of a body's size, on logarithmic axes


def about_defaults(curves):
    """A table of where the defaults stand on each curve, one of the settings that suit all scenes, and a sentence on both."""
    rows = [[c.scene, c.error, *found] for c in curves if (found := standing(c, DEFAULT))]
    on = sum(row[4] for row in rows)
    table = Table(
        'defaults',
        (
            f'The defaults ({DEFAULT.name()}) on each curve, one rank, and what has no more error in less time. On the front: nothing'
            ' is more than a tenth faster with no more error'
        ),
        [
            'scene', 'error of', 'ms a frame', 'error / size', 'on the front', 'fastest with no more error', 'its ms', 'its ms / these',
            'least error in no more time', 'its error / this'],
        rows,
        'scripts/report work_precision',
    )
    wishes = [(c, level) for c in curves for level in LEVELS if c.known <= level * c.size]
    targets = [one_setting_row(error, f'{level:g}', [w for w in wishes if w[0].error == error and w[1] == level])
               for error in ERRORS for level in LEVELS]
    targets.append(one_setting_row('either', 'each of these', wishes))
    lines = [f'The defaults ({DEFAULT.name()}, one substep) are on the front in {on} of {len(rows)} cases; ' +
             '; '.join(f'for {name}, {standing_text(row)}' for row in rows if not row[4] for name in [f'{row[0]} ({row[1]})']) + '.']
    choices = Table(
        'one_setting',
        (
            'One setting for all scenes: which of those that run in all of them ends within a share of a body\'s size in most, at'
            ' what time over each scene\'s cheapest (geometric mean), and what the defaults do. Only scenes whose reference is'
            ' known so well'
        ),
        [
            'error of', 'within', 'scenes', 'best setting', 'reached in', 'its time / the cheapest', 'defaults: reached in',
            'their time / the cheapest'],
        targets,
        'scripts/report work_precision',
    )
    return table, choices, lines


def one_setting_row(error, within, wishes):
    """What one setting can do for the wishes (curve, level), and what the defaults do."""
    best = one_for_all(wishes) if wishes else None
    return [error, within, len(wishes), *((best[0].name(), *best[1:]) if best else (None, None, None)), *costs(wishes, DEFAULT)]


def standing_text(row):
    return f'{row[5]} has no more error in {row[7]:.2g} of the time, and {row[8]} has {row[9]:.2g} of the error in no more'


def about_error_bars(everything):
    wrong = [f'{name} with {s.name()} ({own / case.size:.1g} said, {off / case.size:.1g} found; its reference was solved to {left / case.size:.1g})'
             for name, (case, _, _, told) in everything.items() for s, own, left, off in told if not off / 2 <= own <= 2 * off]
    return ('What a run says of itself (`-error_estimate`) is within a factor of two of the distance found' +
            (' but for ' + '; '.join(wrong) + ': the residual of its reference, far from 0, is the sign of it.' if wrong else ' everywhere.'))


def paint_curve(axis, curve):
    """Errors over times on one rank: each solver by its substeps, all settings, their front, the defaults, and what is known."""
    def places(points, least_share=0.):
        return [(p[1], max(p[curve.which] / curve.size, least_share)) for p in points]

    alone = curve.measured(1)
    for solver, colour in (('accelerated_jacobi', 'C0'), ('gauss_seidel', 'C1')):
        for substeps, style in ((1, '-'), (4, '--'), (16, ':')):
            of = [p for p in alone if p[0].solver == solver and p[0].substeps == substeps and not p[0].variant]
            label = SOLVERS[solver] + (f', {substeps} substeps' if substeps > 1 else '')
            if of:
                axis.loglog(*zip(*sorted(places(of))), style, marker='.', color=colour, label=label)
    front = [p for p in alone if least(curve, p[1], 1) is p]
    axis.loglog(*zip(*places(alone, LEAST_DRAWN)), '.', color='.7', zorder=0)
    axis.loglog(*zip(*sorted(places(front, LEAST_DRAWN))), color='.5', linewidth=4, alpha=.4, zorder=0, label='front of all settings')
    if own := places([p for p in alone if p[0] == DEFAULT]):
        axis.loglog(*zip(*own), 'k*', markersize=10, label='the defaults')
    axis.axhline(max(curve.known / curve.size, LEAST_DRAWN), color='C3', linewidth=.8, label='reference known to')
    axis.set(title=curve.scene, xlabel='ms a frame', ylabel='distance / size')


def make(maker):
    plan = cases(maker)
    maker.expect(sum(len(settings_of(maker, case)) + 2 * len(ERROR_BARS) for case in plan.values()))
    everything = {name: (case, *measure(maker, case)) for name, case in plan.items()}
    curves = [
        Curve(name, case.size, error, 2 + k, known[k], found)
        for name, (case, found, known, _) in everything.items()
        for k, error in enumerate(ERRORS)
    ]
    rows = []
    for name, (case, found, _, _) in everything.items():
        for s, ms, step, away, second in found:
            setting = [SOLVERS[s.solver], s.iterations or None, s.substeps, s.ranks, s.variant or 'default']
            errors = [None if step is None else step / case.size, away / case.size]
            rows.append([name, *setting, ms, *errors, case.second, second])
    table = Table(
        'work_precision',
        'all settings start from the same state; distances over the size of a body (link, cell)',
        [
            'scene', 'solver', 'iterations', 'substeps', 'ranks', 'variant', 'ms a frame', 'to the converged step',
            'to the fine-step reference', 'other error', 'its value'],
        rows,
        'scripts/report work_precision',
    )
    heading = ['scene', 'size (m)', 'error of', 'known to', *(f'{level:g}' for level in LEVELS)]
    chosen = [[c.scene, f'{c.size:.3g}', c.error, f'{c.known / c.size:.1g}', *(choice(c, level) for level in LEVELS)] for c in curves]
    settings = Table(
        'settings',
        (
            'The cheapest setting that ends within a share of a body\'s size. The solver: distance of a frame of 16 ms to its'
            ' converged steps; solver and step: distance after two frames to a run in fine steps; both from the same state. Known'
            ' to: how far two ways to that reference are apart, as a share too'
        ),
        heading,
        chosen,
        'scripts/report work_precision',
    )
    defaults, one, said = about_defaults(curves)
    bars = Table(
        'error_bars',
        (
            'What a run says of itself with -error_estimate, against the distance of its frame to the converged one, found as'
            ' above; all over a body\'s size'
        ),
        ['scene', 'setting', 'its own estimate', 'residual of its reference', 'distance found', 'known to'],
        [
            [name, s.name(), own / case.size, left / case.size, off / case.size, known[0] / case.size]
            for name, (case, _, known, told) in everything.items()
            for s, own, left, off in told
        ],
        'scripts/report work_precision',
    )

    def painter(which):
        def paint(axes):
            for axis, curve in zip(axes, [c for c in curves if c.which == which]):
                paint_curve(axis, curve)
            axes[0].legend(fontsize=6)
        return paint

    wide = min(3, len(everything))
    plots = [
        draw(
            name, caption + ', over a body\'s size, against the time of a frame; one rank', painter(which), wide,
            -(-len(everything) // wide), 'scripts/report work_precision')
        for which, name, caption in (
            (2, 'work_precision', 'Distance of a frame to its converged steps'),
            (3, 'work_precision_steps', 'Distance to a run in fine steps, two frames on'),
        )
    ]
    return Section(
        TITLE,
        [
            (
                'Every setting starts from one state of each scene, in the middle of its motion, which an accurate run made. The'
                ' solver\'s error is the distance of its first frame to the same frame with the same substeps, solved until it'
                ' converges: contacts by stages together with up to 20,000 iterations, the chain directly, the cloth by Newton\'s'
                ' method. How far that is known is the distance between two ways to it (AJ and GS, direct and AJ; of Newton\'s'
                ' its residual; with solids, or cloth and joints at once, AJ and GS end at points of their own): with friction a step'
                ' has no unique solution, and jammed piles creep towards one.'
            ),
            (
                'The error of solver and step is the distance, two frames on, to a run of hundreds of substeps a frame, known to'
                ' what half as many change. Windows are this short since piles are chaotic: after some impacts two runs differ by'
                ' a body\'s size whatever their steps.'
            ),
            (
                'The cloth\'s links have 1e4 N/m here: of inextensible ones Newton\'s method finds no step. In one long step the'
                ' others end at some distance from its, however many iterations they have, since their default form of'
                ' constraints misses implicit Euler by the turning of directions within a step; that falls with substeps'
                ' (docs/scene-flexible.md, Form).'
            ),
            about_error_bars(everything),
            *said,
        ],
        [settings, defaults, one, bars, table],
        plots,
    )
