"""The analytic start of a scene: the formula's stiffness that needs no search, asked of the optimizer of that name."""

from __future__ import annotations

import numpy as np

from springopt.budget import Budget
from springopt.checks import Floats
from springopt.errors import BudgetSpent, NoEquilibrium, UserError
from springopt.optimizer import require_supplies
from springopt.problem import Problem
from springopt.registry import installed, load_optimizer
from springopt.scene import Setup

NAME = "analytic"


def analytic_start(setup: Setup) -> tuple[Floats, float] | None:
    """Point (size,) and value; None where no such optimizer is installed, or where it has no formula for the scene."""
    if NAME not in installed():
        return None
    optimizer = load_optimizer(NAME)()
    problem = Problem(setup.objective, setup.encoding, Budget(evaluations=10))
    try:
        require_supplies(optimizer, problem.supplies)
        optimizer.minimize(problem, np.random.default_rng(0))
    except BudgetSpent:
        pass
    except (UserError, NoEquilibrium):
        return None
    return None if problem.best_point is None else (problem.best_point, problem.best_value)
