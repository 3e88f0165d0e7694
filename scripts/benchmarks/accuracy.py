"""What an accuracy costs, and whether it is held: runs that ask for one beside the default, judged by converged steps."""
import json
import os
import statistics

import matplotlib

from runs import BUILD, OUT, ROOT, column, command, folder, line, publish, report_rows, say, table

matplotlib.use('Agg')
from matplotlib import pyplot  # noqa: E402

# scene: frames, frames from one to the next whose error is estimated, settings of the scene's own that are taken back
CASES = {
    'dominoes': (500, 20, []),
    'towers_2000': (200, 40, []),
    'brick_wall': (250, 10, []),
    'boxes_500': (400, 20, []),
    'boxes_2000': (400, 40, []),
    'spheres_5000': (300, 60, []),
    'rope_over_spheres': (400, 20, []),
    'gripper': (600, 30, []),
    'carousel': (200, 20, ['solver.iterations=1000']),
    'cloth_hanging': (200, 20, []),
    'chain_heavy_ball': (100, 10, ['solver.iterations=1000', 'solver.joints=direct']),
}
QUICK = ('dominoes', 'brick_wall', 'rope_over_spheres', 'gripper', 'towers_2000', 'boxes_500')
ASKED = (None, 1e-1, 1e-2, 1e-3, 1e-4)


def run(scene, asked, arguments):
    """The report's rows of a run that is timed, and those of the same run with its errors estimated."""
    frames, every, further = CASES[scene]
    settings = ['output.every=0', 'output.checkpoint_every=-1', f'time.frames={arguments.frames or frames}']
    path = os.path.join(ROOT, 'scenes', scene + '.yaml')
    if asked:
        settings += [*further, f'solver.accuracy={asked}']
    else:  # with the iterations that the scene names, or 50
        with open(path, encoding='utf-8') as file:
            settings += [s for s in further if 'iterations' not in s] + ([] if 'iterations:' in file.read() else ['solver.iterations=50'])
    output = folder('accuracy')
    words = [os.path.join(BUILD, 'unibody'), path, '-output', output, '-overwrite']
    for value in settings:
        words += ['-set', value]
    command(words, 1, arguments.core)
    timed = report_rows(output)
    command(words + ['-error_estimate', str(every)], 1, arguments.core)
    return timed, report_rows(output), os.path.join(output, 'summary.json')


def mean_ms(rows):
    """Of all frames: an accuracy spends its iterations where they are needed."""
    return 1e3 * statistics.mean(map(sum, zip(*(column(rows, name) for name in ('wall_collide', 'wall_solve', 'wall_halo')))))


def judge(rows, size):
    """The estimated errors over the smallest moving body's size."""
    header = next(h for h in rows[0] if h.startswith('error_estimate'))
    return [float(row[header]) / size for row in rows if row[header] not in ('', 'nan')]


def accuracy(arguments):
    lines = table(['scene', 'asked', 'ms a frame', 'over the default', 'iterations a frame', 'frames within', 'error: median', 'worst', 'steps within'])
    figure, (costs, errors) = pyplot.subplots(1, 2, figsize=(11, 4.5))
    for scene in QUICK if arguments.quick else CASES:
        default, points = None, []
        for asked in ASKED:
            say(f'accuracy: {scene}, {asked or "default"}')
            timed, judged, summary = run(scene, asked, arguments)
            with open(summary, encoding='utf-8') as file:
                told = json.load(file)['convergence']
            ms, iterations = mean_ms(timed), statistics.mean(column(timed, 'iterations'))
            default = default or ms
            found = judge(judged, told['smallest_size (m)'])
            share = asked or told['accuracy']
            held = f'{told["frames_within_accuracy"]} of {len(timed)}'
            within = f'{sum(e <= share for e in found)} of {len(found)}'
            lines.append(line(scene, f'{asked:g}' if asked else '- (judged by 0.01)', f'{ms:.3g}', f'{ms / default:.2f}', f'{iterations:.0f}', held,
                              f'{statistics.median(found):.1e}', f'{max(found):.1e}', within))
            publish('accuracy.md', lines, show=False)
            if asked:
                points.append((asked, ms / default, max(found)))
        costs.plot([p[0] for p in points], [p[1] for p in points], 'o-', label=scene)
        errors.plot([p[0] for p in points], [p[2] for p in points], 'o-', label=scene)
    ends = [min(a for a in ASKED if a), max(a for a in ASKED if a)]
    errors.plot(ends, ends, 'k:', label='what is asked for')
    for axes, title in ((costs, 'time over that of the default'), (errors, 'largest error of a sampled step / size')):
        axes.set(xscale='log', yscale='log', xlabel='accuracy asked for', title=title)
    errors.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(os.path.join(OUT, 'accuracy.png'), dpi=100)
    publish('accuracy.md', lines)
