"""Other programs on the same bodies: time a frame beside error, both measured by one tool of ours from the bodies' poses."""
import os

from page import Section, Table, draw
from runs import COMMON, DEFAULTS
from work_precision import DEFAULT, SHIPPED, SOLVERS, Setting

TITLE = 'Other programs on the same bodies'
COLUMNS = [
    'scene', 'program', 'settings', 'ranks', 'ms a frame', 'error (mm)', 'max (mm)', 'KE/body (J)', 'mean height (m)',
    'ours with no more error', 'its ms / these ms', 'at rest']
# J a body, up to which a pile counts as at rest, by shape.
REST = {'boxes': 3e-4, 'spheres': 1.7e-3}
RESTING = ('At rest: kinetic energy a body of at most ' + ', '.join(f'{limit:g} J ({shape})' for shape, limit in REST.items()) +
           '; what moves still is not compared')


def ours(*how):
    return ('unibody', Setting(*how))


def text_of(setting):
    return (f'{SOLVERS[setting.solver]}, {setting.iterations} iterations' + (f', {setting.substeps} substeps' if setting.substeps > 1 else '') +
            (f', {setting.variant}' if setting.variant else ''))


def other(name, text, *options):
    return (name, text, options)


PILE = [ours('gauss_seidel', 10), ours('gauss_seidel', 20), ('unibody', DEFAULT), ('unibody', SHIPPED), ours('gauss_seidel', 5, 4),
        ours('gauss_seidel', 20, 1, 2), ours('accelerated_jacobi', 50, 1, 2), ours('gauss_seidel', 40)]
STACK = PILE[:4] + [ours(solver, k, 1, 1, 'velocity share .9') for solver, k in (('gauss_seidel', 40), ('accelerated_jacobi', 50))]
BULLET = [other('Bullet', '10 iterations', '--iterations', 10), other('Bullet', '50 iterations', '--iterations', 50)]
ODE = [other('ODE', 'quickstep, 20 iterations', '--iterations', 20),
       other('ODE', 'quickstep, 4 substeps of 10', '--iterations', 10, '--substeps', 4)]
FINER = [other('Bullet', '4 substeps of 5', '--iterations', 5, '--substeps', 4), other('ODE', 'quickstep, 50', '--iterations', 50)]
# Bullet's best known ways from its defaults: twice as much of the depth taken out a step, and one list of contacts for all islands.
TUNED = [other('Bullet', '10 iterations, erp2 .4', '--iterations', 10, '--erp2', .4),
         other('Bullet', '10 iterations, islands together', '--iterations', 10, '--split', 0)]
# DART's own step is 1 ms, and at that it takes a hundredth of a depth out, at 1 mm/s at most: with frames of 16 ms, more of both.
BRISK = ('--erp', .2, '--erv', 1)
DART = [other('DART', 'PGS, 30 iterations', '--iterations', 30),
        *(other('DART', f'PGS, 30 iterations, erp .2 at up to 1 m/s{more}', '--iterations', 30, *BRISK, *options)
          for more, *options in (('',), (', 4 substeps', '--substeps', 4), (', 16 substeps', '--substeps', 16))),
        other('DART', 'PGS, 30 iterations, 16 substeps', '--iterations', 30, '--substeps', 16),
        other('DART', "Dantzig's, 16 substeps", '--direct', 1, '--substeps', 16),
        other('DART', "Dantzig's, erp .2 at up to 1 m/s, 4 substeps", '--direct', 1, *BRISK, '--substeps', 4)]
# Stiffness (N/m) -> time step (s), and frames from a pile at rest: the time in which springs take its weight goes with 1/sqrt(stiffness).
SPRINGS = {'3.7e4': ('1e-3', 400), '2e5': ('4e-4', 240), '1e6': ('2e-4', 40), '2e6': ('1.333e-4', 40)}
SOFT = ('LIGGGHTS', 'LAMMPS')
SETTLED = 'settled spheres'  # the pile of 'spheres' at rest: what starting there rather than in the air does to the springs' depths


