"""What ranks tell each other, counted around MPI on as many ranks as the memory bears, and what a machine with very many ranks
would make of it."""
import collections
import csv
import glob
import json
import math
import os
import statistics

from runs import BUILD, OUT, column, command, folder, line, publish, say, table, unibody

SPHERES, NODES = 20000, 20000  # a rank
RANKS = (4, 8, 16, 32, 64)
ITERATIONS = 50
FIRST, LAST = 2, 4  # frames between which is counted
PHASES = ('other', 'collide', 'solve', 'halo', 'partition', 'output')
ITERATION_TAG = 111  # of the messages of an iteration
SEARCH_TAGS = {101, 102, 103, 104}  # of a search of guests
PARTITION_TAGS = {131, 132, 133, 134, 135}
ODD = 1000  # added to the tags of every second exchange
COLLECTIVES = ('MPI_Allreduce', 'MPI_Reduce', 'MPI_Bcast', 'MPI_Exscan', 'MPI_Scan', 'MPI_Barrier', 'MPI_Ibarrier')
OF_ALL_RANKS = ('MPI_Allgather', 'MPI_Allgatherv', 'MPI_Alltoall', 'MPI_Alltoallv', 'MPI_Gather')  # room for each rank on each rank


def spheres(ranks, each):
    """A cube of spheres at rest on each other, which all touch."""
    side = round((each * ranks) ** (1 / 3))
    width = side * .1 + .02
    return side ** 3, 'spheres_5000', [
        f'bodies[0].container.size=[{width}, {width}]', f'bodies[1].lattice.count={side ** 3}', f'bodies[1].lattice.columns=[{side}, {side}]',
        'bodies[1].lattice.spacing=[0.1001, 0.1001, 0.1001]', 'bodies[1].lattice.height=0.0501', 'bodies[1].lattice.jitter=0']


def cloth(ranks, each):
    side = round((each * ranks) ** .5)
    return side ** 2, 'cloth_1m', [f'cloths[0].grid.nodes=[{side}, {side}]', f'cloths[0].grid.size=[{side / 100}, {side / 100}]',
                                   f'cloths[0].pins=[{{node: [0, 0]}}, {{node: [{side - 1}, 0]}}]']


SCENES = {'spheres': (spheres, SPHERES), 'cloth': (cloth, NODES)}


def read_counts(path):
    """(phase, function, tag) -> rank -> (calls, bytes)."""
    found = collections.defaultdict(lambda: collections.defaultdict(lambda: (0, 0)))
    for name in glob.glob(os.path.join(path, '*.csv')):
        rank = int(os.path.basename(name)[:-4])
        with open(name, encoding='ascii') as file:
            for row in csv.DictReader(file):
                tag = int(row['tag'])
                key = PHASES[int(row['phase'])], row['function'], tag - ODD if ODD < tag < 2 * ODD else tag
                calls, size = found[key][rank]
                found[key][rank] = calls + int(row['calls']), size + int(row['bytes'])
    return found


def counted(name, ranks, each, frames):
    """The counts of a run, its last row of the report, its summary, and how many bodies it has."""
    bodies, scene, settings = SCENES[name][0](ranks, each)
    path, counts = folder(f'scale_{name}'), folder(f'scale_{name}_counts')
    os.makedirs(counts, exist_ok=True)
    for old in glob.glob(os.path.join(counts, '*.csv')):
        os.remove(old)
    say(f'{name}: {bodies:,} bodies on {ranks} ranks, {frames} frames')
    before = ['env', f'LD_PRELOAD={os.path.join(BUILD, "libcounting.so")}', f'UNIBODY_COUNTS={counts}'] if ranks > 1 else []
    rows = unibody(scene, settings + ['output.every=0', f'solver.iterations={ITERATIONS}'], path, ranks, None, frames, before=before,
                   options=['-shared_memory', 'off'])
    with open(os.path.join(path, 'summary.json'), encoding='utf-8') as file:
        return read_counts(counts), rows, json.load(file), bodies


class Sums:
    """Calls and bytes of some kinds of messages: the mean and the most of the ranks."""

    def __init__(self, late, early, ranks, kinds):
        each = [[sum(late[key][rank][i] - (early[key][rank][i] if early else 0) for key in late if kinds(*key)) for i in (0, 1)]
                for rank in range(ranks)]
        self.calls, self.bytes = (statistics.mean(values) for values in zip(*each))
        self.most_calls, self.most_bytes = (max(values) for values in zip(*each))


def is_send(function):
    return function.endswith('end') or function == 'MPI_Start'


