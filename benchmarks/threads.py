"""Threads: wall time of the forward solve with one thread and with several, on the inputs of `forward.py`.

    ./run python benchmarks/threads.py [--threads 2] [--repeats 9]

One and several threads take turns, so that what else the machine does falls on both; the figure is the median of the
ratios of neighbours, with its quartiles. Means something only where as many cores are free: processor time beside wall
time tells. That no bit of the answers depends on the number of threads is asserted on the way.
"""

import argparse
import dataclasses
import os
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from forward import candidates, load, load_cases

import springopt as so

COUNTS = {"P1": 2000, "P1-turning": 2000, "P2": 400, "P3": 8}


def row(job: str, kind: str, threads: int, repeats: int) -> str:
    data = load(job)
    cases = load_cases(data, turning=job.endswith("turning"))
    lattice = so.SpringLattice(data["nodes"], data["springs"], data["rest_lengths"])
    one, many = so.Model(lattice), so.Model(lattice, threads=threads)
    groups, stiffness = one.groups(cases), candidates(data, kind, COUNTS[job])
    require_same(one.find(groups, stiffness, 1e-8), many.find(groups, stiffness, 1e-8))
    seconds = np.array([[timed(model, groups, stiffness) for model in (one, many)] for _ in range(repeats)])
    low, middle, high = np.quantile(seconds[:, 0, 0] / seconds[:, 1, 0], [0.25, 0.5, 0.75])
    walls, cores = np.median(seconds[:, :, 0], axis=0), np.median(seconds[:, 1, 1] / seconds[:, 1, 0])
    return (
        f"| {job} {kind} | {walls[0]:.3f} s | {walls[1]:.3f} s | {middle:.2f} ({low:.2f} to {high:.2f}) | {cores:.2f} |"
    )


def require_same(one: object, other: object) -> None:
    for item in dataclasses.fields(one):  # type: ignore[arg-type]
        np.testing.assert_array_equal(getattr(one, item.name), getattr(other, item.name))


def timed(model: so.Model, groups: tuple, stiffness: np.ndarray) -> tuple[float, float]:
    """Wall and processor seconds of one batch."""
    wall, processor = time.perf_counter(), time.process_time()
    model.find(groups, stiffness, 1e-8)
    return time.perf_counter() - wall, time.process_time() - processor


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=9)
    arguments = parser.parse_args()
    print(f"| job | one thread | {arguments.threads} threads | ratio (quartiles) | cores in use |")
    print("|---|---|---|---|---|")
    for job in COUNTS:
        for kind in ("near", "uniform", "binary") if job != "P3" else ("uniform",):
            print(row(job, kind, arguments.threads, arguments.repeats), flush=True)


if __name__ == "__main__":
    main()