def soft_spheres(maker, most=2, settled=False):
    """`settled`: from the end of the pile's frames with the default solver, where stiff springs would take hours to come down."""
    found = []
    for name in SOFT:
        for kn in maker.pick(['3.7e4'], ['3.7e4', '2e6'], list(SPRINGS)):
            dt, frames = SPRINGS[kn]
            text, *more = (f', {frames} frames from rest', '--from-last', '--frames', frames) if settled else ('',)
            found += [other(name, f'kn = {kn} N/m, dt = {dt} s{text}', '--kn', kn, '--dt', dt, '--ranks', ranks, *more)
                      for ranks in range(1, most + 1)]
    return found


def chain_settings(maker):
    found = [ours('accelerated_jacobi', 100), ours('accelerated_jacobi', 400), ours('accelerated_jacobi', 100, 4), ours('gauss_seidel', 100, 4)]
    found += [ours('accelerated_jacobi', 2, n, 1, 'direct') for n in (1, 4, 16)]
    engines = (('Bullet', '100 iterations', '--iterations', 100), ('ODE', 'quickstep, 100', '--iterations', 100),
               ('ODE', 'direct', '--direct', 1), ('DART', 'reduced coordinates'))
    for name, text, *options in engines:
        found += [other(name, text + f', {n} substeps', *options, '--substeps', n) for n in maker.pick((4,), (4, 16), (1, 4, 16))]
    return found


def heap(count, columns, width):
    """Settings of spheres_5000 for so many spheres, in a container of `width` (m)."""
    return [f'bodies[1].lattice.count={count}', f'bodies[1].lattice.columns=[{columns}, {columns}]', f'bodies[0].container.size=[{width}, {width}]']


def scenes(maker):
    """name -> (scene, settings, frames, what is run, chain?)"""
    boxes = ['bodies[1].lattice.count=' + str(maker.pick(20, 500, 2000))]
    spheres = maker.pick(heap(20, 5, .6), heap(500, 8, .93), ['bodies[1].lattice.count=5000'])
    few, fewer = maker.pick(10, 50, 100), maker.pick(10, 50, 50)  # boxes and spheres: what DART's assembled matrix allows
    dart = maker.pick(DART, DART[:3] + DART[-1:], DART)
    dart_on_spheres = maker.pick(DART, DART[:3], DART)  # there its direct solve takes minutes, and of 100 half an hour
    frames = maker.pick(10, 450, 400)
    tuned = maker.pick([], [], TUNED)
    engines, some = BULLET + ODE + FINER + tuned, BULLET + ODE + maker.pick([], [], FINER) + tuned
    found = {
        'boxes': (maker.pick('boxes_500', 'boxes_500', 'boxes_2000'), boxes, frames, PILE + engines, False),
        f'{few} boxes': ('boxes_500', [f'bodies[1].lattice.count={few}'], frames, STACK + some + dart, False),
        f'{fewer} spheres': (
            'spheres_5000', heap(fewer, 5, .6), frames, PILE[:4] + [ours('gauss_seidel', 5, 4)] + some + dart_on_spheres + soft_spheres(maker, 1),
            False),
        'spheres': ('spheres_5000', spheres, frames, PILE + some + soft_spheres(maker), False),
        'chain': (
            'chain_heavy_ball', ['output.joints=false'] + maker.pick(['bodies[0].chain.count=5'], [], []), maker.pick(5, 60, 150),
            chain_settings(maker), True),
    }
    if maker.size == 'tiny':  # each program once
        found = {
            name: (scene, settings, frames, list({entry[0]: entry for entry in entries}.values()), chain)
            for name, (scene, settings, frames, entries, chain) in found.items()
        }
    if maker.size != 'quick':
        found[SETTLED] = ('spheres_5000', spheres, frames, soft_spheres(maker, 1, settled=True), False)
    if maker.size == 'full':
        found['50,000 spheres'] = (
            'spheres_5000',
            heap(50000, 41, 4.74), frames,
            [ours(name, k, 1, n) for n in (1, 2) for name, k in (('gauss_seidel', 10), ('gauss_seidel', 20), ('accelerated_jacobi', 50))] +
            soft_spheres(maker, settled=True), False)
    return found


def reference_of(maker, start, frames, gravity):
    """A chain in fine steps by a program in reduced coordinates, where there is one; its folder or file, or None."""
    path = os.path.join(maker.folder, 'states', f'chain_{maker.mark(os.path.join(start, "frames.h5"))}_{frames}.h5')
    if not os.path.exists(path):
        maker.rival('DART', start, ['--chain', 1, '--frames', frames, '--substeps', maker.pick(8, 64, 256)], ['copy', path], gravity)
    return path if os.path.exists(path) else None


