"""What follows from a curve of time against error: the front, what a target costs, and what the defaults are worth.

A curve is a list of points (setting, ms a frame, errors...) with setting.name(), .ranks and errors in m, None where there is none.
"""
import math
from dataclasses import dataclass

NOISE = .1  # share by which times of one and the same run differ


@dataclass
class Curve:
    scene: str
    size: float       # m, of a body: errors are told as shares of it
    error: str        # what the error is of
    which: int        # its place in a point
    known: float      # m: how far two ways to the reference are apart, at most as far as which the error is known
    points: list

    def measured(self, ranks=None):
        return [p for p in self.points if p[self.which] is not None and (ranks is None or p[0].ranks == ranks)]


def cheapest(curve, limit, ranks=None):
    """The fastest point whose error is at most `limit` (m), or None."""
    return min((p for p in curve.measured(ranks) if p[curve.which] <= limit), key=lambda p: (p[1], p[0].name()), default=None)


def least(curve, ms, ranks=None):
    """The point of least error that takes no longer than `ms`, or None."""
    return min((p for p in curve.measured(ranks) if p[1] <= ms), key=lambda p: (p[curve.which], p[1]), default=None)


def choice(curve, level):
    """What to take to end within `level` of a body's size, or why nothing is said."""
    if curve.known > level * curve.size:
        return f'known to {curve.known / curve.size:.1g} only'
    if best := cheapest(curve, level * curve.size):
        return f'{best[0].name()}: {best[1]:.3g} ms'
    nearest = min(curve.measured(), key=lambda p: p[curve.which], default=None)
    return 'none' if nearest is None else f'none; nearest {nearest[0].name()}: {nearest[curve.which] / curve.size:.1g}'


def standing(curve, default):
    """Where `default` stands among the settings on one rank: [ms, error / size, on the front?, the fastest with no more error, its ms, its
    time / this one's, the best that takes no longer, its error / this one's]; None where it was not measured."""
    own = next((p for p in curve.measured(1) if p[0] == default), None)
    if own is None:
        return None
    fast, good = cheapest(curve, own[curve.which], 1), least(curve, own[1], 1)
    return [own[1], own[curve.which] / curve.size, fast[1] >= (1 - NOISE) * own[1], fast[0].name(), fast[1], fast[1] / own[1],
            good[0].name(), good[curve.which] / own[curve.which] if own[curve.which] > 0 else 1.]


def costs(wishes, setting):
    """Of the wishes (curve, level): in how many `setting` ends within the level, and there the geometric mean of its time over that of the
    cheapest."""
    ratios = []
    for curve, level in wishes:
        own = next((p for p in curve.measured(1) if p[0] == setting), None)
        if own and own[curve.which] <= level * curve.size:
            ratios.append(own[1] / cheapest(curve, level * curve.size, 1)[1])
    return len(ratios), math.exp(sum(map(math.log, ratios)) / len(ratios)) if ratios else None


def one_for_all(wishes):
    """Of the settings that all curves have: the one that fulfils most of the wishes (curve, level), and of those the cheapest on the
    geometric mean, as (setting, how many, the mean of its time over the cheapest's); None where none does any."""
    curves = [c for c, _ in wishes]
    shared = [p[0] for p in curves[0].measured(1) if all(any(p[0] == q[0] for q in c.measured(1)) for c in curves)]
    found = [(setting, *costs(wishes, setting)) for setting in shared]
    return min((f for f in found if f[1]), key=lambda f: (-f[1], f[2], f[0].name()), default=None)
