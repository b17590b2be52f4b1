"""The minimum of a convex quadratic in a box, by block principal pivoting."""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from springopt.checks import Booleans, Floats, Integers

#: Exchanges of all offenders at once that may go by without fewer of them, before one is exchanged at a time.
PATIENCE = 3
#: A bound so near to zero is where the search stands.
AT_BOUND = 1e-12
#: A slope below this share of the largest one at the box's border is rounding.
ROUNDING = 1e-12


def minimize_in_box(A: Floats, g: Floats, lower: Floats, upper: Floats) -> Floats:
    """The d (n,) in [lower, upper] with the least g.d + d.A.d/2, for A (n, n) positive definite.

    A guess says which unknowns lie on which bound; the others are solved for, and all offenders change sides: those
    that left the box, and those on a bound whose slope leads inside. Portugal, Júdice and Vicente (1994), with Murty's
    rule of the last index where that does not settle, here for two bounds.
    """
    # -1: on the lower bound, 1: on the upper one, 0: between. Whoever stands on a bound and is pushed there may stay.
    side = np.where((lower >= -AT_BOUND) & (g > 0), -1, np.where((upper <= AT_BOUND) & (g < 0), 1, 0))
    fewest, patience = len(g) + 1, PATIENCE
    slack = ROUNDING * float(np.abs(g).max(initial=0.0))
    for _ in range(10 * len(g) + 100):  # rounding may make ties go round for ever
        d = _solve(A, g, lower, upper, side)
        wanted = _better_sides(side, d, g + A @ d, lower, upper, slack)
        offenders = wanted != side
        count = int(offenders.sum())
        if not count:
            break
        if count < fewest:
            fewest, patience = count, PATIENCE
        elif patience:
            patience -= 1
        else:
            offenders = _only_last(offenders)
        side = np.where(offenders, wanted, side)
    return np.clip(d, lower, upper)


def _solve(A: Floats, g: Floats, lower: Floats, upper: Floats, side: Integers) -> Floats:
    """The minimum over the free unknowns, the others on their bounds."""
    d = np.where(side < 0, lower, np.where(side > 0, upper, 0.0))
    free = side == 0
    if free.all():
        return -cho_solve(cho_factor(A), g)
    if free.any():
        slope = g[free] + A[np.ix_(free, ~free)] @ d[~free]
        d[free] = -cho_solve(cho_factor(A[np.ix_(free, free)]), slope)
    return d


def _better_sides(side: Integers, d: Floats, slope: Floats, lower: Floats, upper: Floats, slack: float) -> Integers:
    held = ((side < 0) & (slope >= -slack)) | ((side > 0) & (slope <= slack))
    outside = np.where(d < lower, -1, np.where(d > upper, 1, 0))
    return np.where(side == 0, outside, np.where(held, side, 0))


def _only_last(offenders: Booleans) -> Booleans:
    return np.arange(len(offenders)) == np.flatnonzero(offenders)[-1]