def rows_of(maker, name, scene, settings, frames, entries, chain):
    settings = settings + ['gravity=[0, 0, -9.8]', f'time.frames={frames}']
    start = maker.folder_of(scene, settings[:-1] + ['output.every=1'], 1)
    look = ['chain', reference_of(maker, start, frames, 9.8)] if chain else ['measure']
    rows = []
    for entry in entries:
        if entry[0] == 'unibody':
            setting, ranks = entry[1], entry[1].ranks
            run = maker.run(scene, settings + setting.values(), ranks, look=look)
            text, ms, seen = text_of(setting), run.frame_ms(), run.seen
        else:
            _, text, options = entry
            ranks = options[options.index('--ranks') + 1] if '--ranks' in options else 1
            if '--from-last' in options:
                rest = maker.folder_of(scene, settings + DEFAULTS + [f'output.every={frames}'], frames)
                done = maker.rival(entry[0], rest, options, look)
            else:
                done = maker.rival(entry[0], start, [*options, '--frames', frames] + (['--chain', 1] if chain else []), look)
            if done is None or 'ms' not in done:
                why = 'not installed' if done is None else f'diverged, in frame {done["diverged"]}' if 'diverged' in done else 'ended in an error'
                rows.append([name, entry[0], f'{text}: {why}', ranks] + [None] * (len(COLUMNS) - (5 if chain else 4)))
                continue
            ms, seen = done['ms'], done['seen']
        if chain:
            values = [seen['drift_rms_mm'], seen['drift_peak_mm'], seen['kinetic_j'], None if seen['away'] is None else 1e3 * seen['away']]
        else:
            values = [seen['rms_mm'], seen['max_mm'], seen['kinetic_j'], seen['height_m']]
        rows.append([name, entry[0], text, ranks, ms, *values, None, None] + ([] if chain else [at_rest(name, seen['kinetic_j'])]))
    compare(rows)
    return rows


def at_rest(name, kinetic):
    """Whether the bodies of the pile `name` have come to rest: their penetration then tells of the solver."""
    return kinetic <= next(limit for shape, limit in REST.items() if name.endswith(shape))


def restless(row):
    return len(row) == len(COLUMNS) and row[-1] is False


def compare(rows):
    """Fills the columns 9 and 10 of other programs' rows: our fastest setting on as many ranks or fewer whose error is no larger, and how its
    time compares. Piles that move still are not compared."""
    for row in rows:
        if row[1] == 'unibody' or row[4] is None or restless(row):
            continue
        best = min(((r[4], r[2]) for r in rows if r[1] == 'unibody' and r[3] <= row[3] and r[5] <= row[5] and not restless(r)), default=None)
        if best:
            row[9], row[10] = best[1], best[0] / row[4]


def telling(rows):
    """Of each scene and program the fastest setting and the one of least error, of ours also the fastest with no more error than any of the
    others' on as many ranks; of those at rest, or, where none is, of all."""
    kept = []
    for scene, program in dict.fromkeys((r[0], r[1]) for r in rows if r[0] != SETTLED):
        of = [r for r in rows if (r[0], r[1]) == (scene, program) and r[4] is not None]
        of = [r for r in of if not restless(r)] or of
        if not of:
            kept += [r for r in rows if (r[0], r[1]) == (scene, program)][:1]
            continue
        wanted = [min(of, key=lambda r: r[4]), min(of, key=lambda r: (r[5], r[4]))]
        if program == 'unibody':
            others = [r[5] for r in rows if r[0] == scene and r[1] != program and r[4] is not None and not restless(r)]
            wanted += sorted((r for r in of if r[5] <= min(others, default=0)), key=lambda r: r[4])[:1]
        kept += sorted(({id(r): r for r in wanted}).values(), key=lambda r: r[4])
    return kept


