"""What the report wants to know of a run's frames: functions (session, folder, ...) -> something JSON can hold."""
import csv
import json
import os
import subprocess
import sys

import h5py
import numpy as np

from runs import ROOT


def frames_of(file):
    return sorted(file['frames'], key=int)


def path_of(_, folder):
    """Travel of the mean of all dynamic bodies since frame 0, [frames][3] in m."""
    with h5py.File(os.path.join(folder, 'frames.h5')) as file:
        moves = file['bodies/motion'][:] == 0
        means = [file[f'frames/{name}/position'][:][moves].mean(0) for name in frames_of(file)]
    return (np.array(means) - means[0]).tolist()


def measured(session, folder, *options):
    """What scripts/rivals/measure says of the run as a whole, and L2 and max of each frame (mm)."""
    return measure_file(session, os.path.join(folder, 'frames.h5'), *options)


def measure_file(session, path, *options):
    table = path + '.csv'
    text = subprocess.run([os.path.join(session.rivals, 'measure'), '--json', *options, '--frames', table, path], check=True, text=True, capture_output=True).stdout
    result = json.loads(text)
    with open(table, encoding='utf-8') as file:
        rows = list(csv.DictReader(file))
    os.remove(table)
    result['frame_l2_mm'] = [float(r['l2_mm']) for r in rows]
    result['frame_max_mm'] = [float(r['max_mm']) for r in rows]
    return result


def away(_, folder, reference):
    """Distance (m) of the last frame from that of a reference, by scripts/trajectory_error; None where there is no such script."""
    script = os.path.join(ROOT, 'scripts', 'trajectory_error')
    if not os.path.exists(script):
        return None
    text = subprocess.run([sys.executable, script, folder, reference, '--frames', 'last'], check=True, text=True, capture_output=True).stdout
    return float(list(csv.DictReader(text.splitlines()))[-1]['distance (m)'])


LOOKS = {'path': path_of, 'measure': measured, 'away': away}