def measure(name, ranks, each):
    early, _, _, _ = counted(name, ranks, each, FIRST)
    late, rows, summary, bodies = counted(name, ranks, each, LAST)
    frames = LAST - FIRST
    steps = frames * ITERATIONS

    def sums(kinds, first=early):
        return Sums(late, first, ranks, kinds)
    sweep = sums(lambda phase, function, tag: tag == ITERATION_TAG)
    exchanges = sums(lambda phase, function, tag: phase == 'halo' and function == 'MPI_Ibarrier').most_calls
    searches = max(1, round(exchanges / 4))  # each has four
    search = sums(lambda phase, function, tag: phase == 'halo' and function == 'MPI_Issend' and tag in SEARCH_TAGS)
    refresh = sums(lambda phase, function, tag: phase == 'halo' and is_send(function) and tag != ITERATION_TAG and tag not in SEARCH_TAGS)
    search_all = sums(lambda phase, function, tag: phase == 'halo' and function in COLLECTIVES)
    changes = max(1, sums(lambda phase, function, tag: tag == 131, None).most_calls)  # of homes, from the start
    change = sums(lambda phase, function, tag: is_send(function) and (phase == 'partition' or tag in PARTITION_TAGS), None)
    change_all = sums(lambda phase, function, tag: phase == 'partition' and function in COLLECTIVES, None)
    return {
        'scene': name, 'ranks': ranks, 'bodies': bodies,
        'sweep_messages': sweep.calls / steps, 'sweep_messages_most': sweep.most_calls / steps,
        'sweep_bytes': sweep.bytes / steps, 'sweep_bytes_most': sweep.most_bytes / steps,
        'sweep_sums': sums(lambda phase, function, tag: phase == 'solve' and function == 'MPI_Iallreduce').most_calls / steps,
        'sums': sums(lambda phase, function, tag: phase in ('other', 'collide', 'solve') and function in COLLECTIVES).most_calls / frames,
        'searches': searches / frames,
        'search_messages': search.calls / searches, 'search_messages_most': search.most_calls / searches,
        'search_bytes_most': search.most_bytes / searches, 'search_sums': search_all.most_calls / searches,
        'refresh_messages_most': refresh.most_calls / frames, 'refresh_bytes_most': refresh.most_bytes / frames,
        'of_all_ranks': sums(lambda phase, function, tag: function in OF_ALL_RANKS).most_calls / frames,
        'change_messages': change.most_calls / changes, 'change_bytes': change.most_bytes / changes,
        'change_sums': change_all.most_calls / changes,
        'change_of_all_ranks': sums(lambda phase, function, tag: function in OF_ALL_RANKS, None).most_calls / changes,
        'repeated_work': summary['borders_of_ranks']['repeated_work (1)'], 'guests': summary['borders_of_ranks']['guests_per_body (1)'],
        'imbalance': column(rows, 'imbalance')[-1]}


def alone(name, each):
    """Seconds of a frame of one rank's share, without the others."""
    _, rows, _, bodies = counted(name, 1, each, 8)
    seconds = [sum(values) for values in zip(*(column(rows, phase) for phase in ('wall_collide', 'wall_solve')))]
    return statistics.median(seconds[2:]) * each / bodies


def scale(arguments):
    """--quick: a twentieth of the bodies, on 4 and 8 ranks."""
    found = {'alone': {}, 'counts': []}
    lines = table(['scene', 'ranks', 'bodies', 'an iteration: messages of a rank, mean and most', 'KB, mean and most', 'work done twice',
                   'largest over mean work', 'guests a body', 'a search: messages, mean and most', 'KB, most', 'collectives', 'refreshing guests: messages, most',
                   'KB, most', 'collectives with room for each rank a frame', 'other collectives a frame'])
    for name, (_, each) in SCENES.items():
        each = each // 20 if arguments.quick else each
        found['alone'][name] = alone(name, each)
        for ranks in RANKS[:2] if arguments.quick else RANKS:
            m = measure(name, ranks, each)
            found['counts'].append(m)
            lines.append(line(
                name, ranks, f'{m["bodies"]:,}', f'{m["sweep_messages"]:.1f}, {m["sweep_messages_most"]:.1f}',
                f'{m["sweep_bytes"] / 1e3:.1f}, {m["sweep_bytes_most"] / 1e3:.1f}', f'{m["repeated_work"]:.1%}', f'{m["imbalance"]:.3f}', f'{m["guests"]:.2f}',
                f'{m["search_messages"]:.0f}, {m["search_messages_most"]:.0f}', f'{m["search_bytes_most"] / 1e3:.0f}', f'{m["search_sums"]:.0f}',
                f'{m["refresh_messages_most"]:.0f}', f'{m["refresh_bytes_most"] / 1e3:.0f}', f'{m["of_all_ranks"]:.0f}', f'{m["sums"]:.0f}'))
    with open(os.path.join(OUT, 'scale.json'), 'w', encoding='utf-8') as file:
        json.dump(found, file, indent=1)
    publish('scale.md', lines)


