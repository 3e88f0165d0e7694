"""Runs programs, reads what they report, and writes tables: what the benchmarks have in common."""
import csv
import functools
import os
import statistics
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
OUT = os.path.join(ROOT, 'results', 'bench')
BUILD = os.path.join(ROOT, 'build', 'release')

# The tolerance is 0: every setting does all of its iterations, as the others do. The bodies start apart, so penetration may be taken
# out faster than the default, which is for starts that nobody has looked at.
COMMON = ['solver.tolerance=0', 'solver.recovery_speed=1', 'output.checkpoint_every=-1']
DEFAULTS = ['solver.tolerance=auto', 'solver.recovery_speed=0.25']  # what COMMON changes of them, taken back


@functools.cache
def bound_to_threads():
    """What tells mpirun that each rank keeps to a hardware thread: that of MPICH counts them by itself."""
    is_hydra = 'HYDRA' in subprocess.run(['mpirun', '--version'], text=True, capture_output=True, check=False).stdout
    return ([] if is_hydra else ['--use-hwthread-cpus']) + ['--bind-to', 'hwthread']


def command(words, ranks=0, core=None):
    """Runs `words`, on `ranks` ranks if not 0, pinned to `core` if given; returns what it printed."""
    if ranks:
        spread = os.cpu_count() >= ranks > 1
        words = ['mpirun', '-n', str(ranks)] + (bound_to_threads() if spread else ['--bind-to', 'none']) + words
    if core is not None and ranks < 2:
        words = ['taskset', '-c', str(core)] + words
    shell = 'source "$0/scripts/common.sh"; mpi_environment "$1"; shift; exec "$@"'
    done = subprocess.run(['bash', '-c', shell, ROOT, str(max(ranks, 1))] + words, text=True, capture_output=True, check=False)
    if done.returncode != 0:
        sys.exit(f'bench: failed: {" ".join(words)}\n{done.stdout[-2000:]}{done.stderr[-2000:]}')
    return done.stdout


def unibody(scene, settings, output, ranks, core, frames, start=None, before=(), options=()):
    """`start`: a checkpoint to go on from; `frames` counts those before it too. `before`: words before the program's name."""
    words = [*before, os.path.join(BUILD, 'unibody'), os.path.join(ROOT, 'scenes', scene + '.yaml'), '-output', output, '-overwrite', *options]
    words += ['-start_from', start] if start else []
    for value in COMMON + settings + ([f'time.frames={frames}'] if frames else []):
        words += ['-set', value]
    command(words, ranks, core)
    return report_rows(output)


def report_rows(output):
    with open(os.path.join(output, 'report.csv'), encoding='utf-8') as file:
        return [row for row in csv.DictReader(line for line in file if not line.startswith('#'))]


def column(rows, name):
    """The column called `name`, whose header may add a unit: name (s)."""
    header = next((h for h in rows[0] if h.split('(')[0].strip() == name), None)
    if header is None:
        sys.exit(f'bench: report.csv has no column {name}; it has {", ".join(rows[0])}')
    return [float(row[header]) for row in rows]


def frame_ms(rows):
    parts = [column(rows, name) for name in ('wall_collide', 'wall_solve', 'wall_halo')]
    return 1e3 * statistics.median(sum(values) for values in zip(*parts))


def slowdown(run, core):
    """How much longer what run(core) times takes where the other core does the same: two ranks can't be faster than 2 over this."""
    alone = run(core)
    with ThreadPoolExecutor() as pool:
        return statistics.mean(pool.map(run, range(2))) / alone


def busy_cores(seconds=1):
    """How many cores are at work now, whoever's work it is. (The load average still remembers what ended minutes ago.)"""
    def ticks():
        with open('/proc/stat', encoding='ascii') as file:
            counts = [int(word) for word in file.readline().split()[1:9]]
        return sum(counts), counts[3] + counts[4]  # all, idle or waiting for a disk
    before = ticks()
    time.sleep(seconds)
    total, idle = (b - a for a, b in zip(before, ticks()))
    return os.cpu_count() * (1 - idle / total) if total else 0.


def folder(name):
    """A folder for a run's results, its parents made."""
    path = os.path.join(OUT, 'runs', name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    return path


def say(text):
    print(f'bench: {text}', file=sys.stderr, flush=True)


def table(headings):
    return ['| ' + ' | '.join(headings) + ' |', '|' + '---|' * len(headings)]


def line(*cells):
    return '| ' + ' | '.join(str(c) for c in cells) + ' |'


def publish(name, lines, show=True):
    text = '\n'.join(lines) + '\n'
    with open(os.path.join(OUT, name), 'w', encoding='utf-8') as file:
        file.write(text)
    if show:
        print(text, flush=True)
