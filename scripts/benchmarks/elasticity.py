"""Elastic solids against published figures: closed forms, beams, the elastica, Cook's membrane, torsion; on meshes refined twice.

Equilibria and small vibrations by the solver `newton`, so that what is left is the error of the mesh. Linear theory is met by
loads so small that the St. Venant-Kirchhoff law is linear, and scaling back.
"""
import collections
import functools
import math

import numpy as np

from runs import line, publish, say, table
from solids import bar, couple, moved, part, solve, turned
from tetrahedra import membrane, round_bar

SMALL = 1e-3  # of a length, where linear theory is asked for
LIGHT = .05  # N: of MacNeal & Harder's beam, whose locked ones would not feel much less above round-off

# Inextensible cantilever under a dead load P at its end: P L^2 / EI, and where the end is (down, back) over L.
ELASTICA = {.5: (.16214, .01592), 1: (.30172, .05643), 2: (.49346, .16064), 3: (.60325, .25442), 5: (.71379, .38763), 10: (.81061, .55500)}
MACNEAL = (3.0e-5, .1081, .4321, .03208)  # MacNeal & Harder's straight beam: unit load along, in its plane, out of it; unit couple

Figure = collections.namedtuple('Figure', 'name published power', defaults=(-1,))  # its power of this grows as the stiffness
Case = collections.namedtuple('Case', 'figures measure sizes cells')  # measure(size) gives all figures of a mesh


def uniform_cases(young=1e6, poisson=.3):
    """(name, published, found): a block whose faces bear the dead forces of a uniform deformation's stress, held at its middle.

    It is judged by F^T F, which does not depend on how it has turned: nothing but its inertia resists that.
    """
    lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
    pulled, pressed = (np.diag([l] + [math.sqrt(1 - poisson * (l * l - 1))] * 2) for l in (1.2, .8))
    sheared = np.eye(3) + .3 * np.outer(np.eye(3)[0], np.eye(3)[1])
    for name, gradient, entry in (('pulled by E l (l^2 - 1) / 2 to l = 1.2: l^2', pulled, (0, 0)), ('its stretch across, squared', pulled, (1, 1)),
                                  ('pressed so to l = .8: l^2', pressed, (0, 0)), ('simple shear by .3: C12', sheared, (0, 1)),
                                  ('even tension to l = 1.1: l^2', 1.1 * np.eye(3), (2, 2))):
        strain = (gradient.T @ gradient - np.eye(3)) / 2
        stress = gradient @ (lame * np.trace(strain) * np.eye(3) + 2 * shear * strain)
        loads = [(part(axis, side / 2), side * stress[:, axis]) for axis in range(3) for side in (-1, 1)]
        found = solve({'block': {'size': [1, 1, 1], 'cells': [2, 2, 2]}}, young, poisson, loads, [[1, 1, 1]])
        fitted = np.linalg.lstsq(found.rest, found.places[-1], rcond=None)[0]
        yield name, (gradient.T @ gradient)[entry], (fitted @ fitted.T)[entry]


def macneal(across):
    """Displacements of the tip of MacNeal & Harder's beam under unit loads, its twist under a unit couple."""
    length, width, height = size = (6, .2, .1)

    def under(loads):
        return solve(bar(size, (30 * across, across, across)), 1e7, .3, loads, [part(0, 0)])

    tips = [moved(under([(part(0, length), LIGHT * direction)]), 0, length) @ direction / LIGHT for direction in np.eye(3)]
    lever = (width + height) / 2  # of the forces on both pairs of halves, at the halves' middles
    return tips + [turned(under(couple(0, length, LIGHT / lever)), 0, length) / LIGHT]


def bent(across, poisson):
    """Out-of-plane displacement of that beam's tip, over a beam's with shear: the locking of linear tetrahedra."""
    length, width, height = size = (6, .2, .1)
    found = solve(bar(size, (30 * across, across, across)), 1e7, poisson, [(part(0, length), (0, 0, LIGHT))], [part(0, 0)])
    return moved(found, 0, length)[2] / (LIGHT * tip_compliance(1e7, poisson, length, width, height))


def tip_compliance(young, poisson, length, width, height):
    """m/N, of a cantilever with a load at its end: bending, and shear with 5/6 of the section."""
    area, bending = width * height, young * width * height ** 3 / 12
    return length ** 3 / (3 * bending) + length / (5 / 6 * young / (2 * (1 + poisson)) * area)


