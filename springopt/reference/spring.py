"""A mass-spring model as reference: what it should be possible to find again."""

import numpy as np
from numpy.typing import ArrayLike

from springopt.checks import Floats
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.model import Model


class SpringReference:
    """Deforms as `model` does with this stiffness [force/length], one number or shape (s,)."""

    def __init__(self, model: Model, stiffness: ArrayLike, *, tolerance: float = 1e-10) -> None:
        self.model = model
        self.stiffness: Floats = np.broadcast_to(np.asarray(stiffness, dtype=float), (model.lattice.spring_count,))
        self.tolerance = tolerance

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
