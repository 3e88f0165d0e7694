"""Joints: drift against time for every solver on chains and ragdolls, and what a direct solve of a chain would cost."""
import os
import statistics
import subprocess

from runs import BUILD, column, folder, line, publish, say, table, unibody

SOLVERS = {'accelerated_jacobi': 'AJ', 'gauss_seidel': 'GS', 'jacobi': 'J'}
LONG = [
    'bodies[0].chain.count=10000', 'bodies[0].chain.to=[500, 0, -866]', 'bodies[0].chain.ball={radius: 0.3, mass: 1}',
    'bodies[0].position=[0, 0, 0]']
# scene, settings, frames, substeps, iterations of the iterative and the direct solve of the joints, and how many of these --quick takes
CASES = {
    '100 links, ball of 1,000': ('chain_heavy_ball', [], 100, (1, 4), (50, 100, 400), (5, 10), 2),
    '10,000 links': ('chain_heavy_ball', LONG, 10, (1,), (25, 100, 400), (5, 10), 2),
    '300 ragdolls on stairs': ('ragdolls_on_stairs', [], 60, (12,), (50, 20), (50, 20), 1),
}


def drift(rows, name):
    """The median and the largest of all frames."""
    values = column(rows, name)
    return statistics.median(values), max(values)


def settings_of(case, quick):
    _, _, _, substeps, iterative, direct, few = CASES[case]
    for solver in SOLVERS:
        for joints_by, counts in (('iterative', iterative), ('direct', direct)):
            for count in counts[-few:] if quick else counts:
                for parts in substeps[:1] if quick else substeps:
                    yield solver, joints_by, count, parts


def joints(arguments):
    lines = table([
        'scene', 'solver', 'joints', 'iterations', 'substeps', 'ms a frame', 'drift RMS, median (m)', 'drift max, median (m)',
        'drift max of all (m)'])
    for case, (scene, settings, frames, *_) in CASES.items():
        for solver, joints_by, count, parts in settings_of(case, arguments.quick):
            say(f'{case}: {solver}, {joints_by}, {count} x {parts}')
            changes = settings + [
                f'solver.name={solver}', f'solver.joints={joints_by}', f'solver.iterations={count}', f'time.substeps={parts}',
                'output.every=0', 'output.joints=false']
            rows = unibody(scene, changes, folder('joints'), 1, arguments.core, arguments.frames or frames)
            ms = 1e3 * statistics.median(column(rows, 'wall_solve'))
            median, most = drift(rows, 'joint_drift_max')
            rms, _ = drift(rows, 'joint_drift_rms')
            lines.append(line(case, SOLVERS[solver], joints_by, count, parts, f'{ms:.3g}', f'{rms:.2g}', f'{median:.2g}', f'{most:.2g}'))
            publish('joints.md', lines, show=False)
    publish('joints.md', lines + [''] + direct())


def direct():
    """Newton's method with the block-tridiagonal Schur complement of a chain, beside what AJ does in the same time."""
    lines = table([
        'links', 'ball, in links', 'ms a Newton iteration', 'Newton iterations to 1e-12 m',
        'iterations of AJ in the time of all, at 0.35 us a joint'])
    for links in (100, 1000, 10000):
        for ball in (1, 1000):
            words = [os.path.join(BUILD, 'scripts', 'rivals', 'direct_chain'), str(links), str(ball)]
            done = subprocess.run(words, text=True, capture_output=True, check=True)
            ms, count, _ = map(float, done.stdout.split())
            lines.append(line(links, ball, f'{ms:.3g}', int(count), f'{ms * count / (links * 0.35e-3):.2g}'))
    return lines
