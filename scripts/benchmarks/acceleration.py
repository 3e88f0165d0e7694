"""The two accelerations of accelerated_jacobi side by side: what either leaves of the error, and its time a frame."""
import statistics

from runs import column, folder, frame_ms, line, publish, say, table, unibody

ACCELERATIONS = ('nesterov', 'optimized')
# title: scene, frames until it rests or hangs, iterations (--quick: the second alone), the error's column of report.csv and its factor
CASES = {
    'cloth, 50 x 50 (RMS stretch, %)': ('cloth_50', 300, (10, 20, 50, 100), 'stretch_rms', 100),
    'cloth, 100 x 100 (RMS stretch, %)': ('cloth_100', 300, (10, 20, 50, 100), 'stretch_rms', 100),
    '2,000 boxes (RMS penetration, mm)': ('boxes_2000', 600, (20, 50, 100), 'penetration_rms', 1e3),
    '2,000 boxes between walls (RMS penetration, mm)': ('boxes_walled_2000', 600, (20, 50, 100), 'penetration_rms', 1e3),
    '5,000 spheres (RMS penetration, mm)': ('spheres_5000', 500, (20, 50, 100), 'penetration_rms', 1e3),
    'chain with a heavy ball (RMS drift, mm)': ('chain_heavy_ball', 200, (50, 100, 400), 'joint_drift_rms', 1e3),
    'soft block on a floor (natural residual, mm)': ('soft_block_on_floor', 60, (50, 100, 400), 'natural_residual', 1e3),
}
LAST = 100  # frames judged, or half of them where there are fewer


def error_of(rows, name, factor):
    """The median of the last frames; links report by material, of which these scenes have one."""
    header = next(h for h in rows[0] if h.startswith(name))
    return factor * statistics.median(float(row[header]) for row in rows[-min(LAST, len(rows) // 2):])


def acceleration(arguments):
    """Errors as the program itself reports them; the two of a pair run one after the other."""
    lines = table(['scene (error)', 'iterations', *(f'{name}: error' for name in ACCELERATIONS), 'ratio',
                   *(f'{name}: ms a frame' for name in ACCELERATIONS)])
    for title, (scene, frames, counts, name, factor) in CASES.items():
        for iterations in counts[1:2] if arguments.quick else counts:
            errors, times = [], []
            for way in ACCELERATIONS:
                say(f'acceleration: {scene}, {iterations} iterations, {way}')
                settings = ['solver.name=accelerated_jacobi', f'solver.iterations={iterations}', f'solver.acceleration={way}', 'output.every=0']
                rows = unibody(scene, settings, folder('acceleration'), 1, arguments.core, arguments.frames or frames)
                errors.append(error_of(rows, name, factor)), times.append(frame_ms(rows))
            ratio = f'{errors[1] / errors[0]:.2f}' if errors[0] > 0 else '-'
            lines.append(line(title, iterations, *(f'{e:.3g}' for e in errors), ratio, *(f'{t:.3g}' for t in times)))
            publish('acceleration.md', lines, show=False)
    publish('acceleration.md', lines)
