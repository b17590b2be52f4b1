"""What derivatives cost: value and gradient together, and the Jacobian, in values of one candidate.

    ./run python benchmarks/derivatives.py [--repeats 15]

On the inputs of `forward.py`, mean distance to the reference stiffness's own equilibria. Value and derivatives of the
same candidate take turns, so that what else the machine does falls on both; a figure is the median over all candidates
and repeats of the ratios, with its quartiles, in processor time on one core.
"""

import argparse
import os
import time
from collections.abc import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from forward import candidates, load, load_cases

import springopt as so

JOBS = ("P1", "P1-turning", "P2")
COUNT = 40


def row(job: str, kind: str, repeats: int) -> str:
    data = load(job)
    cases = load_cases(data, turning=job.endswith("turning"))
    model = so.Model(so.SpringLattice(data["nodes"], data["springs"], data["rest_lengths"]))
    objective = so.Objective(model, cases, model.solve(data["reference_stiffness"], cases).positions)
    calls = (lambda k: objective.evaluate(k[None]), objective.gradient, objective.jacobian)
    stiffness = candidates(data, kind, COUNT)
    seconds = np.array([[timed(call, k) for call in calls] for _ in range(repeats + 1) for k in stiffness])[COUNT:]
    gradient, jacobian = (quartiles(seconds[:, i] / seconds[:, 0]) for i in (1, 2))
    return f"| {job} {kind} | {1e3 * np.median(seconds[:, 0]):.3f} ms | {gradient} | {jacobian} |"


def timed(call: Callable[[np.ndarray], object], stiffness: np.ndarray) -> float:
    start = time.process_time()
    call(stiffness)
    return time.process_time() - start


def quartiles(ratios: np.ndarray) -> str:
    low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75])
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=15)
    arguments = parser.parse_args()
    print("| job | one value | value and gradient | residuals and Jacobian |")
    print("|---|---|---|---|")
    for job in JOBS:
        for kind in ("near", "uniform", "binary"):
            print(row(job, kind, arguments.repeats), flush=True)


if __name__ == "__main__":
    main()
