"""pymoo's loop on a springopt problem: one generation is one question, and the budget unwinds the loop."""

from __future__ import annotations

from typing import Any

import numpy as np
from pymoo.algorithms.base.genetic import GeneticAlgorithm
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem as PymooProblem
from pymoo.core.termination import NoTermination

from springopt.checks import Floats
from springopt.problem import Problem

ATTEMPTS = 10  # at children that are nobody's duplicates; then a generation is smaller


class Scene(PymooProblem):
    """The problem as pymoo sees it: a box, and values for a whole generation at once.

    Args:
        problem: what is asked.
        facts: what else pymoo's Problem takes; `vars` stand in place of the box.
    """

    def __init__(self, problem: Problem, **facts: Any) -> None:
        box = {"n_var": problem.size, "xl": problem.lower, "xu": problem.upper}
        super().__init__(**{"n_obj": 1} | ({} if "vars" in facts else box) | facts)
        self.problem = problem

    def _evaluate(self, individuals: Any, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self.problem.evaluate(self.points(individuals))[:, None]

    def points(self, individuals: Any) -> Floats:
        """What pymoo's individuals stand for, shape (m, size)."""
        return individuals


class Survivors(Scene):
    """A scene whose children need a value only if they are among the best of parents and children, who live on."""

    def __init__(self, problem: Problem, **facts: Any) -> None:
        super().__init__(problem, requires_kwargs=True, **facts)  # the algorithm, with its parents

    def _evaluate(self, individuals: Any, out: dict[str, Any], *args: Any, algorithm: Any, **kwargs: Any) -> None:
        points = self.points(individuals)
        parents = np.array([parent.F[0] for parent in algorithm.pop])
        best = self.problem.best_of(points, algorithm.pop_size, rivals=parents)
        values = np.full((len(points), 1), np.inf)
        values[best.places, 0] = best.values
        out["F"] = values


def search(algorithm: Algorithm, scene: Scene, rng: np.random.Generator) -> None:
    """Generation after generation until the budget is spent, or until pymoo finds nothing new to ask.

    No criterion of pymoo ends it earlier, and all operators draw from `rng`.
    """
    algorithm.setup(scene, termination=NoTermination())
    algorithm.random_state = rng
    if isinstance(algorithm, GeneticAlgorithm):
        algorithm.mating.n_max_iterations = ATTEMPTS
    while algorithm.has_next():
        algorithm.next()


def first_generation(problem: Problem, rng: np.random.Generator, count: int) -> Any:
    """Points to begin with, shape (count, size); truth values in a binary box, as pymoo's operators want them."""
    points = problem.sample(rng, count)
    return points.astype(bool) if problem.kind == "binary" else points
