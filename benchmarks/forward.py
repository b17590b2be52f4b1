"""The forward solve: candidates per processor second, beside what a competent SciPy user writes.

    ./run python benchmarks/forward.py [--jobs P1 P1-turning P2 P3] [--repeats 5]

One core, one BLAS thread, cold start, every equilibrium to a residual of 1e-8 of the load. Candidates: *near* the
reference stiffness (from the file), *uniform* (k from U(0.5, 10)), *binary* (10 % of the springs removed). Each figure
is the median of the repeats, with the least and the greatest; the yardstick solves fewer candidates in the same
process. P1-turning: the loads of P1 turned by quarters, their supports with them.
"""

import argparse
import importlib.util
import os
import time
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import springopt as so
from springopt.forward.batch import find

HERE = Path(__file__).parent
COUNTS = {"P1": 200, "P1-turning": 200, "P2": 40, "P3": 2}
YARDSTICK_COUNTS = {"P1": 6, "P1-turning": 6, "P2": 6, "P3": 1}
#: What issue and plan ask for, as multiples of the yardstick.
WANTED = {
    ("P1", "near"): 33,
    ("P1", "uniform"): 26,
    ("P1", "binary"): 16,
    ("P2", "near"): 8,
    ("P2", "uniform"): 6,
    ("P2", "binary"): 7,
    ("P3", "uniform"): 2.5,
}


def yardstick_module() -> object:
    specification = importlib.util.spec_from_file_location("scipy_newton", HERE / "peers" / "scipy_newton.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def load(job: str) -> dict[str, np.ndarray]:
    return dict(np.load(HERE / "data" / f"{job.removesuffix('-turning')}.npz"))


def candidates(data: dict[str, np.ndarray], kind: str, count: int) -> np.ndarray:
    spring_count, rng = len(data["springs"]), np.random.default_rng(7)
    if kind == "near":
        return np.resize(data["candidates"], (count, spring_count))
    if kind == "uniform":
        return rng.uniform(0.5, 10, (count, spring_count))
    return data["reference_stiffness"] * (rng.random((count, spring_count)) > 0.1)


def load_cases(data: dict[str, np.ndarray], *, turning: bool) -> list[so.LoadCase]:
    """The file's, or each turned about the body's middle by so many quarters, supports and forces alike."""
    cases = []
    middle = data["nodes"].mean(axis=0)
    for number, forces in enumerate(data["loads"]):
        supports = data["fixed"]
        for _ in range(number % 4 if turning else 0):
            turned = (data["nodes"] - middle) @ [[0, 1], [-1, 0]] + middle
            order = [int(np.linalg.norm(data["nodes"] - node, axis=1).argmin()) for node in turned]
            supports, forces = supports[np.argsort(order)], (forces @ [[0, 1], [-1, 0]])[np.argsort(order)]
        cases.append(so.LoadCase(f"{number}", supports, forces))
    return cases


def rates(solve: Callable[[], int], count: int, repeats: int) -> tuple[np.ndarray, int]:
    """Candidates per processor second, sorted, and equilibria found in the last repeat."""
    found, rate = 0, []
    for _ in range(repeats):
        start = time.process_time()
        found = solve()
        rate.append(count / (time.process_time() - start))
    return np.sort(rate), found


def ours(data: dict[str, np.ndarray], cases: list[so.LoadCase], stiffness: np.ndarray) -> Callable[[], int]:
    lattice = so.SpringLattice(data["nodes"], data["springs"], data["rest_lengths"])
    groups = so.Model(lattice).groups(cases)
    largest = np.array([np.linalg.norm(case.forces, axis=1).max() for case in cases])

    def solve() -> int:
        equilibria = find(groups, stiffness, tolerance=1e-8)
        return int(((equilibria.codes <= 1) & (equilibria.residuals <= 1e-8 * largest)).sum())

    solve()  # compiles, and makes the plan's pages warm
    return solve


def theirs(data: dict[str, np.ndarray], cases: list[so.LoadCase], stiffness: np.ndarray) -> Callable[[], int]:
    peer = yardstick_module()
    nets = [peer.Net({**data, "fixed": case.supports[:, 0]}) for case in cases]  # type: ignore[attr-defined]

    def solve() -> int:
        return sum(
            net.solve(k, case.forces, 1e-8 * np.linalg.norm(case.forces, axis=1).max())[1]
            for k in stiffness
            for net, case in zip(nets, cases, strict=True)
        )

    return solve


def row(job: str, kind: str, repeats: int) -> str:
    data = load(job)
    cases = load_cases(data, turning=job.endswith("turning"))
    count, few = COUNTS[job], YARDSTICK_COUNTS[job]
    stiffness = candidates(data, kind, count)
    our_rates, found = rates(ours(data, cases, stiffness), count, repeats)
    their_rates, _ = rates(theirs(data, cases, stiffness[:few]), few, max(1, repeats // 2))
    ours_here, theirs_here = np.median(our_rates), np.median(their_rates)
    wanted = WANTED.get((job, kind))
    return (
        f"| {job} {kind} | {ours_here:,.4g} ({our_rates[0]:,.4g} to {our_rates[-1]:,.4g}) | {theirs_here:.3g} "
        f"| {ours_here / theirs_here:.1f} | {wanted or '-'} | {found} of {count * len(cases)} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", nargs="+", choices=list(COUNTS), default=list(COUNTS))
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    print("| job | candidates per processor second | the yardstick | ratio | wanted ratio | equilibria found |")
    print("|---|---|---|---|---|---|")
    for job in arguments.jobs:
        for kind in ("near", "uniform", "binary"):
            if (job, kind) in WANTED or job == "P1-turning":
                print(row(job, kind, arguments.repeats), flush=True)


if __name__ == "__main__":
    main()
