"""Figure 10: kinetic energy of a hanging cloth with and without damping, and the stretch beside it."""
import statistics

from page import Section, Table, draw

TITLE = 'Figure 10: damping of a hanging cloth'
CASES = {'rho = 0': ('0', 50), 'rho = 10 h': ('0.16', 50), 'rho = 0, 500 iterations': ('0', 500), 'rho = 10 h, 500 iterations': ('0.16', 500)}


def make(maker):
    frames = maker.pick(20, 400, 800)
    size = maker.pick(['cloths[0].grid.nodes=[8, 8]', 'cloths[0].pins=[{node: [0, 0]}, {node: [7, 0]}]'], [], [])
    found, rows = {}, []
    for name, (rho, iterations) in CASES.items():
        run = maker.run('cloth_hanging', size + [f'cloths[0].links.damping={rho}', f'solver.iterations={iterations}', f'time.frames={frames}'])
        kinetic, stretch = run.column('kinetic_energy'), run.column('stretch_rms')
        found[name] = kinetic, stretch
        late = frames // 2
        rows.append([
            name, max(kinetic), statistics.mean(kinetic[late:]), statistics.median(stretch[late:]),
            statistics.median(run.column('stretch_max')[late:])])
    table = Table(
        'hanging_cloth', f'30 x 30 nodes, 10 kg, h = 16 ms, {frames} frames; the last columns: second half of the run',
        ['damping', 'largest kinetic energy (J)', 'mean kinetic energy, second half (J)', 'stretch RMS', 'stretch max'], rows,
        'scripts/report hanging_cloth')

    def paint(axes):
        for name, (kinetic, stretch) in found.items():
            axes[0].plot(kinetic, label=name, lw=1)
            axes[1].semilogy([max(s, 1e-6) for s in stretch], label=name, lw=1)
        axes[0].set(xlabel='frame', ylabel='kinetic energy (J)')
        axes[1].set(xlabel='frame', ylabel='stretch RMS')
        axes[0].legend(fontsize=7)

    plot = draw('hanging_cloth', 'A hanging cloth, kinetic energy and stretch', paint, wide=2, command='scripts/report hanging_cloth')
    return Section(
        TITLE,
        [
            (
                'The paper shows a plot without numbers: undamped, the energy oscillates for long; with rho = 10 h it is gone'
                ' quickly.'
            ),
            (
                'Why ours differs: damping along constraints cannot act on swinging that stretches nothing. What kills the energy'
                ' at 50 iterations is that damping on stiff links slows their correction: the cloth is then elastic (last'
                ' columns) and its motion does stretch it. Converged, both cloths keep swinging.'
            ),
        ],
        [table],
        [plot],
    )
