"""A mass-spring model as reference: what it should be possible to find again."""

import numpy as np
from numpy.typing import ArrayLike

from springopt.checks import Floats, floats, require_nonnegative, require_positive, require_shape
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.model import Model


class SpringReference:
    """Deforms as `model` does with this stiffness [force/length], one number or shape (s,).

    Raises UserError for a stiffness of another shape, negative or not finite, and for a tolerance that is not positive.
    """

    def __init__(self, model: Model, stiffness: ArrayLike, *, tolerance: float = 1e-10) -> None:
        self.model = model
        given = require_nonnegative("stiffness", floats("stiffness", stiffness))
        count = model.lattice.spring_count
        self.stiffness = np.repeat(given, count) if given.ndim == 0 else require_shape("stiffness", given, (count,))
        self.tolerance = require_positive("tolerance", tolerance)

    def deform(self, case: LoadCase) -> Floats:
        """Positions [length] (n, d) under one load case; without an equilibrium there is nothing to learn from."""
        solution = self.model.solve(self.stiffness, [case], self.tolerance)
        status = solution.status[0]
        if not status.has_equilibrium:
            raise UserError(
                f"The reference must have an equilibrium in load case {case.name!r}, but it ended as {status}; "
                "add springs or change the load."
            )
        return solution.positions[0]
