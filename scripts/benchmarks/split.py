"""How the iterations of a step are split between its two stages, and what of the second leaks into the first: piles at rest."""
import statistics

from runs import column, folder, line, publish, say, table, unibody

SCENES = {'boxes_2000': 600, 'boxes_walled_2000': 600, 'spheres_5000': 500, 'towers_2000': 400}  # frames until they rest
SOLVERS = {'AJ': ('accelerated_jacobi', (20, 50, 100)), 'GS': ('gauss_seidel', (10, 20, 40))}
SPLITS = ((.5, 0), (.5, .3), (.8, 0), (.8, .3), (.8, .6), (.9, 0), (.9, .3))  # velocity_share, leak


def split(arguments):
    """Errors as the program itself reports them; all settings of a scene see the same pairs."""
    lines = table(['scene', 'solver', 'velocity share', 'leak', 'penetration RMS (mm)', 'max (mm)', 'peak max (mm)', 'KE/body (J)'])
    for scene, frames in SCENES.items():
        for short, (solver, counts) in SOLVERS.items():
            for iterations in counts[1:2] if arguments.quick else counts:
                for share, leak in SPLITS:
                    say(f'split: {scene} {short} {iterations}, {share}, {leak}')
                    settings = [f'solver.name={solver}', f'solver.iterations={iterations}', f'solver.velocity_share={share}', f'solver.leak={leak}']
                    rows = unibody(scene, settings + ['output.every=0'], folder('split'), 1, arguments.core, arguments.frames or frames)
                    rms, most = column(rows, 'penetration_rms'), column(rows, 'penetration_max')
                    bodies = 5000 if scene == 'spheres_5000' else 2000
                    lines.append(line(scene, f'{short} {iterations}', share, leak, f'{1e3 * statistics.median(rms[-100:]):.2g}',
                                      f'{1e3 * statistics.median(most[-100:]):.2g}', f'{1e3 * max(most):.3g}',
                                      f'{statistics.median(column(rows, "kinetic_energy")[-100:]) / bodies:.1e}'))
                    publish('split.md', lines, show=False)
    publish('split.md', lines)
