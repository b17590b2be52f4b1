#!/usr/bin/env python3
"""What a competent SciPy user writes: banded Newton, one equilibrium at a time. Candidates per processor second.

Usage: scipy_newton.py [P1 P2 P3] [--sets near uniform binary] [--repeats 3]; needs numpy and scipy. One BLAS thread.
The yardstick for benchmarks/forward.py: run both in the same session and quote the ratio.
"""
import argparse, os, pathlib, time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp

CASES = pathlib.Path(__file__).resolve().parent.parent / "data"


class Net:
    def __init__(self, z):
        self.x0, self.L0, fixed = z["nodes"], z["rest_lengths"], z["fixed"]
        self.i, self.j = z["springs"].T
        n, d = self.x0.shape
        m = len(self.i)
        self.free = np.flatnonzero(~fixed)
        dof = -np.ones((n, d), int)
        dof[self.free] = np.arange(len(self.free) * d).reshape(-1, d)
        self.size = len(self.free) * d
        incidence = sp.csr_matrix((np.r_[-np.ones(m), np.ones(m)], (np.tile(np.arange(m), 2), np.r_[self.i, self.j])), shape=(m, n))
        self.scatter = incidence[:, self.free].T.tocsr()
        rows, cols, src, sign = [], [], [], []
        for a, b, s in ((self.i, self.i, 1.0), (self.j, self.j, 1.0), (self.i, self.j, -1.0), (self.j, self.i, -1.0)):
            for p in range(d):
                for q in range(d):
                    r, c = dof[a, p], dof[b, q]
                    keep = (r >= c) & (c >= 0)
                    rows.append(r[keep]); cols.append(c[keep]); sign.append(np.full(keep.sum(), s))
                    src.append((np.arange(m) * d * d + p * d + q)[keep])
        rows, cols, src, sign = map(np.concatenate, (rows, cols, src, sign))
        self.width = int((rows - cols).max())
        key, inverse = np.unique(rows * self.size + cols, return_inverse=True)
        self.assemble = sp.csr_matrix((sign, (inverse, src)), shape=(len(key), m * d * d))
        r, c = key // self.size, key % self.size
        self.band = (r - c, c)
        self.eye = np.eye(d)

    def springs(self, x):
        d = x[self.j] - x[self.i]
        return d, np.sqrt(np.einsum("md,md->m", d, d))

    def gradient(self, k, x, f):
        d, L = self.springs(x)
        return (self.scatter @ ((k * (1 - self.L0 / L))[:, None] * d) - f[self.free]).ravel()

    def energy(self, k, x, f):
        return 0.5 * k @ (self.springs(x)[1] - self.L0) ** 2 - np.vdot(f, x)

    def tangent(self, k, x, convex=False):
        d, L = self.springs(x)
        a = k * (1 - self.L0 / L)
        if convex:
            a = np.maximum(a, 0)
        blocks = d[:, :, None] * d[:, None, :] * ((k - a) / L**2)[:, None, None] + a[:, None, None] * self.eye
        out = np.zeros((self.width + 1, self.size))
        out[self.band] = self.assemble @ blocks.ravel()
        return out

    def solve(self, k, f, tolerance):
        x = self.x0.copy()
        g = self.gradient(k, x, f)
        for _ in range(200):
            if np.abs(g).max() <= tolerance:
                return x, True
            try:
                step = sl.solveh_banded(self.tangent(k, x), g, lower=True, overwrite_ab=True, check_finite=False)
            except np.linalg.LinAlgError:
                ab = self.tangent(k, x, convex=True)
                ab[0] += 1e-8 * ab[0].max()
                step = sl.solveh_banded(ab, g, lower=True, check_finite=False)
            t, e0, slope = 1.0, None, -g @ step
            while True:
                y = x.copy()
                y[self.free] -= t * step.reshape(-1, x.shape[1])
                gy = self.gradient(k, y, f)
                if np.linalg.norm(gy) < np.linalg.norm(g) or t < 1e-8:
                    break
                e0 = self.energy(k, x, f) if e0 is None else e0
                if self.energy(k, y, f) <= e0 + 1e-4 * t * slope:
                    break
                t /= 2
            x, g = y, gy
        return x, False


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("jobs", nargs="*", default=["P1", "P2", "P3"])
    ap.add_argument("--sets", nargs="+", default=["near", "uniform"])
    ap.add_argument("--repeats", type=int, default=3)
    a = ap.parse_args()
    for job in a.jobs:
        z = np.load(CASES / f"{job}.npz")
        net, rng, count = Net(z), np.random.default_rng(7), 1 if job == "P3" else 6
        m = len(z["rest_lengths"])
        sets = {"near": z["candidates"][:count], "uniform": rng.uniform(0.5, 10, (count, m)),
                "binary": z["reference_stiffness"] * (rng.random((count, m)) > 0.1)}
        for name in a.sets:
            times, found = [], 0
            for _ in range(a.repeats):
                t, found = time.process_time(), 0
                for k in sets[name]:
                    for f in z["loads"]:
                        found += net.solve(k, f, 1e-8 * np.linalg.norm(f, axis=1).max())[1]
                times.append(time.process_time() - t)
            print(f"{job} {name}: {count / np.median(times):.3g} candidates per processor second, {found} of {count * len(z['loads'])} equilibria found")


if __name__ == "__main__":
    main()
