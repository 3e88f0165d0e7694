"""A run of hours: whether memory, handles and speed of its ranks stay what they are while bodies come and go."""
import csv
import os
import shutil
import signal
import statistics
import subprocess
import sys
import time

from runs import BUILD, ROOT, folder, line, publish, say, table

SPANS = 12  # rows of the table
COLUMNS = ['hours', 'frames', 'simulated (s)', 'bodies', 'came in', 'memory of the largest rank (MB)', 'handles of a rank', 'threads of a rank',
           'ms a frame', 'total energy a body (J)']


def ranks_of(mpirun):
    """The processes that mpirun has started."""
    with open(f'/proc/{mpirun}/task/{mpirun}/children', encoding='ascii') as file:
        return [int(word) for word in file.read().split()]


def status(process, key):
    with open(f'/proc/{process}/status', encoding='ascii') as file:
        found = [text for text in file if text.startswith(key + ':')]
    if not found:
        raise ValueError(f'{process} has ended')
    return int(found[0].split()[1])


def sample(processes):
    """(memory of the largest (MB), most handles, most threads) of processes that run."""
    return (max(status(p, 'VmRSS') for p in processes) / 1024, max(len(os.listdir(f'/proc/{p}/fd')) for p in processes),
            max(status(p, 'Threads') for p in processes))


def rows_of(output):
    """The rows of report.csv, the last of which may be half written."""
    with open(os.path.join(output, 'report.csv'), encoding='utf-8') as file:
        header, *rows = csv.reader(text for text in file if text.endswith('\n') and not text.startswith('#'))
    return [name.split(' (')[0] for name in header], rows


def start(output, hours):
    words = ['mpirun', '-n', '2', os.path.join(BUILD, 'unibody'), os.path.join(ROOT, 'scenes', 'kiln.yaml'), '-output', output, '-overwrite',
             '-wall_limit', f'{3600 * hours:.0f}']
    for value in ('time.frames=100000000', 'bodies[1].inlet.count=2000000', 'output.every=0', 'output.checkpoint_minutes=10'):
        words += ['-set', value]
    shell = 'source "$0/scripts/common.sh"; mpi_environment 3; exec "$@"'  # as more ranks than cores: other work may want these
    return subprocess.Popen(['bash', '-c', shell, ROOT] + words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def watch(run, seconds):
    """Samples of (time since the start (s), memory, handles, threads) until the run ends."""
    begin, samples = time.time(), []
    while run.poll() is None:
        time.sleep(seconds)
        try:
            samples.append((time.time() - begin, *sample(ranks_of(run.pid))))
        except (OSError, ValueError):  # the ranks begin or end
            continue
    return samples


def spans(output, samples):
    """Rows of the table. The time of a frame is what nine tenths of a span's frames take longer than: other work on the machine
    makes frames longer, never shorter."""
    names, rows = rows_of(output)
    at = {name: place for place, name in enumerate(names)}
    walls = [at[name] for name in ('wall_collide', 'wall_solve', 'wall_halo', 'wall_output')]
    times = [sum(float(row[place]) for place in walls) for row in rows]
    total, clock, ends = sum(times), 0., []
    for place, seconds in enumerate(times):
        clock += seconds
        if clock >= total * (len(ends) + 1) / SPANS:
            ends.append(place + 1)
    table_rows, first = [], 0
    for number, end in enumerate(ends):
        part = rows[first:end]
        ours = [s for s in samples if number < SPANS * s[0] / samples[-1][0] <= number + 1] or samples[-1:]
        bodies = statistics.mean(float(row[at['bodies']]) for row in part)
        table_rows.append((samples[-1][0] / 3600 * (number + 1) / SPANS, end, float(part[-1][at['time']]), bodies,
                           int(float(part[-1][at['inlet_grains_placed']])), max(s[1] for s in ours), max(s[2] for s in ours), max(s[3] for s in ours),
                           1e3 * statistics.quantiles(times[first:end], n=10)[0],
                           statistics.mean(float(row[at['total_energy']]) / max(float(row[at['bodies']]), 1) for row in part)))
        first = end
    return table_rows


def soak(arguments):
    output = folder('soak')
    shutil.rmtree(output, ignore_errors=True)
    hours = .02 if arguments.quick else arguments.hours
    say(f'soak: scenes/kiln.yaml on 2 ranks for {hours:g} hours')
    run = start(output, hours)
    try:
        samples = watch(run, min(20, 36 * hours))
    except KeyboardInterrupt:
        run.send_signal(signal.SIGTERM)
        samples = watch(run, 1)
    if run.returncode not in (0, 4):  # 4: stopped as asked
        sys.exit(f'bench: soak: ended with {run.returncode}\n{run.stderr.read()[-2000:]}')
    lines = table(COLUMNS)
    for row in spans(output, samples):
        lines.append(line(f'{row[0]:.2f}', row[1], f'{row[2]:.0f}', f'{row[3]:.0f}', row[4], f'{row[5]:.1f}', row[6], row[7], f'{row[8]:.1f}', f'{row[9]:.4f}'))
    publish('soak.md', lines)
