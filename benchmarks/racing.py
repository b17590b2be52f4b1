"""Racing: what it saves on the paper's scenes to solve candidates only as far as the best of a batch need it.

    ./run python benchmarks/racing.py [--repeats 3] [--evaluations 2000] [--scenes NAME ...] [--loosest 1e-3]

Three ways to answer `problem.best_of` take turns, in one process and on one seed: everything is solved; candidates are
raced; and raced with tolerances up to the loosest while values are spread. Figures are processor seconds of the whole
run, medians over the repeats, and the ratio to the first way, with the least and the greatest. That raced runs ask as
many evaluations and find the same point is asserted on the way; of loose ones the cost is printed that they end at,
beside that of the first way.
"""

import argparse
import contextlib
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

import springopt as so
from springopt.optimizer import Optimizer
from springopt.options import make_optimizer
from springopt.registry import load_optimizer
from springopt.testing import Unraced

SCENES = (
    "paper-fem-2d",
    "paper-fem-2d-8",
    "paper-fem-2d-4",
    "paper-stiffness-2d",
    "paper-topology-2d-isotropic",
    "paper-topology-2d-anisotropic",
    "paper-topology-3d",
)
METHODS = {
    "paper-ga, generational": ("paper-ga", {"survival": "generational"}),
    "paper-ga, compete": ("paper-ga", {"survival": "compete"}),
    "pymoo-ga": ("pymoo-ga", {}),
    "annealing": ("annealing", {}),
    "random-search": ("random-search", {}),
}


@dataclass(frozen=True)
class Timed:
    """A run that has ended."""

    problem: so.Problem
    seconds: float  #: of the processor


def timed(optimizer: Optimizer, make_problem: Callable[[], so.Problem]) -> Timed:
    problem = make_problem()
    begun = time.process_time()
    with contextlib.suppress(so.BudgetSpent):
        optimizer.minimize(problem, np.random.default_rng(0))
    return Timed(problem, time.process_time() - begun)


def rows(scene_name: str, evaluations: int, repeats: int, loosest: float) -> Iterator[str]:
    scene = so.load_scene(scene_name)
    setup = scene.build()
    parts = (setup.objective, setup.encoding)
    for title, (name, options) in METHODS.items():
        optimizer = make_optimizer(load_optimizer(name), {**scene.optimizer_options(name), **options})

        def ways(budget: so.Budget) -> list[Callable[[], so.Problem]]:
            return [
                lambda: Unraced(*parts, budget),
                lambda: so.Problem(*parts, budget),
                lambda: so.Problem(*parts, budget, loosest_tolerance=loosest),
            ]

        for way in ways(so.Budget(evaluations=200)):  # the first time is for nothing
            timed(optimizer, way)
        turns = [one_turn(optimizer, ways(so.Budget(evaluations=evaluations)), first) for first in range(repeats)]
        yield row(f"| {scene_name} | {title} |", turns)


def one_turn(optimizer: Optimizer, ways: list[Callable[[], so.Problem]], first: int) -> list[Timed]:
    """Each way once; which of them begins changes from turn to turn."""
    order = [(first + number) % len(ways) for number in range(len(ways))]
    runs = {number: timed(optimizer, ways[number]) for number in order}
    return [runs[number] for number in range(len(ways))]


def row(head: str, turns: list[list[Timed]]) -> str:
    plain, raced, loose = (run.problem for run in turns[0])
    require_same(plain, raced)
    told = loose.loose_selections
    assert told is not None
    cost = "the same" if loose.best_value == plain.best_value else f"{loose.best_value / plain.best_value:.3f} times"
    return (
        f"{head} {statistics.median(whole.seconds for whole, _, _ in turns):.2f} s "
        f"| {saved(raced, plain)} | {ratios([other.seconds / whole.seconds for whole, other, _ in turns])} "
        f"| {saved(loose, plain)} | {ratios([other.seconds / whole.seconds for whole, _, other in turns])} "
        f"| {told.differed} of {told.compared} | {cost} |"
    )


def require_same(one: so.Problem, other: so.Problem) -> None:
    assert (one.meter.evaluations, one.best_value) == (other.meter.evaluations, other.best_value)
    np.testing.assert_array_equal(one.best_point, other.best_point)


def saved(problem: so.Problem, plain: so.Problem) -> str:
    """The share of the solves that was not made; below 0 where more were."""
    return f"{1.0 - problem.meter.solves / plain.meter.solves:.0%}"


def ratios(numbers: list[float]) -> str:
    return f"{statistics.median(numbers):.2f} ({min(numbers):.2f} to {max(numbers):.2f})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--evaluations", type=int, default=2000, help="of each run")
    parser.add_argument("--scenes", nargs="+", default=SCENES, metavar="NAME")
    parser.add_argument("--loosest", type=float, default=1e-3, help="tolerance of a loose selection")
    arguments = parser.parse_args()
    print(
        "| scene | optimizer | all solved | raced: solves saved | raced: time | loose: solves saved | loose: time "
        "| loose: selections that differed | loose: cost |\n" + "|---" * 9 + "|"
    )
    for scene in arguments.scenes:
        for line in rows(scene, arguments.evaluations, arguments.repeats, arguments.loosest):
            print(line, flush=True)


if __name__ == "__main__":
    main()
