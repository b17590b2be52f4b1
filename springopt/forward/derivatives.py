"""How the equilibria of one candidate move with its stiffness k, by the factors of their tangents K.

With F the internal forces, K du = -(dF/dk) dk. So a derivative along dk takes one solve; the gradient of a function of
the positions, with g its derivatives by u, is -(dF/dk)^T lambda with K lambda = g, one solve as well (the adjoint
method); the whole Jacobian takes one for each free coordinate. Modes without stiffness are kept at rest here too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springopt.effects.lanes import LANE_COUNT
from springopt.forward.batch import Group
from springopt.forward.engine import Factors
from springopt.forward.spring_forces import forces_at_nodes, forces_per_stiffness, work_per_stiffness

Floats = NDArray[np.float64]

ROWS_AT_ONCE = 4_000_000  # numbers on the right-hand sides of one solve: 32 MB


@dataclass(frozen=True, eq=False)
class Linearization:
    """The derivatives of all equilibria of one candidate, factorized once."""

    groups: Sequence[Group]
    factors: Sequence[Factors]  #: of each group
    pulls: Floats  #: of the springs per stiffness, shape (c, s, d)

    def along(self, change: Floats) -> Floats:
        """The derivative of the displacements along a change (s,) of the stiffness, shape (c, n d)."""
        plan = self.groups[0].plan
        loads = forces_at_nodes(plan.ends, self.pulls, change, len(plan.nodes))
        return self._solve(loads[:, None])[:, 0]

    def against(self, loads: Floats) -> Floats:
        """The derivative (s,) of a function of all displacements by the stiffness; `loads` (c, n d), that by them."""
        return self._against(self._solve(loads[:, None])).sum(axis=(0, 1))

    def jacobian(self) -> Floats:
        """The derivatives of the displacements by the stiffness, shape (c, n d, s)."""
        count, spring_count = self.pulls.shape[:2]
        size = self.groups[0].plan.nodes.size
        answers = np.zeros((count, size, spring_count))
        times_held = np.bincount(np.concatenate([group.plan.supported for group in self.groups]), minlength=size)
        free = np.flatnonzero(times_held < len(self.groups))
        few = max(LANE_COUNT, ROWS_AT_ONCE // (count * size))
        for rows in (free[begin : begin + few] for begin in range(0, len(free), few)):
            units = np.zeros((count, len(rows), size))
            units[:, np.arange(len(rows)), rows] = 1.0
            answers[:, rows] = self._against(self._solve(units))
        return answers

    def _solve(self, loads: Floats) -> Floats:
        """K^-1 of loads (c, k, n d)."""
        if len(self.groups) == 1:
            return self.factors[0].solve(loads)
        answers = np.empty_like(loads)
        for group, factors in zip(self.groups, self.factors, strict=True):
            answers[group.cases] = factors.solve(loads[group.cases])
        return answers

    def _against(self, adjoints: Floats) -> Floats:
        return work_per_stiffness(self.groups[0].plan.ends, self.pulls, adjoints)


def linearize(groups: Sequence[Group], stiffness: Floats, displacements: Floats) -> Linearization:
    """At the equilibria (c, n d) of one candidate (s,) under the load cases of all groups."""
    is_linear = groups[0].choice.engine == "linear"
    pulls = forces_per_stiffness(groups[0].plan, displacements, is_linear=is_linear)
    factors = [group.engine.factorize(stiffness, displacements[group.cases]) for group in groups]
    return Linearization(groups, factors, pulls)
