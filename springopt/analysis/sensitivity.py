"""How the positions of a scene's load cases depend on its unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springopt.analysis.point import Point
from springopt.checks import Floats
from springopt.encoding import Encoding
from springopt.errors import NoEquilibrium, UserError
from springopt.load_case import LoadCase
from springopt.objective import Objective

TOLERANCE = 1e-12  # of the forward solve: a rank is judged by what is exactly zero
LARGEST = 10**8  # entries of a Jacobian that is made at once, 0.8 GB


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives of the residuals at one candidate: its stiffness, and the parameters of effects that are fitted.

    The unknowns are those of the encoding; of one without derivatives (bits) they are the stiffnesses of its springs.
    A parameter counts in units in which its interval is as wide as those of the others, or ranks would mean nothing.
    """

    row: Floats  #: stiffness [force/length] and behind it the parameters, shape (s + f,)
    by_row: Floats  #: residuals by these, shape (r, s + f)
    units: Floats  #: of the unknowns, 1 but for parameters, shape (u,)
    spread: Floats  #: stiffness and parameters by unknown, shape (s + f, u)
    unknowns: Floats  #: residuals by unknown, shape (r, u)
    widths: Floats  #: of the unknowns' intervals, shape (u,)


def sensitivity(objective: Objective, encoding: Encoding, point: Point) -> Sensitivity:
    """The Jacobian of all training load cases; a UserError where one of them has no equilibrium."""
    row = encoding.decode(point.numbers)
    derivatives = jacobian(objective, row, point.said)
    spread = by_unknowns(encoding, point, np.eye(len(row)))
    if encoding.differentiable:
        widths = encoding.upper - encoding.lower
    else:
        widths = encoding.decode(encoding.upper) - encoding.decode(encoding.lower)
    of_springs = spread[: objective.model.lattice.spring_count].any(axis=0)
    units = np.where(of_springs, 1.0, widths / widths[of_springs].mean())
    unknowns = by_unknowns(encoding, point, derivatives) * units
    return Sensitivity(row, derivatives, units, spread * units, unknowns, widths / units)


def by_unknowns(encoding: Encoding, point: Point, derivatives: Floats) -> Floats:
    """Derivatives by stiffness and parameters, shape (r, s + f), by the unknowns, shape (r, u)."""
    return encoding.pull_back(point.numbers, derivatives) if encoding.differentiable else derivatives


def jacobian(objective: Objective, row: Floats, said: str) -> Floats:
    """Residuals by stiffness and parameters (s + f,), shape (r, s + f), at equilibria that are exact to rounding."""
    training = sum(case.role == "train" for case in objective.cases)
    entries = training * objective.reference_positions[0].size * len(row)
    if entries > LARGEST:
        raise UserError(
            f"the Jacobian of this scene has {entries:,} entries, and here up to {LARGEST:,} are looked at at once; "
            "choose a coarser lattice."
        )
    exact = replace(objective, tolerance=min(objective.tolerance, TOLERANCE))
    try:
        return exact.jacobian(row)[1]
    except NoEquilibrium as error:
        raise UserError(f"there are no derivatives {said}: {error} Choose another point.") from None


def objective_of(objective: Objective, cases: Sequence[LoadCase]) -> Objective:
    """The same model under other load cases, all to learn from; its reference is the rest shape."""
    model, training = objective.model, [replace(case, role="train") for case in cases]
    times = [] if cases[0].times is None else [len(cases[0].times)]
    shape = (len(cases), *times, *model.lattice.nodes.shape)
    return Objective(model, training, np.broadcast_to(model.lattice.nodes, shape))