class Cantilever:
    """A beam of 1 m with a square section, loaded so that its end moves by about 1 mm.

    Without Poisson's ratio the beam's theory is exact but for its clamped end, and one cell across the width is enough.
    """
    young, length, height, density = 1e6, 1, .1, 1000

    def __init__(self, across, poisson):
        self.poisson = poisson
        self.shape = bar((self.length, self.height, self.height), (10 * across, across if poisson else 1, across))
        self.area, self.bending = self.height ** 2, self.young * self.height ** 4 / 12
        self.load = 3 * SMALL * self.bending / self.length ** 3
        self.rate = 1.8751 ** 2 * math.sqrt(self.bending / (self.density * self.area * self.length ** 4))  # rad/s, slender

    def figures(self):
        return [self.tip(loads=[(part(0, self.length), (0, 0, self.load))]), -self.tip(gravity=(0, 0, -self.load / self.area), density=1),
                self.frequency()]

    def published(self):
        """With shear, and for the frequency shear and rotary inertia to first order."""
        radius2, shear = self.height ** 2 / 12, 5 / 6 * self.area * self.young / (2 * (1 + self.poisson))
        slope = 4.648 / self.length ** 2  # of the first mode: integral of w'^2 over that of w^2
        return [self.load * tip_compliance(self.young, self.poisson, self.length, self.height, self.height),
                self.load * (self.length ** 4 / (8 * self.bending) + self.length ** 2 / (2 * shear)),
                self.rate / (2 * math.pi) * (1 - slope / 2 * (radius2 + self.bending / shear))]

    def tip(self, **settings):
        return moved(solve(self.shape, self.young, self.poisson, pins=[part(0, 0)], **settings), 0, self.length)[2]

    def frequency(self):
        """Hz, of the first mode, from a throw. Implicit Euler multiplies a mode by z = 1 / (1 - i omega h) in a step, whatever the h,
        and has damped the higher ones when we begin to look. Four terms: the bar swings sideways, too.
        """
        step = 2 * math.pi / self.rate / 20
        found = solve(self.shape, self.young, self.poisson, pins=[part(0, 0)], step=step, frames=40, density=self.density,
                      more={'velocity': [0, 0, 3 * SMALL * self.rate]})
        heights = np.array([moved(found, 0, self.length, frame)[2] for frame in range(12, 40)])
        terms = np.stack([heights[k:k - 4] for k in range(4)], axis=1)
        recurrence = np.linalg.lstsq(terms, heights[4:], rcond=1e-13)[0]
        rates = abs((1 / np.roots([1, *-recurrence[::-1]])).imag) / step
        return rates[np.argmin(abs(rates - self.rate))] / (2 * math.pi)


def cantilever(across, poisson):
    return Cantilever(across, poisson).figures()


def elastica(across, load):
    """Where the end of a slender beam under a dead load is: down, back."""
    young, length, height = 1e6, 1, 1 / 32
    force = load * young * height ** 4 / 12 / length ** 2
    found = solve(bar((length, height, height), (32 * across, 1, across)), young, 0, [(part(0, length), (0, 0, force))], [part(0, 0)])
    tip = moved(found, 0, length)
    return [tip[2], -tip[0]]


def cook(cells, poisson):
    """Rise of the middle of the right side."""
    shape = membrane(cells)
    found = solve(shape, 1, poisson, [(part(0, 48), (0, .1 * SMALL, 0))], [part(0, 0)])
    middle = np.isclose(found.rest[:, 0], 48) & np.isclose(found.rest[:, 1], 52)
    return [(found.places[-1] - found.rest)[middle, 1].mean() / (.1 * SMALL)]


def torsion(across, poisson):
    """Of a round bar under a couple: twist over T L / GJ, and Poynting's lengthening over (twist x radius / length)^2.

    Both between a quarter and three quarters of the length, away from how the ends are held and loaded.
    """
    radius, length, young, strain = 1, 6, 1e6, SMALL
    points, tets = round_bar(across, 2 * across, radius, length)
    torque = young / (2 * (1 + poisson)) * math.pi / 2 * radius ** 3 * strain
    force = torque / (4 * lever_of_half(points[np.isclose(points[:, 2], length)], radius))
    found = solve((points, tets), young, poisson, couple(2, length, force), [part(2, 0)])
    ends = (length / 4, 3 * length / 4)
    twist = (turned(found, 2, ends[1]) - turned(found, 2, ends[0])) * radius / (ends[1] - ends[0])
    longer = (moved(found, 2, ends[1])[2] - moved(found, 2, ends[0])[2]) / (ends[1] - ends[0])
    return [twist / strain, longer / twist ** 2]


def lever_of_half(points, radius):
    """m, how far the middle of half a polygon, that with x > 0, is from the y axis."""
    rim = points[np.isclose(np.hypot(points[:, 0], points[:, 1]), radius) & (points[:, 0] > -1e-9 * radius)]
    x, y, _ = rim[np.argsort(np.arctan2(rim[:, 1], rim[:, 0]))].T
    twice = x * np.roll(y, -1) - np.roll(x, -1) * y
    return float((twice * (x + np.roll(x, -1))).sum() / (3 * twice.sum()))


