"""Joints: drift against time for every solver on chains and ragdolls, and what a direct solve of a chain would cost."""
import os
import statistics
import subprocess

from runs import BUILD, column, folder, line, publish, say, table, unibody

SOLVERS = {'accelerated_jacobi': 'AJ', 'gauss_seidel': 'GS', 'jacobi': 'J'}
LONG = ['bodies[0].chain.count=10000', 'bodies[0].chain.to=[500, 0, -866]', 'bodies[0].chain.ball={radius: 0.3, mass: 1}', 'bodies[0].position=[0, 0, 0]']
# scene, settings, frames, iterations
CASES = {
    '100 links, ball of 1,000': ('chain_heavy_ball', [], 150, (25, 50, 100, 200, 400)),
    '10,000 links': ('chain_heavy_ball', LONG, 10, (25, 100, 400)),
    '300 ragdolls on stairs': ('ragdolls_on_stairs', [], 150, (10, 25, 50, 100)),
}


def drift(rows, name):
    """The median and the largest of all frames."""
    values = column(rows, name)
    return statistics.median(values), max(values)


def joints(arguments):
    lines = table(['scene', 'solver', 'iterations', 'substeps', 'ms a frame', 'drift RMS, median (m)', 'drift max, median (m)', 'drift max of all (m)'])
    for name, (scene, settings, frames, counts) in CASES.items():
        for solver, short in SOLVERS.items():
            for iterations in counts[1::2] if arguments.quick else counts:
                for substeps in (1, 4) if name.startswith('100') else (1,):
                    say(f'{name}: {solver} {iterations} x {substeps}')
                    rows = unibody(scene, settings + [f'solver.name={solver}', f'solver.iterations={iterations}', f'time.substeps={substeps}', 'output.every=0',
                                                      'output.joints=false'], folder('joints'), 1, arguments.core, arguments.frames or frames)
                    ms = 1e3 * statistics.median(column(rows, 'wall_solve'))
                    median, most = drift(rows, 'joint_drift_max')
                    lines.append(line(name, short, iterations, substeps, f'{ms:.3g}', f"{drift(rows, 'joint_drift_rms')[0]:.2g}", f'{median:.2g}', f'{most:.2g}'))
                    publish('joints.md', lines, show=False)
    publish('joints.md', lines + [''] + direct())


def direct():
    """Newton's method with the block-tridiagonal Schur complement of a chain, beside what AJ does in the same time."""
    lines = table(['links', 'ball, in links', 'ms a Newton iteration', 'Newton iterations to 1e-12 m', 'iterations of AJ in the time of all, at 0.35 us a joint'])
    for links in (100, 1000, 10000):
        for ball in (1, 1000):
            text = subprocess.run([os.path.join(BUILD, 'scripts', 'rivals', 'direct_chain'), str(links), str(ball)], text=True, capture_output=True, check=True).stdout
            ms, count, _ = map(float, text.split())
            lines.append(line(links, ball, f'{ms:.3g}', int(count), f'{ms * count / (links * 0.35e-3):.2g}'))
    return lines
