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
    """Derivatives of the residuals at one stiffness.

    The unknowns are those of the encoding; of one without derivatives (bits) they are the stiffnesses of its springs.
    """

    stiffness: Floats  #: [force/length], shape (s,)
    springs: Floats  #: residuals by stiffness, shape (r, s)
    spread: Floats  #: stiffness by unknown, shape (s, u)
    unknowns: Floats  #: residuals by unknown, shape (r, u)
    widths: Floats  #: of the unknowns' intervals, shape (u,)


def sensitivity(objective: Objective, encoding: Encoding, point: Point) -> Sensitivity:
    """The Jacobian of all training load cases; a UserError where one of them has no equilibrium."""
    stiffness = encoding.decode(point.numbers)
    springs = jacobian(objective, stiffness, point.said)
    spread = by_unknowns(encoding, point, np.eye(len(stiffness)))
    if encoding.differentiable:
        widths = encoding.upper - encoding.lower
    else:
        widths = encoding.decode(encoding.upper) - encoding.decode(encoding.lower)
    return Sensitivity(stiffness, springs, spread, by_unknowns(encoding, point, springs), widths)


def by_unknowns(encoding: Encoding, point: Point, derivatives: Floats) -> Floats:
    """Derivatives by stiffness, shape (r, s), by the unknowns, shape (r, u)."""
    return encoding.pull_back(point.numbers, derivatives) if encoding.differentiable else derivatives


def jacobian(objective: Objective, stiffness: Floats, said: str) -> Floats:
    """Residuals by stiffness (s,), shape (r, s), at equilibria that are exact to rounding."""
    training = sum(case.role == "train" for case in objective.cases)
    entries = training * objective.model.lattice.nodes.size * len(stiffness)
    if entries > LARGEST:
        raise UserError(
            f"the Jacobian of this scene has {entries:,} entries, and here up to {LARGEST:,} are looked at at once; "
            "choose a coarser lattice."
        )
    exact = replace(objective, tolerance=min(objective.tolerance, TOLERANCE))
    try:
        return exact.jacobian(stiffness)[1]
    except NoEquilibrium as error:
        raise UserError(f"there are no derivatives {said}: {error} Choose another point.") from None


def objective_of(objective: Objective, cases: Sequence[LoadCase]) -> Objective:
    """The same model under other load cases, all to learn from; its reference is the rest shape."""
    model, training = objective.model, [replace(case, role="train") for case in cases]
    return Objective(model, training, np.stack([model.lattice.nodes] * len(cases)))
