"""From a start down to a minimum of a scene's own misfit, with the derivatives that the problem gives.

Levenberg and Marquardt's method on the residuals comes first: it finds the least-squares optimum from nearly anywhere.
Where the misfit is a mean distance, that is only near its minimum, and the misfit has a kink wherever a node's distance
is zero, which many are at the minimum. So the residuals are made linear, the sum of distances of the linear ones is
minimized kinks and all, and so on from there, as Gauss and Newton do with squares (Burke and Ferris 1995, Math.
Program. 71). The next minimum is looked for as far away as the last step was good for, or twice as far where all of it
was good: a trust region. The last digits are those of L-BFGS-B by the adjoint gradient.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares, minimize

from springopt.analysis.sum_of_distances import least_sum_of_distances
from springopt.checks import Floats
from springopt.errors import NoEquilibrium
from springopt.problem import Problem

#: Relative change of a value, or of the box's width, that ends a descent.
SMALL = 1e-12
STEPS = 50  # linearizations
SHORTEST_STEP = 1e-3


def least_squares_optimum(problem: Problem, start: Floats) -> Floats:
    """The point, shape (size,), where the least squares end from a start that has an equilibrium."""

    def residuals(point: Floats) -> Floats:
        try:
            return problem.residuals(point)
        except NoEquilibrium:
            return np.full(count, np.inf)  # the step is refused and the next one shorter

    count = len(problem.residuals(start))
    box = (problem.lower, problem.upper)
    stop = {"xtol": SMALL, "ftol": SMALL, "gtol": SMALL}
    return least_squares(residuals, start, lambda point: problem.jacobian(point)[1], bounds=box, **stop).x


def distance_optimum(problem: Problem, start: Floats, dimension: int) -> Floats:
    """The point, shape (size,), where the sum of node distances ends from a start that has an equilibrium."""
    point, value, reach = start, float(problem.evaluate(start[None])[0]), np.inf
    for _ in range(STEPS):
        residuals, jacobian = problem.jacobian(point)
        target = _linear_optimum(problem, point, residuals, jacobian, dimension, reach)
        last, before, (point, value) = point, value, _step_towards(problem, point, value, target)
        if before - value <= SMALL * before:
            break
        aimed, made = np.abs(target - last).max(), np.abs(point - last).max()
        reach = made if made < 0.99 * aimed else 2 * made
    return gradient_optimum(problem, point)


def _linear_optimum(
    problem: Problem, point: Floats, residuals: Floats, jacobian: Floats, dimension: int, reach: float
) -> Floats:
    """The minimum of the sum of node distances of r + J (z - x), over the box and as far as `reach` in every number."""
    blocks = jacobian.reshape(-1, dimension, problem.size)
    goals = (jacobian @ point - residuals).reshape(-1, dimension)
    moves = blocks.any(axis=(1, 2))
    lower, upper = np.maximum(problem.lower, point - reach), np.minimum(problem.upper, point + reach)
    return least_sum_of_distances(blocks[moves], goals[moves], point, lower, upper)


def _step_towards(problem: Problem, point: Floats, value: float, target: Floats) -> tuple[Floats, float]:
    """The point on the way to the target, and its value: steps are halved until they are lower, and then no more.

    A full step that is lower may still lie on the other side of a valley, where the next one would lead back.
    """
    best, lowest, step = point, value, 1.0
    while step >= SHORTEST_STEP:
        trial = np.clip(point + step * (target - point), problem.lower, problem.upper)
        trial_value = float(problem.evaluate(trial[None])[0])
        if trial_value < lowest:
            best, lowest = trial, trial_value
        elif lowest < value:
            break
        step /= 2
    return best, lowest


def gradient_optimum(problem: Problem, start: Floats) -> Floats:
    """The lowest point, shape (size,), that L-BFGS-B by the adjoint gradient comes by; it needs no Jacobian.

    At a kink its line search may give up where it was not lowest.
    """
    best, lowest = start, np.inf

    def value_and_gradient(trial: Floats) -> tuple[float, Floats]:
        nonlocal best, lowest
        try:
            value, gradient = problem.gradient(trial)
        except NoEquilibrium:
            return float(problem.evaluate(trial[None])[0]), np.zeros_like(trial)
        if value < lowest:
            best, lowest = trial.copy(), value
        return value, gradient

    box = list(zip(problem.lower, problem.upper, strict=True))
    stop = {"maxcor": 30, "maxiter": 500, "ftol": 1e-15, "gtol": 1e-14}
    minimize(value_and_gradient, start, jac=True, bounds=box, method="L-BFGS-B", options=stop)
    return best
