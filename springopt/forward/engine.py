"""What an engine is: one way to find equilibria and their derivatives, for all load cases with the same supports."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from springopt.forward.state import Answers, Jobs

ITERATION_LIMIT = 2000  # for the weakest loads on mechanisms; hardly any other takes more than 100

Floats = NDArray[np.float64]


class Factors(Protocol):
    """Tangents that were factorized, or are ready to be solved with again and again."""

    def solve(self, loads: Floats) -> Floats:
        """K^-1 of `loads` (g, k, n d), k of them for each load case, in the same shape.

        Zero at the supports, and along modes without stiffness.
        """


class Engine(Protocol):
    """All engines search by the same rules, so that they end in the same minimum; see `newton`."""

    def find(self, jobs: Jobs, answers: Answers, tolerance: float) -> None:
        """Answer the jobs, which are sorted by candidate; `tolerance` as in `Model.solve`.

        Threads that call it at the same time with the same jobs and answers share the work.
        """

    def factorize(self, candidate: Floats, displacements: Floats) -> Factors:
        """The tangents of one candidate (s + p,) at its equilibria (g, n d), one for each load case."""
