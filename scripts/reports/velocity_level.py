"""Figure 8: penetration over time of a pile of boxes, velocity time stepping against position projection."""
import statistics

from page import Section, Table, draw
from maker import Failed

TITLE = 'Figure 8: velocity level against position level'
GS = ['solver.name=gauss_seidel', 'solver.iterations=10']
AJ = ['solver.name=accelerated_jacobi', 'solver.iterations=10']
COLD = ['solver.warm_start=0']
VELOCITY = ['solver.level=velocity']
POSITION = ['solver.stages=position', 'solver.recovery_time=0', 'solver.recovery_speed=0']  # as the paper's: in one step, at any speed
CASES = {'velocity level, GS 10, cold': GS + VELOCITY + COLD, 'position level, GS 10, cold': GS + POSITION + COLD,
         'velocity level, AJ 10, cold': AJ + VELOCITY + COLD, 'position level, AJ 10, cold': AJ + POSITION + COLD,
         'velocity level, GS 10, all old multipliers kept': GS + VELOCITY + ['solver.warm_start=1'],
         'two stages, GS 10 (ours by default)': GS, 'two stages, GS 50': ['solver.name=gauss_seidel', 'solver.iterations=50']}


def make(maker):
    frames = maker.pick(15, 400, 400)
    scene = maker.pick(['bodies[1].lattice.count=30'], [], [])
    found, rows = {}, []
    for name, settings in CASES.items():
        try:
            run = maker.run('boxes_2000', scene + settings + [f'time.frames={frames}'], look=['measure'])
        except Failed as fault:
            if 'level' not in str(fault):
                raise
            rows.append([name] + [None] * 5)
            maker.say(f'{name}: not available, this program has no solver.level')
            continue
        m, kinetic = run.seen, run.column('kinetic_energy')
        found[name] = m['frame_l2_mm']
        rows.append([name, statistics.mean(m['frame_l2_mm']), m['peak_l2_mm'], m['l2_mm'], max(kinetic), run.frame_ms()])
    table = Table(
        'velocity_level', '2000 boxes: L2 of the penetration of all pairs (mm), measured from the poses',
        ['solver', 'mean of all frames', 'peak', 'settled (last 100)', 'largest kinetic energy (J)', 'ms a frame'], rows,
        'scripts/report velocity_level')

    def paint(axis):
        for name, values in found.items():
            axis.semilogy([max(v, 1e-3) for v in values], label=name, lw=1)
        axis.set(xlabel='frame', ylabel='penetration L2 (mm)')
        axis.legend(fontsize=7)

    plot = draw(
        'velocity_level', '2000 falling boxes, penetration (L2, mm) frame by frame: velocity level and position level', paint,
        command='scripts/report velocity_level')
    return Section(
        TITLE,
        [
            (
                'The paper has a plot without numbers (10 iterations, mu = 0.3, stabilisation 0.4) and concludes that position'
                ' projection leaves less penetration with many bodies. Its curves hold the sum over contact points of its own'
                ' detection; ours are per pair of bodies, from their poses alone.'
            ),
            (
                'Each step started cold, as in the paper, ours agree: what iterations leave undone sinks in by 1 / gamma, 2.5'
                ' times as far at velocity level. What its figure does not show is that the velocity level may keep its'
                ' multipliers, and a velocity stage before the position stage may too, as ours by default does. Contacts here are'
                ' made before bodies touch, at both levels, which takes much of the penetration out of the impact.'
            ),
        ],
        [table],
        [plot],
    )
