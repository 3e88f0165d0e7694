"""Siconos and this program on the same frictional contact problems: one step from one state, both judged by one formula."""
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np

from fclib import Problem
from page import Section, Table
from runs import ROOT, report_rows
from solve_siconos import differences
from work_precision import Setting

TITLE = 'Siconos on the same contact problems'
COLUMNS = [
    'scene', 'frame', 'contacts', 'solver', 'ms of the solve', 'natural map', 'largest |r . u^| (J)', 'velocities from Siconos',
    'impulses from Siconos', 'within the tolerance']
OURS = [
    Setting('accelerated_jacobi', 50), Setting('gauss_seidel', 50), Setting('accelerated_jacobi', 500, 1, 1, 'joint'),
    Setting('accelerated_jacobi', 5000, 1, 1, 'joint'), Setting('gauss_seidel', 5000, 1, 1, 'joint')]
THEIRS = ('1e-4', '1e-10')  # tolerances


def problems(maker):
    """(name, scene, settings, frame)"""
    def boxes(count, *frames):
        return [(f'{count} boxes', 'boxes_500', [f'bodies[1].lattice.count={count}'], frame) for frame in frames]

    def spheres(count, columns, width, *frames):
        settings = [
            f'bodies[1].lattice.count={count}', f'bodies[1].lattice.columns=[{columns}, {columns}]',
            f'bodies[0].container.size=[{width}, {width}]']
        return [(f'{count} spheres', 'spheres_5000', settings, frame) for frame in frames]

    return maker.pick(
        boxes(4, 20), boxes(50, 11, 45) + spheres(100, 5, 0.6, 25, 45),
        boxes(50, 11, 45) + boxes(200, 25, 60) + spheres(100, 5, 0.6, 25, 45) + spheres(300, 7, 0.82, 45))


def stored_step(maker, scene, settings, setting, frame, state):
    """The next frame's contact problem with the solution of `setting`, and how long it took to solve."""
    def make():
        folder = tempfile.mkdtemp(dir=os.path.join(maker.folder, 'scratch'))
        try:
            path = os.path.join(folder, 'step.h5')
            maker.unibody(
                scene, settings + setting.values() + [f'time.frames={frame + 1}', 'output.every=0'], os.path.join(folder, 'out'),
                1, ['-dump_fclib', path, '-dump_step', str(frame + 1)], state)
            row = report_rows(os.path.join(folder, 'out'))[-1]
            keep = os.path.join(maker.folder, 'states', key + '.h5')
            os.replace(path, keep)
            return {'ms': 1e3 * sum(float(v) for k, v in row.items() if k.split('(')[0].strip() in ('wall_solve', 'wall_halo'))}
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    key = maker.key(scene, settings + setting.values(), 1, ['dump', frame], state)
    return os.path.join(maker.folder, 'states', key + '.h5'), maker.keep(key, f'{scene} {setting.name()}: a contact problem', make)['ms']


def siconos(maker, path, tolerance):
    """What Siconos makes of the problem, or why it does not."""
    if importlib.util.find_spec('siconos') is None:
        return {'failed': 'python3-siconos is not installed'}
    script = os.path.join(ROOT, 'scripts', 'rivals', 'solve_siconos.py')

    def make():
        words = [sys.executable, script, path, tolerance, str(maker.pick(1000, 20000, 100000)), '--json']
        try:
            done = subprocess.run(
                ['taskset', '-c', str(maker.core), *words], text=True, capture_output=True, check=False,
                timeout=maker.pick(60, 120, 900))
        except subprocess.TimeoutExpired as late:
            return {'failed': f'not done in {late.timeout:.0f} s'}
        if done.returncode != 0:
            return {'failed': (done.stderr.strip().splitlines() or ['ended in an error'])[-1][-200:]}
        return {'found': json.loads(done.stdout.strip().splitlines()[-1])}

    return maker.keep(f'siconos_{maker.mark(script)}_{os.path.basename(path)}_{tolerance}', f'Siconos, {tolerance}', make, ours=False)


def reached(found, tolerance, problem):
    """Whether Siconos says so, and the natural map of its impulses agrees."""
    return bool(found['converged'] and problem.measures(np.array(found['r']))['residual'] <= float(tolerance))


def rows_of(maker, name, scene, settings, frame):
    careful = ['solver.name=accelerated_jacobi', 'solver.iterations=200', 'time.substeps=4']
    state = maker.state(scene, settings + careful, frame)
    solved = [(setting, *stored_step(maker, scene, settings, setting, frame, state)) for setting in OURS]
    problem = Problem(solved[0][1])
    theirs = [(tolerance, siconos(maker, solved[0][1], tolerance)) for tolerance in THEIRS]
    best = np.array(theirs[-1][1]['found']['r']) if 'found' in theirs[-1][1] else None
    rows = []

    def add(solver, ms, r, within=None):
        measures = problem.measures(r)
        apart = differences(problem, r, best) if best is not None else {'velocities': None, 'impulses': None}
        rows.append([
            name, frame + 1, len(problem.mu), solver, ms, float(measures['residual']), float(measures['complementarity']),
            apart['velocities'], apart['impulses'], within])

    for setting, path, ms in solved:
        own = Problem(path)
        assert np.array_equal(own.q, problem.q) and np.array_equal(own.values, problem.values), 'not the same problem'
        add(setting.name(), ms, own.r)
    for tolerance, said in theirs:
        if 'found' not in said:
            rows.append([name, frame + 1, len(problem.mu), f'Siconos to {tolerance}: {said["failed"]}'] + [None] * (len(COLUMNS) - 4))
            continue
        found = said['found']
        add(
            f'Siconos NSGS to {tolerance}, {found["iterations"]} iterations' + ('' if found['converged'] else ', not converged'),
            1e3 * found['seconds'], np.array(found['r']), reached(found, tolerance, problem))
    return rows


def make(maker):
    rows = [row for wish in problems(maker) for row in rows_of(maker, *wish)]
    table = Table(
        'contact_problems',
        (
            'one step from one state, h = 16 ms: natural map |r - P(r - u^ / W)| / |r| by scripts/rivals/fclib.py of each one\'s'
            ' impulses; differences over the norm of Siconos\' finest'
        ),
        COLUMNS,
        rows,
        'scripts/report contact_problems',
    )
    return Section(
        TITLE,
        [
            (
                'The step\'s contact problem is written by `-dump_fclib`; all settings of ours have the same matrix, free'
                ' velocities and friction to the bit, and Siconos (NSGS, the distribution\'s build, a sparse matrix) solves that.'
                ' Ours takes what multipliers the state holds, Siconos starts from zero. Impulses of many contacts are not unique'
                ' where bodies have more of them than they need: two solutions to round-off may differ in impulses and agree in'
                ' all velocities.'
            ),
            (
                'Within the tolerance: Siconos says so, and so does the natural map of what it found. Where its finest solution is not,'
                ' the differences from it are known no better than that one is. In jammed piles of spheres with friction the velocities are not unique either, and all solvers creep: what tells'
                ' then is the natural map. With two stages (the default) what a step leaves undone is split between its stages,'
                ' so that its residual is not meant to vanish with few iterations; stages together converge to the problem\'s'
                ' solution.'
            ),
        ],
        [table],
    )
