"""Work against precision: how far a step ends from the converged one, and some frames from a fine-step reference, for the time they take."""
from dataclasses import dataclass, field, replace

from page import Section, Table, draw
from maker import Failed

TITLE = 'Work against precision'
SOLVERS = {'accelerated_jacobi': 'AJ', 'gauss_seidel': 'GS'}
LEVELS = (1e-2, 1e-3, 1e-4)  # of a body's size


@dataclass
class Case:
    scene: str
    size: float            # m, of a body, element or link
    second: str            # column of the other error
    settings: list = field(default_factory=list)
    frame: int = 60        # of the state from which all settings start
    stages: bool = True    # a velocity stage may be used


def cases(maker):
    tiny = {'boxes': Case('boxes_500', .12, 'penetration_rms', ['bodies[1].lattice.count=20'], 20),
            'cloth': Case('cloth_50', .2, 'stretch_rms', ['cloths[0].grid.nodes=[8, 8]', 'cloths[0].pins=[{node: [0, 0]}, {node: [7, 0]}]'], 5, False)}
    quick = {'boxes': Case('boxes_500', .12, 'penetration_rms'),
             'spheres': Case('spheres_5000', .1, 'penetration_rms', ['bodies[1].lattice.count=1000']),
             'cloth': Case('cloth_50', 10 / 49, 'stretch_rms', stages=False),
             'soft block': Case('soft_block_on_floor', .5 / 8, 'strain_max', frame=25, stages=False),
             'chain': Case('chain_heavy_ball', .1, 'joint_drift_rms', ['output.joints=false']),
             'mixed': Case('mixed_pile', .2, 'penetration_rms', ['bodies[1].pile.count=300'])}
    full = dict(quick, boxes=Case('boxes_2000', .12, 'penetration_rms'), spheres=Case('spheres_5000', .1, 'penetration_rms'), mixed=Case('mixed_pile', .2, 'penetration_rms'))
    return maker.pick(tiny, quick, full)


@dataclass
class Setting:
    solver: str
    iterations: int
    substeps: int
    ranks: int
    variant: str = ''

    def name(self):
        return (f'{SOLVERS[self.solver]} {self.iterations}' + (f' x {self.substeps} substeps' if self.substeps > 1 else '') + (f', {self.variant}' if self.variant else '') +
                (' on 2 ranks' if self.ranks > 1 else ''))

    def values(self):
        more = {'': [], 'position stage alone': ['solver.stages=position'], 'cold': ['solver.stages=position', 'solver.warm_start=0']}[self.variant]
        return [f'solver.name={self.solver}', f'solver.iterations={self.iterations}', f'time.substeps={self.substeps}', *more]


def settings_of(maker, case):
    """All combinations in the full report; the curve on one rank, and some of the rest, in the quick one."""
    variants = (['position stage alone'] if case.stages else []) + ['cold']
    found = []
    for solver in SOLVERS:
        if maker.size == 'full':
            found += [Setting(solver, k, s, r, v) for v in ['', *variants] for s in (1, 2, 4, 8) for k in (5, 10, 20, 50, 100, 200, 500)
                      for r in (1, 2)]
            continue
        counts = maker.pick((4, 40), (10, 40, 160, 640), ())
        found += [Setting(solver, k, 1, 1) for k in counts] + [Setting(solver, k, 4, 1) for k in counts[:maker.pick(2, 3, 0)]]
        found += [Setting(solver, 40, 16, 1)] if maker.size == 'quick' else []
        found += ([Setting(solver, counts[-1], 1, 2)] if maker.size == 'quick' or solver == 'gauss_seidel' else []) + ([Setting(solver, 40, 1, 1, v) for v in variants] if maker.size == 'quick' else [])
    return found


