"""A problem that finds the best by solving everything: what races are compared with."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from springopt.problem import Problem
from springopt.race import Best, best_of


class Unraced(Problem):
    """A problem whose `best_of` is `evaluate` and a sort."""

    def best_of(self, points: ArrayLike, count: int, *, rivals: ArrayLike = ()) -> Best:
        """See `Problem.best_of`."""
        return best_of(self.evaluate(points), count, np.asarray(rivals, dtype=float))
