#!/usr/bin/python3
"""Solves a stored frictional contact problem with Siconos (apt-get install python3-siconos) and compares the two solutions.

usage: scripts/rivals/solve_siconos.py FILE [TOLERANCE [ITERATIONS]]     FILE of unibody's -dump_fclib; 1e-10, 100000
Its nonsmooth Gauss-Seidel (NSGS) starts from zero, on the full matrix W. Both solutions are measured by one formula (fclib.py);
the velocities are compared because they are what moves bodies: impulses of many contacts are not unique. Ends with 1 where
Siconos does not reach the tolerance.
"""
import sys

import numpy as np

from fclib import Problem, told


def solve(problem, tolerance, iterations):
    """r and whether it converged."""
    import siconos.numerics as sn
    w = problem.dense()
    contact = sn.FrictionContactProblem(3, len(problem.mu), w, problem.q, problem.mu)
    options = sn.SolverOptions(sn.SICONOS_FRICTION_3D_NSGS)
    options.dparam[sn.SICONOS_DPARAM_TOL] = tolerance
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = iterations
    r, u = np.zeros(problem.size), np.zeros(problem.size)
    return r, sn.fc3d_nsgs(contact, r, u, options) == 0


def main():
    if len(sys.argv) not in (2, 3, 4) or sys.argv[1].startswith('-'):
        print(__doc__.strip())
        return 0 if sys.argv[1:] in (['-h'], ['--help']) else 2
    problem = Problem(sys.argv[1])
    tolerance = float(sys.argv[2]) if len(sys.argv) > 2 else 1e-10
    iterations = int(sys.argv[3]) if len(sys.argv) > 3 else 100000
    r, converged = solve(problem, tolerance, iterations)
    if problem.r is not None:
        print(f'stored:  {told(problem.measures(problem.r))}')
    print(f'Siconos: {told(problem.measures(r))}' + ('' if converged else ' (not converged)'))
    if problem.r is not None:
        for name, ours, theirs in (('impulses', problem.r, r), ('velocities', problem.times_w(problem.r), problem.times_w(r))):
            print(f'{name} differ by {np.linalg.norm(ours - theirs) / np.linalg.norm(theirs):.3g} of their norm')
    return 0 if converged else 1


if __name__ == '__main__':
    sys.exit(main())
