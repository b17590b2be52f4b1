"""Is a stationary point a minimum? The pivots of its tangent, each beside the error that it may carry.

The pivot of an unknown is y^T K y with y a row of L^-1 (`factor.pivot_direction`). So errors E of the tangent make an
error y^T E y of the pivot, which can be far above the rounding of the pivot's own scale: a soft part behind stiff ones
gets their rounding. E has three sources: rounding of the tangent and its elimination, in proportion to the stiffness
that meets at an unknown; rounding of the displacements, which makes tensions where there are none; and the way still to
go, as the next Newton step tells, whose share of a spring's length is the change of a tangent on that way. A pivot
within its error counts as zero.
"""

from typing import Any

import numpy as np
from numba import njit

from springopt.effects.compile import compiled
from springopt.forward.factor import pivot_direction, pivot_of
from springopt.forward.state import CONTRAST, CURVATURE, FALLBACK, LONGEST, MARGIN
from springopt.forward.status import CONVERGED, UNDERDETERMINED, UNSTABLE

SADDLE, VAGUE = -1, -2  # beside the codes of a status
# Pivots above this share of their scale, times the contrast of the scales, are beyond any error: no need to look.
SAFE_PIVOT = 1e-6
# A negative pivot within this share of its stiffness may be gone when the residual is as small as it gets.
WEAK = 1e-6
ROUNDING = 4.0 * 2.0**-52
TINY = 1e-150


@njit(error_model="numpy")
def safe_pivot(lane: Any, length: float, v: int) -> float:
    """The share of its scale above which a pivot is beyond any error; `length` is that of a typical spring."""
    return SAFE_PIVOT * lane[CONTRAST, v] + 100.0 * lane[LONGEST, v] / length


@njit(error_model="numpy")
def certify(plan: Any, state: Any, v: int) -> int:
    """The status of lane v at its stationary point, accepted and factorized.

    SADDLE, with its steepest direction down in `unknowns` and its pivot as CURVATURE, and as FALLBACK the status if no
    way down is found; VAGUE, if a pivot can't be told from zero that could be, were the residual smaller: then MARGIN
    is to be 0.
    """
    lane = state.scalars
    safe = safe_pivot(lane, plan.step_limit, v)
    rounding = ROUNDING * (1.0 + _longest(state, v) / plan.step_limit)
    is_polished = lane[MARGIN, v] == 0.0
    zero_count, vague_count, lowest_at, lowest, is_surely_negative = 0, 0, -1, 0.0, True
    for at in range(len(state.inverse)):
        pivot, scale = pivot_of(plan, state.tangent, v, at), state.scale[at, v]
        if pivot > safe * scale:
            continue
        if pivot == 0.0:
            zero_count += 1
            continue
        pivot_direction(plan, state.tangent, v, at, state.unknowns)
        stiffness = _stiffness_along(state, v, at)
        if abs(pivot) <= rounding * stiffness:
            zero_count += 1
            continue
        is_sure = abs(pivot) > rounding * stiffness + _change_ahead(plan, state, v)
        if not is_sure:
            vague_count += 1
        if pivot < lowest * stiffness:
            lowest_at, lowest, is_surely_negative = at, pivot / stiffness, is_sure
    if lowest_at >= 0 and (is_polished or lowest < -WEAK):
        pivot_direction(plan, state.tangent, v, lowest_at, state.unknowns)
        lane[CURVATURE, v] = pivot_of(plan, state.tangent, v, lowest_at)
        lane[FALLBACK, v] = UNSTABLE if is_surely_negative else UNDERDETERMINED
        return SADDLE
    if not is_polished and (vague_count > 0 or lowest_at >= 0):
        return VAGUE
    return UNDERDETERMINED if zero_count + vague_count > 0 else CONVERGED


@compiled
def certify_direction(plan: Any, state: Any, v: int, curvature: float) -> int:
    """The same where a factor names one direction, in `unknowns`, along which y^T K y = `curvature` is negative."""
    lane = state.scalars
    rounding = ROUNDING * (1.0 + _longest(state, v) / plan.step_limit)
    stiffness = _stiffness_along(state, v, len(state.unknowns) - 1)
    is_polished = lane[MARGIN, v] == 0.0
    if curvature < -rounding * stiffness and (is_polished or curvature < -WEAK * stiffness):
        is_sure = curvature < -rounding * stiffness - _change_ahead(plan, state, v)
        lane[CURVATURE, v], lane[FALLBACK, v] = curvature, UNSTABLE if is_sure else UNDERDETERMINED
        return SADDLE
    return UNDERDETERMINED if is_polished else VAGUE


@njit(error_model="numpy")
def _longest(state: Any, v: int) -> float:
    longest = 0.0
    for row in range(len(state.accepted)):
        longest = max(longest, abs(state.accepted[row, v]))
    return longest


@njit(error_model="numpy")
def _stiffness_along(state: Any, v: int, pivot: int) -> float:
    """What the errors of the tangent are measured by along y, which is in `unknowns`."""
    stiffness = 0.0
    for at in range(pivot + 1):
        stiffness += state.unknowns[at, v] ** 2 * state.scale[at, v]
    return stiffness


@njit(error_model="numpy")
def _change_ahead(plan: Any, state: Any, v: int) -> float:
    """How much the next Newton step may change y^T K y: it turns springs, whose axes y stretches, and tightens them."""
    total = 0.0
    for spring in range(len(plan.ends)):
        square, step_square, y_square, step_along, y_along = 0.0, 0.0, 0.0, 0.0, 0.0
        for a in range(plan.dimension):
            vector = plan.rest_vectors[spring, a] + _stretch(plan, state.accepted, v, spring, a)
            step = _relative(plan, state.direction, v, spring, a)
            y = _relative(plan, state.unknowns, v, spring, a)
            square, step_square, y_square = square + vector * vector, step_square + step * step, y_square + y * y
            step_along, y_along = step_along + vector * step, y_along + vector * y
        if y_square > 0.0:
            length = max(np.sqrt(square), TINY)
            turned = 2.0 * np.sqrt(y_square * step_square) * abs(y_along)
            tightened = y_square * (abs(step_along) + step_square)
            total += state.stiffness[spring, v] * (turned + tightened) / (length * plan.step_limit)
    return 2.0 * total


@njit(error_model="numpy")
def _stretch(plan: Any, displacements: Any, v: int, spring: int, a: int) -> float:
    """One component of how far the ends of a spring moved apart; `displacements` (n d, 8)."""
    i, j = plan.ends[spring]
    return displacements[j * plan.dimension + a, v] - displacements[i * plan.dimension + a, v]


@njit(error_model="numpy")
def _relative(plan: Any, unknowns: Any, v: int, spring: int, a: int) -> float:
    """The same of unknowns (B d, 8); held nodes stay."""
    i, j = plan.block_of[plan.ends[spring, 0]], plan.block_of[plan.ends[spring, 1]]
    apart = unknowns[j * plan.dimension + a, v] if j >= 0 else 0.0
    return apart - (unknowns[i * plan.dimension + a, v] if i >= 0 else 0.0)
