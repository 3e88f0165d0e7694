#!/usr/bin/python3
"""The commands of docs/tutorial-slurm.md, as written, under a Slurm of three small scripts: a job that gets USR1 is requeued, goes on, and
ends in the state of a straight run. (scripts/test-slurm does the same under Slurm itself.)"""
import json
import os
import re
import shutil
import stat
import subprocess
import unittest

from unibody_runs import ENVIRONMENT, MPIEXEC, PROGRAM, SOURCE, ProgramTest, contents, unibody

# Takes a job script and its options, and runs the job until it is not put into the queue again.
SBATCH = """#!/bin/bash
number=$(($(cat last 2>/dev/null || echo 100) + 1)); echo $number >last
echo "Submitted batch job $number"
export SLURM_JOB_ID=$number SLURM_SUBMIT_DIR=$PWD SLURM_NTASKS=2
while true; do
  rm -f again
  bash "$@" >>"unibody-$number.log" 2>&1
  echo $? >>"codes-$number"
  [[ -e again ]] || break
done
"""
SCONTROL = """#!/bin/bash
[[ $1 == requeue && $2 == $SLURM_JOB_ID ]] && touch again
"""
# Starts the tasks. The first time it sends them USR1 after a second and a half, as at a time limit.
SRUN = """#!/bin/bash
if [[ $1 == --mpi=list ]]; then echo "MPI plugin types are... pmix"; exit; fi
while [[ $1 == --* ]]; do shift; done
MPIEXEC -n $SLURM_NTASKS "$@" &
tasks=$!
if [[ ! -e signalled ]]; then touch signalled; sleep 1.5; kill -USR1 $tasks; fi
while kill -0 $tasks 2>/dev/null; do wait $tasks; code=$?; done
exit $code
"""


class SlurmJob(ProgramTest):
    def setUp(self):
        super().setUp()
        commands = self.folder / "commands"
        commands.mkdir()
        for name, text in (("sbatch", SBATCH), ("scontrol", SCONTROL), ("srun", SRUN.replace("MPIEXEC", MPIEXEC))):
            (commands / name).write_text(text)
            (commands / name).chmod(stat.S_IRWXU)
        (self.folder / "build/release").mkdir(parents=True)
        os.symlink(PROGRAM, self.folder / "build/release/unibody")
        for name in ("scripts", "scenes"):
            os.symlink(SOURCE / name, self.folder / name)
        page = (SOURCE / "docs" / "tutorial-slurm.md").read_text(encoding="utf-8")
        self.blocks = [block for block in re.findall(r"```\n(.*?)```", page, re.DOTALL) if "sbatch" in block]
        self.assertEqual(len(self.blocks), 2)

    def submit(self, block):
        path = f"{self.folder / 'commands'}:{os.environ['PATH']}"
        return subprocess.run(["bash", "-c", block], cwd=self.folder, env={**ENVIRONMENT, "PATH": path}, check=True, timeout=300,
                              capture_output=True, text=True).stdout

    def test_a_job_that_passes_its_time(self):
        self.assertEqual(self.submit(self.blocks[0]), "Submitted batch job 101\n")
        log = (self.folder / "unibody-101.log").read_text()
        self.assertEqual((self.folder / "codes-101").read_text().split(), ["4", "0"], log)
        self.assertEqual(log.count("stopped as asked by"), 1)
        words = self.blocks[0].split()
        straight = unibody(self.folder / words[2], *words[3:], "-output", self.folder / "straight", ranks=1, timeout=300)
        self.assertEqual(straight.code, 0, straight.err)
        self.assertEqual(re.findall(r"^state (\w{16})$", log, re.MULTILINE)[-1], straight.state)
        for name in ("checkpoint.h5", "frames.xdmf"):
            self.assertEqual(contents(self.folder / "results/boxes_500-101" / name), contents(self.folder / "straight" / name))

    def test_a_study(self):
        (self.folder / "signalled").touch()
        shutil.rmtree(self.folder / "results", ignore_errors=True)
        self.submit(self.blocks[1])
        settings = []
        for number in (101, 102, 103):
            with open(self.folder / f"results/boxes_500-{number}/summary.json", encoding="utf-8") as file:
                settings.append(json.load(file)["settings"]["solver"]["iterations"])
        self.assertEqual(settings, [25, 50, 100])


if __name__ == "__main__":
    unittest.main()
