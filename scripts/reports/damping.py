"""The paper's damping against XPBD's on the same cloth: one formula, two parameters."""
import statistics

from page import Section, Table

TITLE = "The paper's damping against XPBD's"


def make(maker):
    frames = maker.pick(10, 200, 400)
    size = maker.pick(['cloths[0].grid.nodes=[8, 8]', 'cloths[0].pins=[{node: [0, 0]}, {node: [7, 0]}]'], [], [])
    stiffnesses = maker.pick((1e3,), (1e2, 1e3, 1e4), (1e2, 1e3, 1e4, 1e5))
    rho, beta = .16, 160.  # s; N s/m: equal at 1e3 N/m
    rows = []
    for k in stiffnesses:
        for name, damping in (('none', 0.), ("the paper's, rho = 0.16 s", rho), ("XPBD's, beta = 160 N s/m", beta / k)):
            run = maker.run(
                'cloth_hanging',
                size
                + [
                    f'cloths[0].links.stiffness={k:.1e}', f'cloths[0].links.damping={damping:.9g}', 'solver.iterations=100',
                    f'time.frames={frames}'],
            )
            late = frames // 2
            kinetic = run.column('kinetic_energy')
            rows.append([
                k, name, damping, statistics.mean(kinetic[late:]), statistics.median(run.column('stretch_rms')[late:]),
                run.column('total_energy')[-1] - run.column('total_energy')[0]])
    table = Table(
        'damping', f'the cloth of figure 10 with links of stiffness k, 100 iterations, {frames} frames',
        ['k (N/m)', 'damping', 'as rho (s)', 'mean kinetic energy, second half (J)', 'stretch RMS', 'energy lost (J)'], rows,
        'scripts/report damping')
    return Section(
        TITLE,
        [
            (
                'XPBD with compliance a = 1/k and damping b solves (1 + g) grad C W grad C + a / h^2 with g = a b / h; times h^2'
                ' that is h (h + rho) D W D + 1/k with rho = b / k: the paper\'s matrix, and the right sides agree too. The two'
                ' are one method with another parameter, so that both are run here by `links.damping` = b / k.'
            ),
            (
                'What differs is what a user holds fixed. With b fixed XPBD\'s damping vanishes as links get stiffer, and there'
                ' is none for a = 0; the paper\'s ratio rho stays, at the price that an unconverged stiff cloth sags more.'
            ),
        ],
        [table],
    )
