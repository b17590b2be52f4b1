"""An objective with an edge, behind which no candidate has an equilibrium."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from springopt.checks import Floats
from springopt.errors import NoEquilibrium
from springopt.forward.status import MECHANISM

if TYPE_CHECKING:
    from scipy.sparse.linalg import LinearOperator


class Cliff:
    """The objective itself where the first stiffness is at most `edge`; values at the cap and no derivatives behind.

    Args:
        objective: any that a problem takes.
        edge: of the first stiffness [force/length]; -1 leaves nothing before the edge.
        cap: what every candidate behind the edge costs.
    """

    def __init__(self, objective: Any, edge: float, *, cap: float = 1e6) -> None:
        self._objective, self._edge, self._cap = objective, edge, cap

    def __getattr__(self, name: str) -> Any:
        return getattr(self._objective, name)

    def evaluate(self, stiffness: Floats) -> Any:
        """Values and codes of candidates, shape (m, s) -> (m,)."""
        found, lost = self._objective.evaluate(stiffness), stiffness[:, 0] > self._edge
        values, codes = np.where(lost, self._cap, found.values), np.where(lost, MECHANISM, found.codes)
        return SimpleNamespace(values=values, codes=codes.astype(np.int8))

    def gradient(self, stiffness: Floats) -> tuple[float, Floats]:
        return self._before_the_edge(stiffness).gradient(stiffness)

    def residuals(self, stiffness: Floats) -> Floats:
        return self._before_the_edge(stiffness).residuals(stiffness)

    def jacobian(self, stiffness: Floats) -> tuple[Floats, Floats]:
        return self._before_the_edge(stiffness).jacobian(stiffness)

    def linearize(self, stiffness: Floats) -> tuple[Floats, LinearOperator]:
        return self._before_the_edge(stiffness).linearize(stiffness)

    def _before_the_edge(self, stiffness: Floats) -> Any:
        if stiffness[0] > self._edge:
            raise NoEquilibrium(f"there is no equilibrium where the first stiffness is above {self._edge:g}.")
        return self._objective
