"""Hanging cloths with the coarse level: the stretch that it leaves, and its time beside that of sweeps alone with the same stretch."""
from cloth import hanging_cloth
from runs import column, folder, frame_ms, line, publish, say, table, unibody

FRAMES = 300
AIMS = {50: 5e-4, 100: 2e-3, 150: 5e-3, 300: 1e-2}  # of the worst RMS stretch of 300 frames
FASTER = {50: 3, 150: 20}  # than accelerated Jacobi at the same error
MOST_SWEEPS = 150  # accelerated Jacobi's, which an iteration of Newton's method may cost
NEWTON_ITERATIONS = 2  # with the default iterations
SWEEPS = 50
MOST_SWEEPS_ALONE, MOST_STEPS = 12_800, 500  # a frame; more are not tried
SHORT = {50: 100, 100: 60, 150: 60, 300: 20}  # frames of the comparison in time, in which the cloth falls


def run(nodes, frames, solver, iterations, more, arguments):
    settings = hanging_cloth(nodes, 'both', solver, iterations, ['output.every=0', *more])
    rows = unibody('cloth_50', settings, folder('coarse'), 1, arguments.core, frames)
    worst = [max(column(rows, next(h for h in rows[0] if h.startswith(kind)).split('(')[0].strip())) for kind in ('stretch_rms', 'stretch_max')]
    energy = column(rows, 'total_energy')
    rise = max(b - a for a, b in zip(energy, energy[1:])) / energy[0]
    return {'ms': frame_ms(rows), 'rms': worst[0], 'max': worst[1], 'rise': rise}


def with_coarse_level(nodes, frames, arguments):
    return run(nodes, frames, 'accelerated_jacobi', SWEEPS, ['solver.coarse=true'], arguments)


def many_sweeps(nodes, frames, work, arguments):
    return run(nodes, frames, 'accelerated_jacobi', work, [], arguments)


def many_steps(nodes, frames, work, arguments):
    return run(nodes, frames, 'gauss_seidel', 1, [f'time.substeps={work}', 'solver.warm_start=0'], arguments)


def verdict(aim, met):
    return '' if aim is None else f'{aim}: {"met" if met else "MISSED"}'


def stretch(sizes, arguments):
    lines = ['What the coarse level leaves in the fall and the swing, with 50 iterations', '']
    lines += table(['nodes', 'worst RMS stretch', 'aim', 'worst stretch', 'largest rise of the energy in a frame, over the energy', 'ms a frame'])
    for nodes in sizes:
        say(f'cloth of {nodes} x {nodes}, coarse level, {arguments.frames or FRAMES} frames')
        found = with_coarse_level(nodes, arguments.frames or FRAMES, arguments)
        lines.append(line(f'{nodes} x {nodes}', f'{found["rms"]:.1e}', verdict(f'at most {AIMS[nodes]:g}', found['rms'] <= AIMS[nodes]),
                          f'{found["max"]:.1e}', f'{found["rise"]:.1e}', f'{found["ms"]:.3g}'))
    return lines


def least_work(nodes, frames, rms, others, first, most, arguments):
    """(the least work of `others` that leaves no more than this RMS, what it came to); of more than `most` only a bound."""
    work = first
    while work <= most:
        say(f'cloth of {nodes} x {nodes}: {others.__name__} {work}')
        found = others(nodes, frames, work, arguments)
        if found['rms'] <= rms:
            break
        if work * 3 // 2 > most:
            break
        work = work * 3 // 2
    return work, found


def times(sizes, arguments):
    lines = ['Time beside other ways to the same RMS stretch, with the least work (200, 300, 450 ... sweeps of accelerated Jacobi;',
             '40, 60, 90 ... steps a frame, each of one sweep of Gauss-Seidel, cold) that leaves no more of it', '']
    lines += table(['nodes', 'RMS stretch', 'ms a frame', 'sweeps', 'their time over ours', 'aim', 'steps', 'their time over ours',
                    "a Newton iteration's cost in sweeps", 'aim'])
    for nodes in sizes:
        frames = arguments.frames or SHORT[nodes]
        ours, few = with_coarse_level(nodes, frames, arguments), many_sweeps(nodes, frames, SWEEPS, arguments)
        sweeps, one = least_work(nodes, frames, ours['rms'], many_sweeps, 4 * SWEEPS, MOST_SWEEPS_ALONE, arguments)
        steps, other = least_work(nodes, frames, ours['rms'], many_steps, 40, MOST_STEPS, arguments)
        ratio, cost = one['ms'] / ours['ms'], (ours['ms'] - few['ms']) / NEWTON_ITERATIONS / (few['ms'] / SWEEPS)
        aim = FASTER.get(nodes)
        bound = ['' if found['rms'] <= ours['rms'] else 'more than ' for found in (one, other)]
        lines.append(line(f'{nodes} x {nodes}', f'{ours["rms"]:.1e}', f'{ours["ms"]:.3g}', f'{bound[0]}{sweeps}', f'{bound[0]}{ratio:.2g}',
                          verdict(aim and f'at least {aim}', aim and ratio >= aim), f'{bound[1]}{steps}', f'{bound[1]}{other["ms"] / ours["ms"]:.2g}',
                          f'{cost:.0f}', verdict(f'at most {MOST_SWEEPS}', cost <= MOST_SWEEPS)))
    return lines


def coarse(arguments):
    sizes = arguments.nodes or ([50] if arguments.quick else list(AIMS))
    publish('coarse.md', stretch(sizes, arguments) + [''] + times(sizes, arguments))
