#!/usr/bin/python3
"""How far a stored frictional contact problem's solution is from solving it: one formula for everybody's solutions.

usage: scripts/rivals/fclib.py FILE...     files of unibody's -dump_fclib, or of FCLIB, in its local form u = W r + q
Prints for each the number of contacts and of the stored solution (/solution) or, without one, of the first guess
  residual          |r - P(r - u^ / W_k)| / |r|, with u^ = u + mu |u_T| n, P the projection on Coulomb's cone, W_k the mean of the
                    diagonal of the contact's own block; 0 only at a solution
  primal, dual      how far r is outside of the cone, over |r|, and u^ outside of the dual cone (m/s)
  complementarity   the largest |r . u^| of a contact (J)
"""
import os
import sys

import h5py
import numpy as np


def read(path):
    """The problem of a file, for programs: ends them with one line where there is none."""
    if not os.path.exists(path):
        sys.exit(f'{os.path.basename(sys.argv[0])}: {path}: no such file')
    try:
        return Problem(path)
    except (OSError, KeyError, ValueError) as fault:
        why = ' '.join(str(fault.args[0] if isinstance(fault, KeyError) else fault).split())
        sys.exit(f'{os.path.basename(sys.argv[0])}: {path}: not a frictional contact problem of FCLIB that can be read ({why})')


class Problem:
    """W in compressed columns or rows (it is symmetric) or triplets, q, mu, and r, the solution (N s; normal, two tangents)."""

    def __init__(self, path):
        with h5py.File(path) as file:
            local = file['fclib_local']
            if int(local['spacedim'][0]) != 3:
                raise ValueError(f'{path}: expected a problem in space')
            w = local['W']
            self.size, form = int(w['m'][0]), int(w['nz'][0])
            self.rows, self.values, p = w['i'][:], w['x'][:], w['p'][:]
            self.columns = p if form >= 0 else np.repeat(np.arange(self.size), np.diff(p))
            self.q, self.mu = local['vectors/q'][:], local['vectors/mu'][:]
            stored = file.get('solution', file.get('guesses/1'))
            self.r = None if stored is None else stored['r'][:]

    def times_w(self, r):
        return np.bincount(self.rows, self.values * r[self.columns], self.size)

    def dense(self):
        w = np.zeros((self.size, self.size))
        np.add.at(w, (self.rows, self.columns), self.values)
        return w

    def scales(self):
        on = self.rows == self.columns
        return np.bincount(self.rows[on], self.values[on], self.size).reshape(-1, 3).mean(axis=1)

    def measures(self, r):
        mu, f = self.mu, r.reshape(-1, 3)
        u = (self.times_w(r) + self.q).reshape(-1, 3)
        u[:, 0] += mu * np.hypot(u[:, 1], u[:, 2])
        size = max(np.linalg.norm(r), np.finfo(float).tiny)
        return {'residual': np.linalg.norm(f - project(f - u / self.scales()[:, None], mu)) / size,
                'primal': np.linalg.norm(f - project(f, mu)) / size,
                'dual': np.linalg.norm(u - (u + project(-u, mu))),  # Moreau: u = P*(u) - P(-u)
                'complementarity': np.abs((f * u).sum(axis=1)).max(initial=0)}


def project(f, mu):
    """The nearest points of the cones |f_T| <= mu f_n."""
    tangential = np.hypot(f[:, 1], f[:, 2])
    n = (f[:, 0] + mu * tangential) / (1 + mu**2)
    scale = np.divide(mu * n, tangential, out=np.zeros_like(n), where=tangential > 0)
    nearest = np.where((mu * tangential <= -f[:, 0])[:, None], 0, np.column_stack([n, f[:, 1] * scale, f[:, 2] * scale]))
    return np.where(((tangential <= mu * f[:, 0]) & (f[:, 0] >= 0))[:, None], f, nearest)


def told(measures):
    return ', '.join(f'{name} {value:.3g}' for name, value in measures.items())


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith('-'):
        print(__doc__.strip())
        return 0 if sys.argv[1:] in (['-h'], ['--help']) else 2
    for path in sys.argv[1:]:
        problem = read(path)
        if problem.r is None:
            print(f'{path}: {len(problem.mu)} contacts, no solution')
        else:
            print(f'{path}: {len(problem.mu)} contacts, {told(problem.measures(problem.r))}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
