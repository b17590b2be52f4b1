"""Is the knee of `sparse-path` the true topology? On sparse random references of `paper-stiffness-2d`.

    ./run python benchmarks/sparse_path_knees.py [--references 10]

The references are those of `sparse_references.py`, without noise: 65 to 90 % of the 72 springs, none of which a set of
supports can do without, of stiffness 2 to 8. `sparse-path` begins at a random point, or at what the force balance
gives. Prints Markdown: how many references have their true topology in the front, the largest objective there [length]
and the smallest with a spring fewer, and the median of evaluations.
"""

import argparse
import contextlib
import statistics

import numpy as np
from sparse_references import UPPER, Reference, make_reference, run
from threadpoolctl import threadpool_limits

import springopt as so
from springopt.encoding import Real
from springopt.options import make_optimizer
from springopt.registry import load_optimizer

SCENE = "paper-stiffness-2d"


def path(reference: Reference, seed: int, *, balanced: bool) -> so.Problem:
    """A problem after `sparse-path` went two springs beyond the truth."""
    objective = so.Objective(reference.model, reference.cases, reference.positions, "distance")
    problem = so.Problem(objective, Real(reference.model.lattice, upper=UPPER), so.Budget(evaluations=5000))
    rng = np.random.default_rng(seed)
    if balanced:
        problem.start_at(run("balance", problem, rng))
    optimizer = make_optimizer(load_optimizer("sparse-path"), {"fewest": int(reference.present.sum()) - 2})
    with contextlib.suppress(so.BudgetSpent), threadpool_limits(1, user_api="blas"):
        optimizer.minimize(problem, rng)
    return problem


def knee(problem: so.Problem, reference: Reference) -> tuple[bool, float, float]:
    """Whether the front has the true topology, the objective there, and that with one spring fewer at least."""
    springs, values, points = problem.front.springs, problem.front.values, problem.front.points
    count = reference.present.sum()
    fewer = float(values[springs < count].min(initial=np.inf))
    at = np.flatnonzero(springs == count)
    if not len(at):
        return False, np.inf, fewer
    return bool(((points[at[0]] > 0) == reference.present).all()), float(values[at[0]]), fewer


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--references", type=int, default=10, help="how many")
    count = parser.parse_args().references
    references = [make_reference(SCENE, seed) for seed in range(count)]
    print("| start | true topology | objective there, at most | one spring fewer, at least | evaluations |")
    print("|---|---|---|---|---|")
    for name, balanced in (("random", False), ("force balance", True)):
        problems = [path(reference, seed, balanced=balanced) for seed, reference in enumerate(references)]
        found, there, fewer = zip(*map(knee, problems, references), strict=True)
        evaluations = statistics.median(problem.meter.evaluations for problem in problems)
        print(f"| {name} | {sum(found)} of {count} | {max(there):.1e} | {min(fewer):.1e} | {evaluations:g} |")


if __name__ == "__main__":
    main()
