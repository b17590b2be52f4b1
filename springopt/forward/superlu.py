"""A sparse matrix and its factor by SuperLU: direct solution where a band would be too wide.

The order is our own nested dissection, so the pivots stay on the diagonal and the factor is L D L^T in disguise: its
pivots tell the inertia. SuperLU can't replace a pivot; a matrix that is not positive definite is shifted instead.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import SuperLU, splu, spsolve_triangular

from springopt.forward.factor import ZERO_PIVOT
from springopt.forward.layout import Layout, lay_out
from springopt.forward.pattern import Pattern, PatternMatrix
from springopt.forward.plan import Plan

Floats = NDArray[np.float64]

# The first shift, as a share of the scale: a mode that just curves down takes a long step, which the search limits.
SMALLEST_SHIFT = 1e-5
REGULAR = 1e-15  # the share of the scale that makes a matrix regular, without hiding its zero pivots


@dataclass(eq=False)
class Sparse(PatternMatrix):
    """A `Matrix` in compressed columns; changes itself when it is factorized."""

    _factor: Any = field(init=False, default=None)
    _lower: Any = field(init=False, default=None)

    def clear(self) -> None:
        super().clear()
        self._factor = self._lower = None

    def factorize(self, replacement: float) -> None:
        """See `Matrix`; a matrix that is not positive definite is shifted by its scale until it is.

        With a `replacement` of 1 or more, only zero pivots are in the way, and it is their unknowns that are stiffened.
        """
        diagonal, scale = self.entries[self.pattern.diagonal], self.scale[self.pattern.order]
        is_empty = diagonal == 0.0
        self.entries[self.pattern.diagonal[is_empty]] = scale[is_empty]  # nodes without springs stay at rest
        shift, pivots = 0.0, self._try(0.0)
        while pivots is None:  # exactly singular: far less than a pivot that counts as zero makes it regular
            shift = max(10.0 * shift, REGULAR)
            pivots = self._try(shift)
        self._count(pivots, int(np.count_nonzero(is_empty)))
        is_zero = np.abs(pivots) <= ZERO_PIVOT
        if replacement >= 1.0 and not self.inertia[0] and is_zero.any():
            self.entries[self.pattern.diagonal[is_zero]] += replacement * scale[is_zero]
            self._try(0.0)
            return
        shift = 0.0
        while pivots is None or not (pivots > ZERO_PIVOT).all():
            shift = max(10.0 * shift, SMALLEST_SHIFT)
            pivots = self._try(shift)

    def solve(self, sides: Floats) -> Floats:
        solution = np.empty_like(sides)
        solution[self.pattern.order] = self._factor.solve(np.ascontiguousarray(sides[self.pattern.order]))
        return solution

    def negative_direction(self) -> Floats:
        lower, factor = self._lower
        unit = np.zeros(len(self.pattern.order))
        unit[factor.perm_c[self.pattern.places[int(self.inertia[2])]]] = 1.0
        direction = spsolve_triangular(lower.T.tocsr(), unit, lower=False, unit_diagonal=True)[factor.perm_c]
        return direction[self.pattern.places]

    def _try(self, shift: float) -> Floats | None:
        """The pivots over their scale, with this share of the scale on the diagonal; None where it is singular."""
        scale, pattern = self.scale[self.pattern.order], self.pattern.whole
        whole = csc_array((self.entries[pattern.data - 1], pattern.indices, pattern.indptr), shape=pattern.shape)
        whole.setdiag(whole.diagonal() + shift * scale)
        try:
            factor: SuperLU = splu(whole, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError:
            return None
        if (factor.perm_r != factor.perm_c).any():  # a pivot of exactly zero was passed over
            return None
        self._factor = factor
        return factor.U.diagonal()[factor.perm_c] / scale

    def _count(self, pivots: Floats, empty_count: int) -> None:
        """The inertia of the factor that was made last."""
        lowest, negative_count = int(pivots.argmin()), np.count_nonzero(pivots < -ZERO_PIVOT)
        self.inertia[:2] = negative_count, np.count_nonzero(np.abs(pivots) <= ZERO_PIVOT) + empty_count
        self.inertia[2:] = -1.0, -ZERO_PIVOT
        if negative_count:
            self.inertia[2:] = self.pattern.order[lowest], pivots[lowest]
            self._lower = self._factor.L, self._factor


@dataclass(frozen=True, eq=False)
class SuperLUSolver:
    """Sparse factors in an order of our own; see `solver`."""

    plan: Plan
    is_direct = True
    product_limit = 25

    @cached_property
    def pattern(self) -> Pattern:
        return Pattern.of(self.plan, is_dissected=True)

    @cached_property
    def layout(self) -> Layout:
        return lay_out(self.plan, self.pattern.position)

    def matrices(self) -> tuple[Sparse, Sparse]:
        return Sparse(self.pattern), Sparse(self.pattern)
