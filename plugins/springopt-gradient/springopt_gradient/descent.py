"""Levenberg-Marquardt steps from one point to the nearest minimum of a measure of the residuals, within the box."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from springopt.checks import Floats
from springopt.errors import NoEquilibrium
from springopt.problem import Problem
from springopt_gradient.measures import Measure

#: Damping of the first step, in units of the mean curvature.
DAMPING = 1e-2
#: A step is taken if the value falls by this share of what the model promised.
ACCEPTED = 1e-4
#: Above this share the model is trusted more, below the other one less.
GOOD, POOR = 0.75, 0.25
EASED, TIGHTENED = 0.1, 4.0
#: Damping stays above this: it keeps what no load case sees in place.
LEAST_DAMPING = 1e-12
#: Steps below this share of the box end the search.
SETTLED = 1e-7


@dataclass(frozen=True, eq=False)
class Linearization:
    """The residuals at a point and their derivatives."""

    point: Floats  #: shape (size,)
    residuals: Floats  #: shape (r,)
    jacobian: Floats  #: by shares of the box, shape (r, size)


def linearize(problem: Problem, point: Floats) -> Linearization:
    """Raises NoEquilibrium; two evaluations."""
    residuals, jacobian = problem.jacobian(point)
    return Linearization(point, residuals, jacobian * (problem.upper - problem.lower))


def descend(
    problem: Problem,
    here: Linearization,
    measure: Measure,
    *,
    tolerance: float,
    damping: float = DAMPING,
    upper: Floats | None = None,
) -> Linearization:
    """Goes down until the model promises a relative decrease below the tolerance, or a step too small to matter.

    The damping follows the ratio of the decrease to what the model promised, after Marquardt (1963) and Nielsen
    (1999). After a good step the next trial asks for the Jacobian at once; after a poor one first for the residuals,
    which cost half: of two evaluations none is wasted while all goes well.
    """
    size = problem.upper - problem.lower
    highest = problem.upper if upper is None else upper
    value, model = measure.value(here.residuals), measure.model(here.residuals, here.jacobian)
    growth, trusted = 2.0, True
    while True:
        step = model.step(damping, (problem.lower - here.point) / size, (highest - here.point) / size)
        promised = value - measure.value(here.residuals + here.jacobian @ step)
        if promised <= tolerance * value or np.abs(step).max() <= SETTLED:
            return here
        point = np.clip(here.point + size * step, problem.lower, highest)
        there, reached = _try(problem, point, measure, at_once=trusted)
        ratio = (value - reached) / promised
        if ratio > ACCEPTED:
            here, value, growth = there or linearize(problem, point), reached, 2.0
            model = measure.model(here.residuals, here.jacobian)
            problem.note(damping=damping, value=problem.objective.value_of(here.residuals))
            damping = max(damping * (EASED if ratio > GOOD else TIGHTENED if ratio < POOR else 1.0), LEAST_DAMPING)
        else:
            damping, growth = damping * growth, 2.0 * growth
        trusted = ratio > POOR


def _try(problem: Problem, point: Floats, measure: Measure, *, at_once: bool) -> tuple[Linearization | None, float]:
    """The value of the measure at a point, inf without an equilibrium; and the linearization, if asked for at once."""
    try:
        there = linearize(problem, point) if at_once else None
        return there, measure.value(there.residuals if there else problem.residuals(point))
    except NoEquilibrium:
        return None, math.inf
