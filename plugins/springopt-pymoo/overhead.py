"""The processor time that each algorithm itself takes for a generation, on a problem that costs nothing.

./run python plugins/springopt-pymoo/overhead.py
"""

import contextlib
import time

import numpy as np
from springopt_pymoo.cma_es import CMAES
from springopt_pymoo.de import DE
from springopt_pymoo.ga import GA
from springopt_pymoo.mixed_ga import MixedGA
from springopt_pymoo.nsga2 import NSGA2
from springopt_pymoo.pso import PSO
from threadpoolctl import threadpool_limits

import springopt as so
from springopt.budget import Budget
from springopt.optimizer import Optimizer
from springopt.testing import Bowl, Box

GENERATIONS = 50
REAL = Box(np.zeros(72), np.full(72, 10.0))
BITS = Box(np.zeros(468), np.ones(468), kind="binary")


def milliseconds(optimizer: Optimizer, box: Box, population: int) -> float:
    """A generation's share of the processor time, setting up included."""
    problem = so.Problem(Bowl((box.lower + box.upper) / 2), box, Budget(evaluations=GENERATIONS * population))
    start = time.process_time()
    with contextlib.suppress(so.BudgetSpent):
        optimizer.minimize(problem, np.random.default_rng(0))
    return 1000 * (time.process_time() - start) / GENERATIONS


def main() -> None:
    print("| optimizer | individuals | 72 numbers [ms] | 468 bits [ms] |\n| --- | --- | --- | --- |")
    for optimizer in (GA(), GA(population=10), DE(), PSO(), CMAES(population=16), MixedGA(), NSGA2()):
        population: int = optimizer.population  # type: ignore[attr-defined]
        real = f"{milliseconds(optimizer, REAL, population):.1f}"
        bits = "-" if "real" in optimizer.needs else f"{milliseconds(optimizer, BITS, population):.1f}"
        print(f"| `{optimizer.name}` | {population} | {real} | {bits} |")


if __name__ == "__main__":
    with threadpool_limits(1, user_api="blas"):  # as in every run
        main()
