"""Runs that are made once: what a part of the report asks for is looked up by program, scene and settings before it is run."""
import concurrent.futures
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time

import poses
from runs import BUILD, COMMON, ROOT, busy_cores, command, report_rows

SIZES = ('tiny', 'quick', 'full')


def digest(*things):
    text = json.dumps(things, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:20]


def digest_of_file(path):
    with open(path, 'rb') as file:
        result = hashlib.sha256()
        for block in iter(lambda: file.read(1 << 20), b''):
            result.update(block)
        return result.hexdigest()[:20]


def now(seconds=None):
    return time.strftime('%Y-%m-%d %H:%M', time.localtime(seconds))


UNTIMED = 'untimed'  # kept in place of the load where a run's times do not matter


class Failed(Exception):
    """A program could not be run; says why."""


class Run:
    """What a run of unibody reported: columns of report.csv by name, and what `look` made of its frames."""

    def __init__(self, kept):
        self.columns, self.seen = kept['columns'], kept['seen']

    def column(self, name):
        """The column `name`, whose header may add a unit or a material; numbers, None where the cell is empty."""
        for header, values in self.columns.items():
            if header == name or header.split('(')[0].split('[')[0].strip() == name:
                return values
        raise Failed(f'report.csv has no column {name}; it has {", ".join(self.columns)}')

    def frame_ms(self, first=0):
        """Median time (ms) of a frame's contacts, solve and exchange, from row `first` on."""
        sums = sorted(sum(parts) for parts in list(zip(*(self.column(f'wall_{p}') for p in ('collide', 'solve', 'halo'))))[first:])
        return 1e3 * sums[len(sums) // 2]


class Maker:
    """One making of the report. `folder` holds what was run; `again` runs it anew."""

    def __init__(self, size, folder, again=False, core=None, build=BUILD):
        self.size, self.folder, self.again, self.core = size, folder, again, core
        self.program, self.rivals = os.path.join(build, 'unibody'), os.path.join(build, 'scripts', 'rivals')
        self.part, self.made, self.found, self.begin = '', 0, 0, time.monotonic()
        self.ahead = None  # of a part that has said how many runs it needs: (their number, self.made + self.found, self.made, the time) when it began
        self.fresh = set()  # made just now: not again even with --again
        self.marks = {}
        self.load = busy_cores()
        self.timed = True  # whether the times of the runs that follow matter
        self.broken = []  # runs of other programs that ended in an error
        self.version, self.versions = 'unknown', set()  # of the program now, and when the runs looked at were made
        self.when = set()  # of all runs looked at: (when they were made, the cores at work when that making began, UNTIMED or None)
        for name in ('runs', 'states', 'scratch'):
            os.makedirs(os.path.join(folder, name), exist_ok=True)

    def pick(self, tiny, quick, full):
        return {'tiny': tiny, 'quick': quick, 'full': full}[self.size]

    def expect(self, runs):
        """The part that begins needs about so many runs."""
        self.ahead = (runs, self.made + self.found, self.made, time.monotonic())

    def left(self):
        """How much of the part is left, for people."""
        if self.ahead is None:
            return ''
        runs, before, made, begin = self.ahead
        to_do, mean = max(runs - (self.made + self.found - before), 0), (time.monotonic() - begin) / max(self.made - made, 1)
        return f' ({to_do} of {runs} runs left' + (f', about {to_do * mean / 60:.0f} min' if self.made > made else '') + ')'

    def say(self, text):
        print(f'report: {time.monotonic() - self.begin:6.0f} s  {self.part}{self.left()}: {text}', file=sys.stderr, flush=True)

    def mark(self, path):
        """The hash of a file, read once."""
        if path not in self.marks:
            self.marks[path] = digest_of_file(path)
        return self.marks[path]

    def keep(self, key, what, make, ours=True):
        """The JSON kept under `key`, or what make() gives, which is then kept. `ours`: this program makes it."""
        path = os.path.join(self.folder, 'runs', key + '.json')
        if os.path.exists(path) and (not self.again or key in self.fresh):
            self.found += 1
            with open(path, encoding='utf-8') as file:
                result = json.load(file)
            self.when.add((result.get('made', now(os.path.getmtime(path))), result.get('load')))
            if ours:
                self.versions.add(result.get('version', 'not kept'))
            return result
        self.say(what)
        result = dict(make(), made=now(), load=self.load if self.timed else UNTIMED, version=self.version)
        if ours:
            self.versions.add(self.version)
        self.when.add((result['made'], result['load']))
        self.made += 1
        self.fresh.add(key)
        with open(path + '.part', 'w', encoding='utf-8') as file:
            json.dump(result, file)
        os.replace(path + '.part', path)
        return result

    def conditions(self):
        """When and by which program the runs were made that the page shows, and how busy the machine was: facts of the measuring, not of the
        reading."""
        return [*self.moments(), ('program', ', '.join(sorted(self.versions)) or 'no run yet')]

    def moments(self):
        if not self.when:
            return [('made', 'no run yet'), ('cores busy at the start', '-')]
        times, loads = [t for t, _ in self.when], [load for _, load in self.when if load != UNTIMED]
        made = min(times) if min(times) == max(times) else f'{min(times)} to {max(times)}'
        if not loads:
            return [('made', made), ('cores busy at the start', 'no time was taken')]
        if None in loads:
            return [('made', made), ('cores busy at the start', 'not kept')]
        verdict = ' - too busy: these times are unfit to quote' if max(loads) > .3 else ''
        return [('made', made), ('cores busy at the start', f'{max(loads):.1f}{verdict}')]

    def key(self, scene, settings, ranks=1, options=(), start=None, look=()):
        return digest(self.mark(self.program), self.mark(scene_path(scene)), settings, ranks, options, start and self.mark(start), named(look))

    def unibody(self, scene, settings, output, ranks=1, options=(), start=None):
        words = [self.program, scene_path(scene), '-output', output, '-overwrite', *options] + (['-start_from', start] if start else [])
        for value in COMMON + list(settings):
            words += ['-set', value]
        try:
            command(words, 0 if ranks == 1 else ranks, self.core)
        except SystemExit as fault:
            raise Failed(str(fault)) from fault

    def run(self, scene, settings, ranks=1, options=(), start=None, look=None):
        """One run. `start`: the checkpoint it starts from. `look`: [name, *arguments] of a function of poses.py, which sees its
        frames; without it none are written."""
        settings = list(settings) + ([] if look else ['output.every=0'])

        def make():
            output = tempfile.mkdtemp(dir=os.path.join(self.folder, 'scratch'))
            try:
                self.unibody(scene, settings, output, ranks, options, start)
                rows = report_rows(output)
                columns = {h: [float(r[h]) if r[h] else None for r in rows] for h in rows[0]}
                return {'columns': columns, 'seen': poses.LOOKS[look[0]](self, output, *look[1:]) if look else None}
            finally:
                shutil.rmtree(output, ignore_errors=True)

        short = ' '.join(s for s in settings if s.startswith(('solver', 'time')))
        return Run(self.keep(self.key(scene, settings, ranks, options, start, look or ()), f'{name_of(scene)} {short} on {ranks}', make))

    def at_once(self, make, wishes):
        """[make(**wish)] of runs whose times do not matter, as many at once as there are cores."""
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            core, self.core, self.timed = self.core, None, False
            try:
                return list(pool.map(lambda wish: make(**wish), wishes))
            finally:
                self.core, self.timed = core, True

    def together(self, wishes):
        """Runs whose times do not matter; wishes: keyword arguments of run()."""
        return self.at_once(self.run, wishes)

    def folder_of(self, scene, settings, frames=None, start=None, options=()):
        """The folder of a run with its frames and the checkpoint at its end, kept as a whole: for states and references."""
        settings = list(settings) + ([f'time.frames={frames}'] if frames is not None else [])
        path = os.path.join(self.folder, 'states', self.key(scene, settings, 1, options, start))
        if not os.path.exists(path) or (self.again and path not in self.fresh):
            self.say(f'{name_of(scene)}: a state or reference, {" ".join(settings[-3:])}')
            shutil.rmtree(path, ignore_errors=True)
            shutil.rmtree(path + '.part', ignore_errors=True)
            self.unibody(scene, settings + ['output.checkpoint_every=0'], path + '.part', 1, options, start)
            os.replace(path + '.part', path)
            self.made += 1
            self.fresh.add(path)
        return path

    def rival(self, name, start, options=(), look=('measure',), gravity=9.8):
        """A run of another program from the first frame of the folder `start`: {'ms': of a frame, 'seen': what poses.py's look[0] sees},
        {'diverged': the frame from which its states are no longer finite}, None where the program is not there, or {'failed': why} where it
        ended in an error, which is not kept and told in `broken`."""
        words, needs = RIVALS[name](self)
        if not all(os.path.exists(p) or shutil.which(p) for p in needs):
            return None
        start = os.path.join(start, 'frames.h5')
        options = [*map(str, options), '--gravity', str(gravity)]
        marks = [self.mark(p if os.path.exists(p) else shutil.which(p)) for p in needs]
        key = digest(marks, self.mark(start), self.mark(os.path.join(self.rivals, 'measure')), options, named(look))

        def make():
            output = tempfile.mkdtemp(dir=os.path.join(self.folder, 'scratch'))
            try:
                said = command([*words, start, os.path.join(output, 'frames.h5'), *options], 0, None if '--ranks' in options else self.core)
                if 'diverged_frame' in said:
                    return {'diverged': int(said.split('diverged_frame')[1])}
                return {'ms': float(said.split('_ms')[1]), 'seen': poses.LOOKS[look[0]](self, output, *look[1:])}
            finally:
                shutil.rmtree(output, ignore_errors=True)

        what = f'{name} {" ".join(options)}'
        try:
            return self.keep(key, what, make, ours=False)
        except (SystemExit, subprocess.CalledProcessError, IndexError, ValueError) as fault:  # it, what it said, or what it left
            self.broken.append(what)
            self.say(f'{what} ended in an error: {str(fault)[-300:]}')
            return {'failed': str(fault)[-300:]}

    def state(self, scene, settings, frames):
        """The checkpoint at the end of a run."""
        return os.path.join(self.folder_of(scene, list(settings) + ['output.every=0'], frames), 'checkpoint.h5')


def driver(name):
    return lambda maker: ([os.path.join(maker.rivals, name)], [os.path.join(maker.rivals, name)])


def script(name, program):
    path = os.path.join(ROOT, 'scripts', 'rivals', name)
    return lambda maker: ([sys.executable, path], [path, program])


# Name -> how it is started, and the files or programs that must be there.
RIVALS = {
    'Bullet': driver('bullet'), 'ODE': driver('ode'), 'DART': driver('dart'), 'LIGGGHTS': script('liggghts.py', 'liggghts'),
    'LAMMPS': script('lammps.py', 'lmp')}


def named(look):
    """The words of a look without folders: what is kept may be moved."""
    return [os.path.basename(str(x)) for x in look]


def scene_path(scene):
    return scene if scene.endswith('.yaml') else os.path.join(ROOT, 'scenes', scene + '.yaml')


def name_of(scene):
    return os.path.basename(scene).removesuffix('.yaml')
