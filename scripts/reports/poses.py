"""What the report wants to know of a run's frames: functions (maker, folder, ...) -> something JSON can hold."""
import csv
import importlib.machinery
import json
import os
import subprocess

import h5py
import numpy as np

from runs import ROOT

TRAJECTORY = importlib.machinery.SourceFileLoader('trajectory_error', os.path.join(ROOT, 'scripts', 'trajectory_error')).load_module()


def frames_of(file):
    return sorted(file['frames'], key=int)


def path_of(_, folder):
    """Travel of the mean of all dynamic bodies since frame 0, [frames][3] in m."""
    with h5py.File(os.path.join(folder, 'frames.h5')) as file:
        moves = file['bodies/motion'][:] == 0
        means = [file[f'frames/{name}/position'][:][moves].mean(0) for name in frames_of(file)]
    return (np.array(means) - means[0]).tolist()


def measured(maker, folder, *options):
    """What scripts/rivals/measure says of the run as a whole, and L2 and max of each frame (mm)."""
    return measure_file(maker, os.path.join(folder, 'frames.h5'), *options)


def measure_file(maker, path, *options):
    table = path + '.csv'
    words = [os.path.join(maker.rivals, 'measure'), '--json', *options, '--frames', table, path]
    text = subprocess.run(words, check=True, text=True, capture_output=True).stdout
    result = json.loads(text)
    with open(table, encoding='utf-8') as file:
        rows = list(csv.DictReader(file))
    os.remove(table)
    result['frame_l2_mm'] = [float(r['l2_mm']) for r in rows]
    result['frame_max_mm'] = [float(r['max_mm']) for r in rows]
    return result


def distance_of_last(folder, reference):
    """Distance (m) of two runs of the same bodies in the last frame of `reference`, as scripts/trajectory_error has it."""
    a, b = TRAJECTORY.Run(folder), TRAJECTORY.Run(reference)
    return float(TRAJECTORY.distances(a, b, b.frames[-1], b.frames[-1])[-1])


def away(_, folder, *references):
    """Distances (m) from references, each in the last frame that the reference has."""
    return [distance_of_last(folder, reference) for reference in references]


def chain(maker, folder, reference=None):
    """Drift of a chain's joints, and how far (m) its bodies' centres are at the end from those of a reference: root mean square by mass."""
    path = os.path.join(folder, 'frames.h5')
    result = measure_file(maker, path, '--chain')
    result['away'] = None
    if reference:
        with h5py.File(path) as a, h5py.File(os.path.join(reference, 'frames.h5') if os.path.isdir(reference) else reference) as b:
            last = frames_of(a)[-1]
            mass, moves = a['bodies/mass'][:], a['bodies/motion'][:] == 0
            square = ((a[f'frames/{last}/position'][:] - b[f'frames/{last}/position'][:]) ** 2).sum(1)
        result['away'] = float(np.sqrt((mass * square)[moves].sum() / mass[moves].sum()))
    return result


def copied(_, folder, to):
    """Keeps the frames at `to`."""
    os.replace(os.path.join(folder, 'frames.h5'), to)
    return to


LOOKS = {'path': path_of, 'measure': measured, 'away': away, 'chain': chain, 'copy': copied}
