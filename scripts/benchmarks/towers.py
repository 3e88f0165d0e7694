"""25 towers of boxes, a little out of line and turned, after a fall of centimetres: how many iterations they need to come to rest."""
import statistics

from runs import column, folder, frame_ms, line, publish, say, table, unibody

FRAMES = 600
KINETIC = 1e-6  # J a box: at rest
COLUMNS = ['boxes a tower', 'solver', 'iterations', 'stages', 'velocity share', 'ms a frame', 'penetration RMS (mm)', 'KE/body (J)', 'height (m)', '']


def settings(quick):
    """(solver, iterations, stages, velocity share)"""
    for solver in ('accelerated_jacobi', 'gauss_seidel'):
        for iterations in (50, 200) if quick else (50, 100, 200, 400):
            for stages, share in (('two', 'auto'), ('two', .9), ('position', 'auto')):
                yield solver, iterations, stages, share


def towers(arguments):
    lines = table(COLUMNS)
    for boxes in (3, 5) if arguments.quick else (3, 5, 10):
        for solver, iterations, stages, share in settings(arguments.quick):
            say(f'towers of {boxes}: {solver} {iterations}, {stages}, {share}')
            rows = unibody('boxes_500', [f'bodies[1].lattice.count={25 * boxes}', f'solver.name={solver}', f'solver.iterations={iterations}',
                                         f'solver.stages={stages}', f'solver.velocity_share={share}', 'output.every=0'],
                           folder('towers'), 1, arguments.core, arguments.frames or FRAMES)
            last = rows[-100:]
            kinetic = statistics.median(column(last, 'kinetic_energy')) / (25 * boxes)
            height = column(last, 'potential_energy')[-1] / (25 * boxes * 9.8)
            fallen = height < .95 * .15 * boxes / 2
            lines.append(line(boxes, solver, iterations, stages, share if stages == 'two' else '-', f'{frame_ms(rows):.3g}',
                              f'{1e3 * statistics.median(column(last, "penetration_rms")):.2g}', f'{kinetic:.1e}', f'{height:.3f}',
                              'fallen' if fallen else 'at rest' if kinetic < KINETIC else 'trembling'))
            publish('towers.md', lines, show=False)
    publish('towers.md', lines)