# The machine of the model: nodes of 64 cores with a network of 200 Gbit/s, and a file system.
CORES = 64
LATENCY = 1.5e-6  # s, between nodes
OVERHEAD = 0.5e-6  # s, that a rank is at work for a message it sends or receives
NETWORK = 25e9  # B/s of a node
MEMORY = 5e9  # B/s of a message within a node
OFF_NODE = {'spheres': 1 / 4, 'cloth': 1 / 8}  # of messages, where the ranks of a node lie together: faces of 4 x 4 x 4 and of 8 x 8 ranks
FILES = 500e9  # B/s of all ranks
FRAME_EVERY, CHANGE_EVERY = 100, 100  # steps: a frame is written in single precision; homes change
SEARCH_EVERY = 1  # steps: as where all falls; at rest lists hold for longer
RANKS_ON_PAPER = (64, 1000, 10000, 100000)
CELLS, PARTS = 32, 16  # cells a side of what METIS cuts at once, and parts


def collective(ranks, size=0):
    """Up and down a tree; what is long goes in parts, each byte twice."""
    return 2 * math.ceil(math.log2(ranks)) * (LATENCY + OVERHEAD) + 2 * size / (NETWORK / CORES)


def of_all(ranks):
    """A word of every rank to every rank."""
    return math.ceil(math.log2(ranks)) * (LATENCY + OVERHEAD) + 4 * ranks / (NETWORK / CORES)


def messages(name, count, size):
    off = OFF_NODE[name]
    return count * 2 * OVERHEAD + LATENCY + size * (off / (NETWORK / CORES) + (1 - off) / MEMORY)


def bisection(ranks, cells):
    """The collectives of the cut into groups: of each level the sides, the weight, and the cut, four bits of a cell's place at once."""
    groups = max(1, ranks // PARTS)
    levels = math.ceil(math.log2(groups)) if groups > 1 else 0
    turns = math.ceil(3 * math.ceil(math.log2(max(2, cells ** (1 / 3)))) / 4)
    return sum((2 + turns) * collective(ranks, 16 * 8 * 2 ** level) for level in range(levels))


def parts_of_frame(name, m, seconds, ranks, cut, each):
    """Seconds of each part of a frame on so many ranks. Borders grow as the surfaces inside a cube or square of ranks do."""
    dimension = 3 if name == 'spheres' else 2
    inner = (1 - ranks ** (-1 / dimension)) / (1 - m['ranks'] ** (-1 / dimension))
    change = cut + bisection(ranks, each * ranks / 10) + messages(name, m['change_messages'], m['change_bytes'])
    change += m['change_sums'] * collective(ranks) + m['change_of_all_ranks'] * of_all(ranks)
    written = 13 * 4 if name == 'spheres' else 6 * 4  # B a body
    return {
        'work alone': seconds, 'work done twice and uneven': seconds * ((1 + m['repeated_work'] * inner) * m['imbalance'] - 1),
        'messages of iterations': ITERATIONS * messages(name, m['sweep_messages_most'], m['sweep_bytes_most']),
        'collectives': m['sums'] * collective(ranks),
        'sums of iterations, were they not hidden': m['sweep_sums'] * ITERATIONS * collective(ranks),
        'refreshing of guests': messages(name, m['refresh_messages_most'], m['refresh_bytes_most']),
        'search of guests': (messages(name, m['search_messages_most'], m['search_bytes_most']) + m['search_sums'] * collective(ranks)
                             + m['of_all_ranks'] * of_all(ranks)) / SEARCH_EVERY,
        'change of homes': change / CHANGE_EVERY,
        'output': (each * ranks * written / FILES + messages(name, min(each, ranks), 2 * each * written)) / FRAME_EVERY}


def model(arguments):
    path = os.path.join(OUT, 'scale.json')
    if not os.path.exists(path):
        scale(arguments)
    with open(path, encoding='utf-8') as file:
        found = json.load(file)
    cut = statistics.median(float(command([os.path.join(BUILD, 'cut_time'), str(CELLS), str(PARTS)])) for _ in range(3))
    lines = []
    for name, seconds in found['alone'].items():
        m = [c for c in found['counts'] if c['scene'] == name][-1]
        each = m['bodies'] / m['ranks']
        columns = [parts_of_frame(name, m, seconds, ranks, cut, each) for ranks in RANKS_ON_PAPER]
        lines += table([f'{name}, {each:,.0f} a rank: ms of a frame'] + [f'{ranks:,} ranks' for ranks in RANKS_ON_PAPER])
        lines += [line(part, *(f'{1e3 * c[part]:.2f}' for c in columns)) for part in columns[0]]
        hidden = 'sums of iterations, were they not hidden'
        lines.append(line('efficiency, these sums hidden', *(f'{seconds / (sum(c.values()) - c[hidden]):.2f}' for c in columns)))
        lines.append(line('efficiency, not hidden', *(f'{seconds / sum(c.values()):.2f}' for c in columns)) + '\n')
    publish('model.md', lines)