def measure(maker, case):
    """[(setting, ms a frame, distance of a frame to converged steps, distance to the fine reference, second error)]: distances in m."""
    frames = maker.pick(3, 4, 6)
    last = case.frame + frames
    # A state with hardly an error: what an inaccurate run has left open, an accurate one would push apart, by bounded speeds that add up.
    careful = ['solver.name=accelerated_jacobi', f'solver.iterations={maker.pick(20, 200, 500)}', f'time.substeps={maker.pick(2, 4, 16)}']
    state = maker.state(case.scene, case.settings + careful, case.frame)
    fine = ['solver.name=accelerated_jacobi', f'solver.iterations={maker.pick(20, 200, 500)}', f'time.substeps={maker.pick(4, 16, 64)}'] + (['solver.stages=joint'] if case.stages else [])
    reference = maker.folder_of(case.scene, case.settings + fine + [f'output.every={last}'], last, start=state)
    found = []
    for s in settings_of(maker, case):
        alone = next((f for f in found if s.ranks > 1 and f[0] == replace(s, ranks=1)), None)  # the same bits: only the time is new
        how = {'look': ['away', reference], 'options': ('-error_estimate', str(case.frame + 1))} if alone is None else {}
        settings = case.settings + s.values() + [f'time.frames={last}'] + ([f'output.every={last}'] if alone is None else [])
        try:
            run = maker.run(case.scene, settings, s.ranks, start=state, **how)
        except Failed as fault:  # a setting that this scene can't take
            maker.say(f'{s.name()}: {str(fault).splitlines()[-1]}')
            continue
        errors = alone[2:] if alone else (s.substeps * run.column('error_estimate')[0], run.seen, run.column(case.second)[-1])
        found.append((s, run.frame_ms(1), *errors))
    return found


def cheapest(found, limit, which):
    """The fastest setting whose error number `which` is at most `limit`, as (ms, its name), or None."""
    return min(((f[1], f[0].name()) for f in found if f[which] is not None and f[which] <= limit), default=None)


def choices(case, found, which):
    return [f'{best[1]}: {best[0]:.3g} ms' if (best := cheapest(found, level * case.size, which)) else 'none' for level in LEVELS]


def make(maker):
    everything = {name: (case, measure(maker, case)) for name, case in cases(maker).items()}
    rows, chosen = [], []
    for name, (case, found) in everything.items():
        for s, ms, step, away, second in found:
            rows.append([name, SOLVERS[s.solver], s.iterations, s.substeps, s.ranks, s.variant or 'default', ms, step / case.size, away and away / case.size, case.second, second])
        chosen.append([name, f'{case.size:.3g}', 'the solver', *choices(case, found, 2)])
        if any(f[3] is not None for f in found):
            chosen.append([name, f'{case.size:.3g}', 'solver and step', *choices(case, found, 3)])
    table = Table('work_precision', 'all settings start from the same state; distances over the size of a body (link, cell)', ['scene', 'solver', 'iterations', 'substeps', 'ranks', 'variant', 'ms a frame',
                  'to the converged step', 'to the fine-step reference', 'other error', 'its value'], rows, 'scripts/report work_precision')
    settings = Table('settings', 'The cheapest setting that ends within a share of a body\'s size. The solver: distance of a frame of 16 ms to its converged steps; solver and step: distance to a run in fine steps, '
                     'some frames on from the same state', ['scene', 'size (m)', 'error of', *(f'{level:g}' for level in LEVELS)], chosen, 'scripts/report work_precision')

    def paint(axes):
        for axis, (name, (case, found)) in zip(axes, everything.items()):
            for solver, short in SOLVERS.items():
                for substeps, line in ((1, '-'), (4, '--')):
                    of = [(f[1], f[2] / case.size) for f in found if f[0].solver == solver and f[0].substeps == substeps and f[0].ranks == 1 and not f[0].variant]
                    if of:
                        axis.loglog(*zip(*of), line, marker='.', color={'AJ': 'C0', 'GS': 'C1'}[short], label=short + (f', {substeps} substeps' if substeps > 1 else ''))
            axis.set(title=name, xlabel='ms a frame', ylabel='distance / size')
        axes[0].legend(fontsize=7)

    wide = min(3, len(everything))
    plot = draw('work_precision', 'Distance of a frame to its converged steps, over a body\'s size, against its time; one rank', paint, wide, -(-len(everything) // wide), 'scripts/report work_precision')
    return Section(TITLE, [
        'Every setting starts from one state of each scene, in the middle of its motion. Its first frame is solved on until it converges (`-error_estimate`); the distance of one step is taken as many times as '
        'the frame has substeps. Some frames later the run is compared with a reference of fine, converged steps from the same state: that error has the step\'s own too, which no iterations take away.',
        'How to read it: the distance of a step falls slowly with iterations where force chains are long or links stiff, since information goes one body an iteration; the error after some frames falls '
        'with substeps as well. Inextensible cloths are the extreme: all their links may hold to a thousandth and the cloth still be far from where the converged step folds it. The default (accelerated Jacobi, '
        '50 iterations) is not the cheapest on piles, where Gauss-Seidel with 10 is; it is the default since towers stand with it and ranks gain most.'], [settings, table], [plot])
