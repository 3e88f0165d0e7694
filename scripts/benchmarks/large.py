"""Large scenes with this program alone: time a contact and iteration, bytes a body, and what a million nodes take of the memory's
bandwidth."""
import json
import os
import statistics

from runs import BUILD, column, command, folder, frame_ms, line, publish, say, table, unibody


def spheres(arguments):
    lines = table(['scene', 'ranks', 'frames', 'ms a frame', 'contacts', 'ns a contact and iteration', 'bytes a body'])
    for scene in ['spheres_100k'] + ([] if arguments.quick else ['spheres_1m']):
        for ranks in (1, 2):
            say(f'{scene} on {ranks}')
            rows = unibody(scene, ['output.every=0'], folder(scene), ranks, arguments.core, arguments.frames)
            contacts, iterations, solve = column(rows, 'contacts'), column(rows, 'iterations'), column(rows, 'wall_solve')
            work = sum(c * i for c, i in zip(contacts, iterations))
            each = f'{1e9 * sum(solve) / work:.1f}' if work > 0 else '-'
            lines.append(line(scene, ranks, len(solve), f'{frame_ms(rows):.1f}', f'{statistics.median(contacts):.0f}', each,
                              f'{column(rows, "bytes_per_body")[-1]:.0f}'))
    return lines


# What one iteration of accelerated Jacobi must read and write of a cloth that fits no cache: of each link its slots (8 bytes), length
# (8), multipliers (2 x 8, twice) and mark (8); of each node its moved position (32, twice), impulse (32, four times),
# velocity (64, twice) and position (32).
BYTES_A_LINK, BYTES_A_NODE = 56, 352


def million(arguments):
    """The sweep's share of the bandwidth that a triad reaches, on as many ranks: from the difference of two iteration counts."""
    triad = os.path.join(BUILD, 'scripts', 'rivals', 'triad')
    lines = table(['scene', 'ranks', 'ns a link and iteration', 'sweep GB/s', 'triad GB/s', 'share', 'bytes a node'])
    nodes = 200 if arguments.quick else 1000
    links = 2 * nodes * (nodes - 1) + 2 * (nodes - 1) ** 2
    for ranks in (1, 2):
        say(f'cloth_1m on {ranks}')
        speed = float(command([triad], ranks, arguments.core))
        more = [f'cloths[0].grid.nodes=[{nodes}, {nodes}]', f'cloths[0].pins=[{{node: [0, 0]}}, {{node: [{nodes - 1}, 0]}}]']
        seconds = {}
        for iterations in (10, 30):
            rows = unibody('cloth_1m', more + [f'solver.iterations={iterations}'], folder('cloth_1m'), ranks, arguments.core, 4)
            seconds[iterations] = min(s + h for s, h in zip(column(rows, 'wall_solve'), column(rows, 'wall_halo')))
        each = (seconds[30] - seconds[10]) / 20
        moved = (links * BYTES_A_LINK + nodes * nodes * BYTES_A_NODE) / each / 1e9
        lines.append(line(f'cloth_1m ({nodes} x {nodes})', ranks, f'{1e9 * each / links:.1f}', f'{moved:.1f}', f'{speed:.1f}',
                          f'{moved / speed:.2f}', f'{column(rows, "bytes_per_body")[-1]:.0f}'))
    return lines


MOST_MEMORY, MOST_BYTES, MOST_TIMES = 20 * 2 ** 30, 1300, 11  # B in all, B a body, times as long as a tenth of the bodies


def ten_million(arguments):
    """Ten million spheres beside a million of the same depth, on 2 ranks; --quick: a tenth of both."""
    lines = table(['spheres', 'frames', 's a frame, median', 'contacts a sphere in the last', 'penetration in the last (mm): RMS', 'most', 'peak of all ranks (GiB)',
                   'B a sphere of it', 'B a sphere of the arrays'])
    found = []
    for side in (41, 129) if arguments.quick else (129, 408):
        count, width = 60 * side * side, .1025 * side + .08
        say(f'{count:,} spheres')
        path = folder('spheres_10m')
        rows = unibody('spheres_10m', [f'bodies[0].container.size=[{width}, {width}]', f'bodies[1].lattice.count={count}',
                                       f'bodies[1].lattice.columns=[{side}, {side}]', 'output.every=0'], path, 2, arguments.core, arguments.frames)
        with open(os.path.join(path, 'summary.json'), encoding='utf-8') as file:
            peak = json.load(file)['peak_memory']['all_ranks (B)']
        last = {name: column(rows, name)[-1] for name in ('contacts', 'penetration_rms', 'penetration_max', 'bytes_per_body')}
        found.append((count, frame_ms(rows) / 1e3, peak))
        lines.append(line(f'{count:,}', len(rows), f'{found[-1][1]:.2f}', f'{last["contacts"] / count:.2f}', f'{1e3 * last["penetration_rms"]:.2f}',
                          f'{1e3 * last["penetration_max"]:.1f}', f'{peak / 2 ** 30:.2f}', f'{peak / count:.0f}', f'{last["bytes_per_body"]:.0f}'))
    (few, short, _), (many, long, peak) = found
    ratio = long / short * 10 * few / many
    lines += [''] + table(['target', 'measured', ''])
    for target, measured, met in ((f'peak below {MOST_MEMORY / 2 ** 30:.0f} GiB', f'{peak / 2 ** 30:.2f} GiB', peak < MOST_MEMORY),
                                  (f'below {MOST_BYTES} B a sphere', f'{peak / many:.0f}', peak / many < MOST_BYTES),
                                  (f'below {MOST_TIMES} times the time of a tenth', f'{ratio:.2f}', ratio < MOST_TIMES)):
        lines.append(line(target, measured, 'met' if met else 'MISSED'))
    publish('ten_million.md', lines)


def large(arguments):
    lines = spheres(arguments) + [''] + million(arguments)
    publish('large.md', lines)