def poynting(poisson):
    """Lengthening over (twist x radius / length)^2 of a round bar free to shorten, to second order: St. Venant-Kirchhoff shortens.

    Of the energy of the strains E_rr = (ru)', E_tt = u, E_zz = e + (kr)^2 / 2, E_tz = kr (1 + 2u) / 2, u the radial strain and k the
    twist by length, the minimum over u(r) and e: a fibre on a helix is longer, and resists that.
    """
    return -(1 - poisson) / (4 * (1 + poisson))


def rows_of(case):
    """Rows of the table: each figure on three meshes, each twice as fine as the one before.

    Coarse linear tetrahedra are too stiff, by a share that goes with h^2 long before the displacements do. So order and limit
    (Richardson's, of order 2) are those of the stiffness; no limit is given where the meshes are too coarse to have an order.
    """
    found = []
    for size in case.sizes:
        say(f'{case.figures[0].name}: {size} cells {case.cells}')
        found.append(case.measure(size))
    for figure, values in zip(case.figures, zip(*found)):
        first, second, third = (math.copysign(abs(value) ** figure.power, value) for value in values)
        ratio, limit = (second - first) / (third - second), third + (third - second) / 3
        limit = math.copysign(abs(limit) ** (1 / figure.power), limit)
        last = [f'{math.log2(ratio):.2f}', f'{limit:.4g}', share(limit, figure)] if ratio > 2 else ['-'] * 3
        yield line(figure.name, f'{figure.published:.4g}' if figure.published else '-', f'{", ".join(map(str, case.sizes))} {case.cells}',
                   *(f'{value:.4g}' for value in values), share(values[-1], figure), *last)


def share(value, figure):
    return f'{value / figure.published:.3f}' if figure.published else '-'


def cases(quick):
    planar, solid = ((2, 4, 8), (2, 4, 8)) if quick else ((4, 8, 16), (2, 4, 8))
    names = ('along', 'in its plane', 'out of it', 'twist')
    yield Case([Figure(f"MacNeal & Harder's beam: {name} ({unit})", value) for name, unit, value in zip(names, ('m', 'm', 'm', 'rad'), MACNEAL)],
               macneal, solid, 'across')
    for poisson, sizes in ((0, planar), (.3, solid)):
        tip, weight, rate = Cantilever(1, poisson).published()
        yield Case([Figure(f'cantilever, nu {poisson}: load at its end (m)', tip), Figure(f'cantilever, nu {poisson}: own weight (m)', weight),
                    Figure(f'cantilever, nu {poisson}: first frequency (Hz)', rate, 2)],
                   functools.partial(cantilever, poisson=poisson), sizes, 'across')
    for load, (down, back) in ELASTICA.items():
        yield Case([Figure(f'elastica, P L^2 / EI = {load}: down / L', down), Figure(f'elastica, P L^2 / EI = {load}: back / L', back)],
                   functools.partial(elastica, load=load), planar, 'across')
    for name, poisson, published in (('1/3', 1 / 3, 23.96), ('.49', .49, None), ('.4999', .4999, None)):
        yield Case([Figure(f"Cook's membrane, nu {name}", published)], functools.partial(cook, poisson=poisson),
                   (8, 16, 32) if quick else (16, 32, 64), 'a side')
    for poisson in (0, .3):
        yield Case([Figure(f'round bar, nu {poisson}: twist over T L / GJ', 1),
                    Figure(f'round bar, nu {poisson}: lengthening over (twist R / L)^2', poynting(poisson), 1)],
                   functools.partial(torsion, poisson=poisson), planar, 'across')


def elasticity(arguments):
    lines = table(['a block of 6 x 8 tetrahedra', 'closed form', 'ours', 'relative difference'])
    for name, expected, found in uniform_cases():
        lines.append(line(name, f'{expected:.6g}', f'{found:.6g}', f'{abs(found / expected - 1):.1e}'))
    lines += [''] + table(['case', 'published', 'cells', 'coarse', 'medium', 'fine', 'fine / published', 'order', 'limit', 'limit / published'])
    for case in cases(arguments.quick):
        lines += rows_of(case)
        publish('elasticity.md', lines, show=False)
    across = (1, 2, 4) if arguments.quick else (1, 2, 4, 8)
    lines += [''] + table(["MacNeal & Harder's beam, out of its plane: displacement over theory"] + [f'{n} across' for n in across])
    for poisson in (0, .3, .49, .499):
        say(f'locking, nu {poisson}')
        lines.append(line(f'nu {poisson}', *(f'{bent(n, poisson):.3f}' for n in across)))
    publish('elasticity.md', lines)
