"""How the equilibria of one candidate move with its row k of stiffness and parameters, by the factors of their
tangents K.

With F the internal forces, K du = -(dF/dk) dk. So a derivative along dk takes one solve; the gradient of a function of
the positions, with g its derivatives by u, is -(dF/dk)^T lambda with K lambda = g, one solve as well (the adjoint
method); the whole Jacobian takes one for each free coordinate. Modes without stiffness are kept at rest here too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springopt.effects.lanes import LANE_COUNT
from springopt.effects.probe import force_derivatives, pulls_of_law
from springopt.forward.batch import Group
from springopt.forward.engine import Factors
from springopt.forward.spring_forces import forces_at_nodes, forces_per_stiffness, work_per_stiffness
from springopt.forward.terms import Terms

Floats = NDArray[np.float64]

ROWS_AT_ONCE = 4_000_000  # numbers on the right-hand sides of one solve: 32 MB


@dataclass(frozen=True, eq=False)
class Linearization:
    """The derivatives of all equilibria of one candidate, factorized once."""

    groups: Sequence[Group]
    factors: Sequence[Factors]  #: of each group
    pulls: Floats  #: of the springs per stiffness, shape (c, s, d)
    #: Derivatives of the internal forces by the columns behind the stiffness, shape (c, p, n d); 0 where they are not
    #: fitted, and (c, 0, n d) where none is.
    by_parameters: Floats

    def along(self, change: Floats) -> Floats:
        """The derivative of the displacements along a change (s + p,) of the row, shape (c, n d)."""
        plan = self.groups[0].plan
        springs, values = np.split(change, [len(plan.ends)])
        loads = forces_at_nodes(plan.ends, self.pulls, springs, len(plan.nodes))
        if self.by_parameters.shape[1]:
            loads -= values @ self.by_parameters
        return self._solve(loads[:, None])[:, 0]

    def against(self, loads: Floats) -> Floats:
        """The derivative (s + p,) of a function of all displacements by the row; `loads` (c, n d), that by them."""
        return self._against(self._solve(loads[:, None])).sum(axis=(0, 1))

    def jacobian(self) -> Floats:
        """The derivatives of the displacements by the row, shape (c, n d, s + p)."""
        count, columns = len(self.pulls), self.pulls.shape[1] + self.by_parameters.shape[1]
        size = self.groups[0].plan.nodes.size
        answers = np.zeros((count, size, columns))
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
        springs = work_per_stiffness(self.groups[0].plan.ends, self.pulls, adjoints)
        if not self.by_parameters.shape[1]:
            return springs
        return np.concatenate([springs, -adjoints @ self.by_parameters.transpose(0, 2, 1)], axis=2)


def linearize(groups: Sequence[Group], row: Floats, displacements: Floats) -> Linearization:
    """At the equilibria (c, n d) of one candidate's row (s + p,) under the load cases of all groups."""
    is_linear = groups[0].choice.engine == "linear"
    terms, springs = groups[0].terms, groups[0].plan
    stiffness, values = np.split(row, [len(springs.ends)])
    pulls = forces_per_stiffness(springs, displacements, is_linear=is_linear)
    pulls += _pulls_of_laws(terms, values, displacements, is_linear=is_linear)
    by_parameters = _by_parameters(terms, stiffness, values, displacements, is_linear=is_linear)
    with terms.failures_raised():
        factors = [group.engine.factorize(row, displacements[group.cases]) for group in groups]
    return Linearization(groups, factors, pulls, by_parameters)


def _pulls_of_laws(terms: Terms, values: Floats, displacements: Floats, *, is_linear: bool) -> Floats | float:
    """What effects that are laws of the springs add to their pulls."""
    return sum(
        pulls_of_law(
            term.effect,
            terms.lattice,
            displacements,
            values=values[term.columns],
            fitted=terms.fitted_of(term),
            is_linear=is_linear,
        )
        for term, _ in terms.potentials
        if term.effect.scales_with_stiffness
    )


def _by_parameters(
    terms: Terms, stiffness: Floats, values: Floats, displacements: Floats, *, is_linear: bool
) -> Floats:
    """Derivatives of the internal forces by the columns behind the stiffness, see `Linearization`."""
    derivatives = np.zeros((len(displacements), len(values) if terms.fitted else 0, displacements.shape[1]))
    for term, kernel in terms.potentials:
        if not terms.fitted_of(term):
            continue
        for case, u in enumerate(displacements):
            derivatives[case, term.columns] = force_derivatives(
                term.effect,
                kernel,
                terms.lattice,
                u,
                stiffness=stiffness,
                values=values[term.columns],
                is_linear=is_linear,
            )
    return derivatives
