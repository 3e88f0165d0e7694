"""Two ways of one solver side by side, its momentum or how it shares masses: what either leaves of the error, and its time a frame."""
import statistics

from runs import column, folder, frame_ms, line, publish, say, table, unibody

MOMENTUM = ('acceleration', ('nesterov', 'optimized'))
SHARING = ('mass_sharing', ('count', 'directions'))
PLAIN = ('acceleration', ('none', 'nesterov'))  # of gauss_seidel; the others are of accelerated_jacobi
# title: scene, what differs, frames until it rests or hangs, iterations (--quick: the second alone), the error's column of report.csv
# and its factor
CASES = {
    'cloth, 50 x 50 (RMS stretch, %)': ('cloth_50', SHARING, 300, (10, 20, 50, 100), 'stretch_rms', 100),
    'cloth, 100 x 100 (RMS stretch, %)': ('cloth_100', SHARING, 300, (10, 20, 50, 100), 'stretch_rms', 100),
    'cloth, 150 x 150 (RMS stretch, %)': ('cloth_150', SHARING, 300, (10, 20, 50, 100), 'stretch_rms', 100),
    'cloth, 50 x 50, momentum (RMS stretch, %)': ('cloth_50', MOMENTUM, 300, (10, 20, 50, 100), 'stretch_rms', 100),
    'cloth, 100 x 100, momentum (RMS stretch, %)': ('cloth_100', MOMENTUM, 300, (10, 20, 50, 100), 'stretch_rms', 100),
    'cloth, 150 x 150, momentum (RMS stretch, %)': ('cloth_150', MOMENTUM, 300, (10, 20, 50, 100), 'stretch_rms', 100),
    'soft block on a floor (natural residual, mm)': ('soft_block_on_floor', SHARING, 60, (50, 100, 400), 'natural_residual', 1e3),
    '2,000 boxes (RMS penetration, mm)': ('boxes_2000', MOMENTUM, 600, (20, 50, 100), 'penetration_rms', 1e3),
    '2,000 boxes between walls (RMS penetration, mm)': ('boxes_walled_2000', MOMENTUM, 600, (20, 50, 100), 'penetration_rms', 1e3),
    '5,000 spheres (RMS penetration, mm)': ('spheres_5000', MOMENTUM, 500, (20, 50, 100), 'penetration_rms', 1e3),
    'chain with a heavy ball (RMS drift, mm)': ('chain_heavy_ball', MOMENTUM, 200, (50, 100, 400), 'joint_drift_rms', 1e3),
    'chain with a heavy ball, Gauss-Seidel (RMS drift, mm)': ('chain_heavy_ball', PLAIN, 200, (50, 100, 400), 'joint_drift_rms', 1e3),
    'cloth, 50 x 50, Gauss-Seidel (RMS stretch, %)': ('cloth_50', PLAIN, 300, (20, 50, 100), 'stretch_rms', 100),
    'cloth, 100 x 100, Gauss-Seidel (RMS stretch, %)': ('cloth_100', PLAIN, 300, (20, 50, 100), 'stretch_rms', 100),
    'soft block on a floor, Gauss-Seidel (natural residual, mm)': ('soft_block_on_floor', PLAIN, 60, (20, 50), 'natural_residual', 1e3),
    '500 boxes, Gauss-Seidel (RMS penetration, mm)': ('boxes_500', PLAIN, 150, (20, 50, 100), 'penetration_rms', 1e3),
    '5,000 spheres, Gauss-Seidel (RMS penetration, mm)': ('spheres_5000', PLAIN, 300, (20, 50, 100), 'penetration_rms', 1e3),
}
LAST = 100  # frames judged, or half of them where there are fewer


def error_of(rows, name, factor):
    """The median of the last frames; links report by material, of which these scenes have one."""
    header = next(h for h in rows[0] if h.startswith(name))
    return factor * statistics.median(float(row[header]) for row in rows[-min(LAST, len(rows) // 2):])


def acceleration(arguments):
    """Errors as the program itself reports them; the two of a pair run one after the other."""
    lines = table(['scene (error)', 'iterations', 'two ways', 'error', 'ratio', 'ms a frame', 'ratio'])
    for title, (scene, (key, ways), frames, counts, name, factor) in CASES.items():
        solver = 'gauss_seidel' if ways is PLAIN[1] else 'accelerated_jacobi'
        if arguments.solvers and solver not in arguments.solvers:
            continue
        for iterations in counts[1:2] if arguments.quick else counts:
            errors, times = [], []
            for way in ways:
                say(f'acceleration: {scene}, {iterations} iterations, {way}')
                settings = [f'solver.name={solver}', f'solver.iterations={iterations}', f'solver.{key}={way}', 'output.every=0']
                rows = unibody(scene, settings, folder('acceleration'), 1, arguments.core, arguments.frames or frames)
                errors.append(error_of(rows, name, factor)), times.append(frame_ms(rows))
            shown = [f'{a:.3g}, {b:.3g}' for a, b in (errors, times)]
            ratios = [f'{b / a:.2f}' if a > 0 else '-' for a, b in (errors, times)]
            lines.append(line(title, iterations, f'{key}: {", ".join(ways)}', shown[0], ratios[0], shown[1], ratios[1]))
            publish('acceleration.md', lines, show=False)
    publish('acceleration.md', lines)
