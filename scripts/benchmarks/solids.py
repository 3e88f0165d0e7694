"""Runs one elastic solid by the solver `newton`, and reads what its parts have done."""
import collections
import json
import math
import os
import tempfile

import h5py
import numpy as np

from runs import column, say, unibody
from tetrahedra import write_msh

HUGE = 1e4  # s: one step of implicit Euler, far longer than any period, is the equilibrium
FAR = 1e3  # m: outside of every solid

Solution = collections.namedtuple('Solution', 'rest places')  # m, [nodes, 3]; the same of each frame


def part(axis, least, most=None):
    """The box between two planes across an axis, or what lies in the first."""
    box = {'min': [-FAR] * 3, 'max': [FAR] * 3}
    box['min'][axis], box['max'][axis] = least, least if most is None else most
    return box


def both(one, other):
    return {'min': np.maximum(one['min'], other['min']).tolist(), 'max': np.minimum(one['max'], other['max']).tolist()}


def solve(shape, young, poisson, loads=(), pins=(), step=HUGE, frames=1, density=None, gravity=(0, 0, 0), more=None):
    """Runs a solid; `shape` is a block's or (places, tetrahedra), loads are pairs of a box and a force, pins boxes or nodes."""
    with tempfile.TemporaryDirectory() as folder:
        solid = {'density': density or 1e-9 * young, 'youngs_modulus': young, 'poissons_ratio': poisson, 'thickness': 1e-3, **(more or {})}
        if isinstance(shape, dict):
            solid.update(shape)
        else:
            write_msh(os.path.join(folder, 'solid.msh'), *shape)
            solid['mesh'] = 'solid.msh'
        solid['loads'] = [{'within': box, 'force': list(force)} for box, force in loads]
        solid['pins'] = [{'within': pin} if isinstance(pin, dict) else {'node': pin} for pin in pins]
        scene = {'time': {'frame': step, 'frames': frames}, 'gravity': list(gravity), 'solver': {'name': 'newton'},
                 'solids': [{key: value for key, value in solid.items() if value != []}]}
        path = os.path.join(folder, 'scene')
        with open(path + '.yaml', 'w', encoding='utf-8') as file:
            json.dump(scene, file)  # JSON is YAML
        rows = unibody(path, [], os.path.join(folder, 'out'), 1, None, 0)
        with h5py.File(os.path.join(folder, 'out', 'frames.h5')) as file:
            places = [file['frames'][name]['position'][:] for name in sorted(file['frames'], key=int)]
    if not all(column(rows, 'converged')[1:]):
        say('not converged')
        places[-1] = np.full_like(places[-1], np.nan)
    return Solution(places[0], places[1:])


def bar(size, cells):
    """A block from x = 0 along x, its axis on y = z = 0."""
    return {'block': {'size': list(size), 'cells': list(cells)}, 'position': [size[0] / 2, 0, 0]}


def moved(solution, axis, at, frame=-1):
    """The mean displacement of the nodes in a plane across an axis."""
    rest = solution.rest
    return (solution.places[frame] - rest)[np.isclose(rest[:, axis], at, atol=1e-9)].mean(axis=0)


def turned(solution, axis, at):
    """rad, by how much the nodes in a plane across an axis have turned about it."""
    here = np.isclose(solution.rest[:, axis], at, atol=1e-9)
    one, two = (axis + 1) % 3, (axis + 2) % 3
    rest, now = (p[here][:, [one, two]] - p[here][:, [one, two]].mean(axis=0) for p in (solution.rest, solution.places[-1]))
    return math.atan2((rest[:, 0] * now[:, 1] - rest[:, 1] * now[:, 0]).sum(), (rest * now).sum())


def couple(axis, at, force):
    """Loads on an end face that turn it about an axis: force (N) on each half of it, across the line that halves it, both ways."""
    one, two = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
    end = part(axis, at)
    for across, along in (((axis + 1) % 3, two), ((axis + 2) % 3, -one)):
        yield both(end, part(across, 0, FAR)), force * along
        yield both(end, part(across, -FAR, 0)), -force * along
