"""Nothing may diverge, however few the iterations: each cloth for 2,000 frames; the greatest stretch of all frames, and the energy."""
from runs import column, folder, line, publish, say, table, unibody
from cloth import hanging_cloth


def stability(arguments):
    lines = table([
        'cloth', 'h (s)', 'program', 'warm start', 'finished', 'max stretch, worst frame', 'largest energy / at the start',
        'KE at the end (J)'])
    frames = arguments.frames or 2000
    for nodes in arguments.nodes or (50, 100, 150):
        for step in (.016, 1 / 24):
            for iterations in arguments.iterations or (5, 10, 20, 50, 100):
                for solver in arguments.solvers or ('accelerated_jacobi', 'gauss_seidel', 'jacobi'):
                    for warm in ('0', 'auto'):
                        say(f'stability {nodes} {step:.4f} {solver} {iterations} {warm}')
                        more = ['output.every=0', f'solver.warm_start={warm}', f'time.frame={step:.17g}']
                        rows = unibody('cloth_50', hanging_cloth(nodes, 'both', solver, iterations, more), folder('stability'), 1,
                                       arguments.core, frames)
                        name = next(h for h in rows[0] if h.startswith('stretch_max'))
                        total, kinetic = column(rows, 'total_energy'), column(rows, 'kinetic_energy')
                        lines.append(line(f'{nodes} x {nodes}', f'{step:.4f}', f'{solver} {iterations}', warm, len(rows),
                                          f'{max(float(r[name]) for r in rows):.3g}', f'{max(total) / total[0]:.3f}', f'{kinetic[-1]:.3g}'))
                        publish('stability.md', lines, show=False)
    publish('stability.md', lines)
