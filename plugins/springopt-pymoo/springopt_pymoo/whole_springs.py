"""Two goals, and pymoo's operators for numbers of which 0 means that a spring is not there."""

from __future__ import annotations

from typing import Any

import numpy as np
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM

from springopt.checks import Booleans, Floats
from springopt.problem import Problem
from springopt_pymoo.search import Scene


def spring_operators(crossover_eta: float, mutation_eta: float, switched: float) -> dict[str, Any]:
    """Operators that inherit, take out and put in whole springs; `switched` is the share that mutation does so with."""
    mutation = _Switches(eta=mutation_eta, switched=min(switched, 1.0))
    return {"crossover": _WholeSprings(eta=crossover_eta, prob=0.9), "mutation": mutation}


class TwoGoals(Scene):
    """The value and the number of springs, under the constraint that there is an equilibrium.

    Without it the front would go on to no springs at all, through candidates that fail with ever fewer of them.
    """

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem, n_obj=2, n_ieq_constr=1)
        # An objective without physics need not have a cap.
        self.cap = getattr(problem.objective, "cost_cap", np.inf)

    def _evaluate(self, individuals: Any, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self.problem.objectives(individuals)
        value = out["F"][:, :1]
        out["G"] = np.where(value < self.cap, -1.0, value)  # what is positive violates, the graded cost the more


def _absent(points: Floats) -> Booleans:
    """Which springs are not there: a stiffness is never below 0."""
    return points == 0.0


class _WholeSprings(SBX):
    """Simulated binary crossover between springs; one that a parent lacks is inherited whole, or not at all.

    Between 0 and a stiffness it would leave a weak spring in place of none.
    """

    def _do(self, problem: Any, parents: Floats, *args: Any, random_state: Any = None, **kwargs: Any) -> Floats:
        children = super()._do(problem, parents, *args, random_state=random_state, **kwargs)
        exchanged = random_state.random(parents.shape[1:]) < 0.5
        return np.where(_absent(parents).any(axis=0), np.where(exchanged, parents[::-1], parents), children)


class _Switches(PM):
    """Polynomial mutation of the springs that are there; some are taken out, and absent ones put in at random."""

    def __init__(self, *, switched: float, **options: Any) -> None:
        super().__init__(**options)
        self.switched = switched

    def _do(self, problem: Any, points: Floats, *args: Any, random_state: Any = None, **kwargs: Any) -> Floats:
        moved = super()._do(problem, points, *args, random_state=random_state, **kwargs)
        moved = np.where(_absent(points), points, moved)
        switched = (random_state.random(points.shape) < self.switched) & (problem.xl == 0.0)
        new = np.where(_absent(points), random_state.uniform(problem.xl, problem.xu, points.shape), 0.0)
        return np.where(switched, new, moved)
