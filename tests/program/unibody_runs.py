"""Runs of the whole program, for the tests beside this file: starts mpirun and gives back what came of it.

Two variables name what is tested: UNIBODY_PROGRAM, the program, and UNIBODY_SOURCE_DIR, the folder that holds scenes/ and
scripts/. UNIBODY_MPIEXEC names another mpirun. ctest sets them; by hand, the release build of this source tree is taken.
"""
import atexit
import csv
import dataclasses
import functools
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import tempfile
import textwrap
import unittest

SOURCE = pathlib.Path(os.environ.get("UNIBODY_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("UNIBODY_PROGRAM", str(SOURCE / "build" / "release" / "unibody"))
MPIEXEC = os.environ.get("UNIBODY_MPIEXEC", "mpirun")
SCENES = SOURCE / "scenes"

# Open MPI's folder for mpirun, which runs of other tests at the same time could remove while one here starts.
SESSIONS = tempfile.mkdtemp(prefix="unibody_mpi_")
atexit.register(shutil.rmtree, SESSIONS, ignore_errors=True)

# More ranks than cores, as root, in containers: all is legal in tests.
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_hwloc_base_binding_policy="none",
                   OMPI_MCA_mpi_yield_when_idle="1", OMPI_MCA_orte_tmpdir_base=SESSIONS,
                   OMPI_MCA_orte_execute_quiet="1", OMP_NUM_THREADS="1",
                   OMPI_MCA_pml="ob1")  # else Open MPI looks for clusters' networks, a third of the time that a run starts

# After a run that ends with another code than 0, mpirun waits for a second before it ends what may still run.
ENDS_AT_ONCE = dict(ENVIRONMENT, OMPI_MCA_odls_base_sigkill_timeout="0")

# What a run's wall time and rank count decide; all other columns of report.csv are the physics'.
OF_THIS_MACHINE = re.compile(r"^(wall_|bytes_per_body|imbalance)")


@dataclasses.dataclass
class Run:
    code: int
    out: str
    err: str
    seconds: float  # of processor time, all ranks and mpirun: others on the machine don't lengthen it

    @property
    def state(self):
        """The state's hash, which must be the last line."""
        lines = self.out.strip().splitlines()
        match = re.fullmatch(r"state ([0-9a-f]{16})", lines[-1]) if lines else None
        return match.group(1) if match else None

    @property
    def message(self):
        """The lines that the program itself said on stderr."""
        return [line for line in self.err.splitlines() if line.startswith("unibody: ")]


def command(arguments, ranks):
    """One rank starts by itself, as users start it; mpirun would take longer."""
    return [*([MPIEXEC, "-n", str(ranks)] if ranks > 1 else []), PROGRAM, *map(str, arguments)]


def launch(ranks, **environment):
    """What starts so many ranks of a program with variables of their own."""
    words = [MPIEXEC, "-n", str(ranks)]
    for name, value in environment.items():
        words += ["-genv", name, value] if is_hydra() else ["-x", f"{name}={value}"]
    return words


@functools.cache
def is_hydra():
    """Whether mpirun is that of MPICH. It starts ranks by a process of its own, and gives them no terminal."""
    return "HYDRA" in subprocess.run([MPIEXEC, "--version"], env=ENVIRONMENT, capture_output=True, text=True, check=False).stdout


def start(words, folder=None, environment=ENVIRONMENT):
    """The words as a process in a group of its own, so that all of it can be ended."""
    return subprocess.Popen(words, env=environment, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            errors="replace", start_new_session=True)


def end(process):
    """Ends mpirun and its ranks at once. (They are in groups of their own: mpirun ends them if it is asked politely.)"""
    process.terminate()
    try:
        process.communicate(timeout=10)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def processor_seconds():
    """Of all processes that were started here and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def execute(words, timeout=120, folder=None):
    begin = processor_seconds()
    process = start(words, folder, ENDS_AT_ONCE)
    try:
        out, err = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        end(process)
        raise AssertionError(f"still running after {timeout} s: {' '.join(words)}") from None
    return Run(process.returncode, out, err, processor_seconds() - begin)


def unibody(*arguments, ranks=2, timeout=120, folder=None):
    return execute(command(arguments, ranks), timeout, folder)


def report(path):
    """Header and rows of a report.csv, the rows as text: equal text is equal numbers."""
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    return rows[0], rows[1:]


def comparable(path):
    """A report.csv without the columns that tell of the machine and not of the bodies."""
    header, rows = report(path)
    keep = [k for k, name in enumerate(header) if not OF_THIS_MACHINE.match(name)]
    return [[row[k] for k in keep] for row in [header, *rows]]


def contents(path):
    return pathlib.Path(path).read_bytes()


def tree(folder):
    """All that is in a folder: names, and what the files hold."""
    return {str(p.relative_to(folder)): p.read_bytes() if p.is_file() else None for p in pathlib.Path(folder).rglob("*")}


class ProgramTest(unittest.TestCase):
    """A test with a folder of its own, empty at the start and gone at the end."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="unibody_program_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def scene(self, text, name="scene.yaml"):
        path = self.folder / name
        path.write_text(textwrap.dedent(text))
        return path

    def good(self, scene, name, *options, ranks=2, timeout=120):
        """A run that must succeed, into the folder `name`."""
        run = unibody(scene, "-output", self.folder / name, *options, ranks=ranks, timeout=timeout)
        self.assertEqual(run.code, 0, f"{name}: exit code {run.code}\n{run.err}")
        self.assertIsNotNone(run.state, f"{name}: the last line is no 'state HASH':\n{run.out}")
        return run
