#!/usr/bin/python3
"""Solves a stored frictional contact problem with Siconos (apt-get install python3-siconos) and compares the two solutions.

usage: scripts/rivals/solve_siconos.py FILE [TOLERANCE [ITERATIONS]] [--json]     FILE of unibody's -dump_fclib; 1e-10, 100000
       scripts/rivals/solve_siconos.py FILE --text TO     writes the problem in Siconos' text form instead; needs no Siconos
Its nonsmooth Gauss-Seidel (NSGS) starts from zero, on the sparse matrix W. Both solutions are measured by one formula (fclib.py);
the velocities are compared because they are what moves bodies: impulses of many contacts are not unique. Ends with 1 where
Siconos does not reach the tolerance. --json prints r, its iterations, seconds and whether it converged instead.
"""
import json
import sys
import time

import numpy as np

from fclib import read, told


def solve(problem, tolerance, iterations):
    """{'r', 'converged', 'iterations', 'seconds' of the solve alone}."""
    import siconos.numerics as sn
    from scipy.sparse import coo_matrix
    w = coo_matrix((problem.values, (problem.rows, problem.columns)), shape=(problem.size, problem.size)).tocsc()
    w.indices, w.indptr = w.indices.astype(np.int64), w.indptr.astype(np.int64)
    contact = sn.FrictionContactProblem(3, len(problem.mu), w, problem.q, problem.mu)
    options = sn.SolverOptions(sn.SICONOS_FRICTION_3D_NSGS)
    options.dparam[sn.SICONOS_DPARAM_TOL] = tolerance
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = iterations
    r, u = np.zeros(problem.size), np.zeros(problem.size)
    begin = time.perf_counter()
    failed = sn.fc3d_nsgs(contact, r, u, options)
    return {'r': r, 'converged': failed == 0, 'iterations': int(options.iparam[sn.SICONOS_IPARAM_ITER_DONE]), 'seconds': time.perf_counter() - begin}


def text_of(problem):
    """The problem as Siconos' frictionContact_newFromFilename reads it: dimension, contacts, W (0: dense, which alone it reads back as it
    was; its size; by columns), q, mu; to the last bit."""
    def line(values):
        return ' '.join(f'{v:.17g}' for v in values)

    n = problem.size
    head = ['3', str(len(problem.mu)), '0', str(n), str(n), f'{n} {n}']
    return '\n'.join([*head, *map(line, problem.dense().T), line(problem.q), line(problem.mu)]) + '\n'


def differences(problem, ours, theirs):
    """Of the impulses and of the velocities that they make, over the norms of theirs."""
    return {name: float(np.linalg.norm(a - b) / max(np.linalg.norm(b), np.finfo(float).tiny))
            for name, a, b in (('impulses', ours, theirs), ('velocities', problem.times_w(ours), problem.times_w(theirs)))}


def main():
    words = [w for w in sys.argv[1:] if w != '--json']
    to = words.pop(words.index('--text') + 1) if '--text' in words[:-1] else None
    words = [w for w in words if to is None or w != '--text']
    if len(words) not in (1, 2, 3) or any(w.startswith('-') for w in words):
        print(__doc__.strip())
        return 0 if words in (['-h'], ['--help']) else 2
    problem = read(words[0])
    if to is not None:
        with open(to, 'w', encoding='ascii') as file:
            file.write(text_of(problem))
        return 0
    found = solve(problem, float(words[1]) if len(words) > 1 else 1e-10, int(words[2]) if len(words) > 2 else 100000)
    if '--json' in sys.argv:
        print(json.dumps(dict(found, r=found['r'].tolist())))
        return 0
    if problem.r is not None:
        print(f'stored:  {told(problem.measures(problem.r))}')
    print(f'Siconos: {told(problem.measures(found["r"]))}' + ('' if found['converged'] else ' (not converged)'))
    if problem.r is not None:
        for name, value in differences(problem, problem.r, found['r']).items():
            print(f'{name} differ by {value:.3g} of their norm')
    return 0 if found['converged'] else 1


if __name__ == '__main__':
    sys.exit(main())