def from_rest(rows):
    """What the page says of the rows "from rest": rows of `SETTLED` beside those of the same spheres after a fall. '' without them."""

    def depths(scene):
        return {(r[1], r[2].split(',')[0]): r[5] for r in rows if r[0] == scene and r[1] in SOFT and r[3] == 1 and r[4] is not None}

    fallen, settled = depths('spheres'), depths(SETTLED)
    less = [f'{name} {100 * (1 - settled[name, kn] / fallen[name, kn]):.0f} % ({kn})' for name, kn in settled if fallen.get((name, kn))]
    return (
        ' Of 50,000 spheres these two do not fall, which would take hours: "from rest" they start from where the default solver left'
        ' the pile at the end, with the fewer frames the stiffer they are; of less than 100 frames the medians are of all. What that takes off'
        f' the penetration they have after a fall is measured on the spheres of before, as {SETTLED}: {", ".join(less)}.') if less else ''


def make(maker):
    rows, ties = [], []
    plan = scenes(maker)
    maker.expect(sum(len(entries) for _, _, _, entries, _ in plan.values()))
    for name, (scene, settings, frames, entries, chain) in plan.items():
        (ties if chain else rows).extend(rows_of(maker, name, scene, settings, frames, entries, chain))
    piles = Table(
        'rivals',
        (
            'Piles: RMS and largest penetration of all pairs, medians of the last 100 frames, from the poses; one thread against'
            ' one rank; h = 16 ms, mu = .3. ' + RESTING
        ),
        COLUMNS,
        rows,
        'scripts/report rivals',
    )
    best = Table(
        'rivals_best',
        (
            'Piles at rest, of each program its fastest setting and that of least error, of ours also the fastest with no more'
            ' error than any other program has; RMS and largest penetration of all pairs, medians of the last 100 frames, from'
            ' the poses; h = 16 ms, mu = .3. ' + RESTING
        ),
        COLUMNS,
        telling(rows),
        'scripts/report rivals',
    )
    heading = COLUMNS[:5] + ['drift RMS (mm)', 'largest drift of all (mm)', COLUMNS[7], 'from the fine reference (mm)'] + COLUMNS[9:11]
    joints = Table(
        'rivals_chain',
        (
            'a chain of 100 links with a ball of 1,000 times their mass: how far its joints are open, and how far its bodies are'
            ' at the end from a run of DART in fine steps'
        ),
        heading,
        ties,
        'scripts/report rivals',
    )

    shown = [name for name in ('boxes', 'spheres', '50,000 spheres') if name in plan]

    def paint(axes):
        for axis, name in zip(axes, shown):
            of = [r for r in rows if r[0] == name and r[3] == 1 and r[4] is not None]
            for program in dict.fromkeys(r[1] for r in of):
                points = sorted((r[4], max(r[5], 1e-4)) for r in of if r[1] == program)
                axis.loglog(*zip(*points), 'o' if program == 'unibody' else 'x-' if program in ('LIGGGHTS', 'LAMMPS') else 'x', label=program)
            axis.set(title=name, xlabel='ms a frame, one thread', ylabel='RMS penetration (mm)')
            axis.legend(fontsize=8)

    plot = draw(
        'rivals_boxes',
        (
            'Time a frame against penetration at rest, this program and others, each with several settings (LIGGGHTS, LAMMPS:'
            ' stiffnesses)'
        ),
        paint,
        len(shown),
        command='scripts/report rivals',
    )
    return Section(
        TITLE,
        [
            (
                'All start from the same file; scripts/rivals/measure judges the poses that each recorded. Bullet, ODE and DART'
                ' as the distribution builds them, no sleeping, no damping, otherwise their defaults but for what a row says; LIGGGHTS'
                ' and LAMMPS with linear springs. Times: ODE, Bullet, DART CPU time of their step, unibody contacts, solve and'
                ' exchange, both medians of the frames; LIGGGHTS, LAMMPS wall time without output, the mean of all frames.'
                + from_rest(rows) +
                f' Rows of unibody without "as shipped" have {" and ".join(COMMON[:2])}: all iterations are done, as the others do'
                ' theirs, and depths come out faster than is safe for bodies that start in each other, which these do not.'
            ),
            (
                'DART (projected Gauss-Seidel or pivoting on an assembled matrix) is not made for large piles: it has small ones of'
                ' its own, of boxes and of spheres. It takes a hundredth of a depth out in a step, at 1 mm/s at most, which its'
                ' usual steps of 1 ms may do with: rows say where it has more of both, or more steps. In a'
                ' chain it has reduced coordinates, and its joints cannot open: what is wrong there is the step, as the last'
                ' column but two tells.'
            ),
        ],
        [best, piles, joints],
        [plot],
    )
