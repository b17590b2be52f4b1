"""What an engine is: one way to find equilibria and their derivatives, for all load cases with the same supports."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from springopt.forward.state import Answers, Jobs

ITERATION_LIMIT = 2000  # for the weakest loads on mechanisms; hardly any other takes more than 100

Floats = NDArray[np.float64]


class Engine(Protocol):
    """All engines search by the same rules, so that they end in the same minimum; see `newton`."""

    def find(self, jobs: Jobs, answers: Answers, tolerance: float) -> None:
        """Answer the jobs, which are sorted by candidate; `tolerance` as in `Model.solve`.

        Threads that call it at the same time with the same jobs and answers share the work.
        """

    def gradients(self, stiffness: Floats, displacements: Floats, loads: Floats) -> Floats:
        """d(g . u)/dk for each load case, shape (g, s).

        `stiffness` (s,); `displacements` (g, n d), the equilibria; `loads` (g, n d), the gradients g with respect to u.
        """

    def jacobians(self, stiffness: Floats, displacements: Floats) -> Floats:
        """du/dk for each load case, shape (g, n d, s); arguments as in `gradients`."""
