"""Where a lane goes from its accepted state: along its Newton direction, or down from a saddle.

Steps are limited in length; the limit doubles while full steps succeed.
"""

from typing import Any

from numba import njit

from springopt.effects.compile import compiled
from springopt.effects.lanes import LANE_COUNT, absolute, fma, load, maximum, splat, store, where_greater
from springopt.forward.certificate import VAGUE
from springopt.forward.queue import put_down
from springopt.forward.state import (
    ACCEPTED,
    CERTIFYING,
    CURVATURE,
    ESCAPING,
    IDLE,
    IS_CAPPED,
    JOB,
    LAST_SLOPE,
    LONGEST,
    MARGIN,
    PHASE,
    RELAXATION,
    RELAXING,
    REPLACEMENT,
    SLOPE,
    STALLED,
    STEP,
    STEP_LIMIT,
    STEPPING,
    STRETCH,
    VERDICT,
)
from springopt.forward.status import ITERATION_LIMIT

# A pivot that is not positive is replaced by ten times less while steps are short: a weak load is to move what hardly
# anything resists.
LEAST_REPLACEMENT = 1e-13
SHORT = 0.1  # of the step limit


@njit(error_model="numpy")
def keep_accepted(state: Any) -> None:
    """Where the trial state was accepted it becomes the state to step from."""
    trial, accepted, unknowns, residual = state.trial, state.accepted, state.unknowns, state.residual
    is_accepted, half = load(state.scalars, ACCEPTED), splat(0.5)
    for row in range(len(trial)):
        store(accepted, row, where_greater(is_accepted, half, load(trial, row), load(accepted, row)))
    for at in range(len(unknowns)):
        store(residual, at, where_greater(is_accepted, half, load(unknowns, at), load(residual, at)))


@njit(error_model="numpy")
def take_directions(state: Any) -> None:
    """The solutions in `unknowns` become the directions of accepted lanes; their slope and length."""
    direction, unknowns, residual, lane = state.direction, state.unknowns, state.residual, state.scalars
    is_accepted, half = load(lane, ACCEPTED), splat(0.5)
    slope, longest = splat(0.0), splat(0.0)
    for at in range(len(direction)):
        newest = load(unknowns, at)
        p = where_greater(is_accepted, half, newest, load(direction, at))
        store(direction, at, p)
        longest = maximum(longest, absolute(newest))
        slope = slope - p * load(residual, at)
    store(lane, SLOPE, slope)
    store(lane, LONGEST, longest)


@compiled
def measure_direction(state: Any, v: int) -> None:
    """Slope and length of the direction of lane v."""
    longest, slope = 0.0, 0.0
    for at in range(len(state.direction)):
        longest = max(longest, abs(state.direction[at, v]))
        slope -= state.direction[at, v] * state.residual[at, v]
    state.scalars[LONGEST, v], state.scalars[SLOPE, v] = longest, slope


@njit(error_model="numpy")
def set_courses(plan: Any, state: Any, answers: Any) -> None:
    """After the factorization: lanes end, escape from a saddle, or take their Newton step."""
    lane = state.scalars
    for v in range(LANE_COUNT):
        lane[STRETCH, v], lane[RELAXATION, v] = 1.0, 0.0
        if lane[JOB, v] == IDLE:
            continue
        if lane[PHASE, v] == RELAXING:
            lane[RELAXATION, v] = min(1.0, plan.step_limit / max(lane[LONGEST, v], plan.step_limit))
        elif lane[ACCEPTED, v] == 1.0:
            if lane[PHASE, v] == STALLED:
                put_down(state, answers, v, ITERATION_LIMIT)
            elif lane[PHASE, v] == CERTIFYING and lane[VERDICT, v] >= 0.0:
                put_down(state, answers, v, int(lane[VERDICT, v]))
            else:
                has_bad_pivots = state.inertia[0, v] + state.inertia[1, v] > 0.0
                _set_course(lane, plan.step_limit, has_bad_pivots, v)


# Helpers that every lane calls take single arrays: numba counts the references of all that it hands over.
@njit(error_model="numpy")
def _set_course(lane: Any, first_limit: float, has_bad_pivots: bool, v: int) -> None:
    """Lane v goes on from the state that was just accepted."""
    limit = lane[STEP_LIMIT, v]
    if lane[PHASE, v] == CERTIFYING and lane[VERDICT, v] == VAGUE:
        lane[MARGIN, v], lane[PHASE, v] = 0.0, STEPPING
    elif lane[PHASE, v] == CERTIFYING:
        lane[PHASE, v], limit = ESCAPING, first_limit
    lane[IS_CAPPED, v] = 1.0 if lane[LONGEST, v] > limit or lane[PHASE, v] == ESCAPING else 0.0
    if lane[IS_CAPPED, v] == 1.0:
        lane[STRETCH, v] = limit / lane[LONGEST, v]
    if lane[PHASE, v] == ESCAPING:
        lane[CURVATURE, v] *= lane[STRETCH, v] ** 2
        if lane[SLOPE, v] > 0.0:
            lane[STRETCH, v] = -lane[STRETCH, v]
    elif lane[LONGEST, v] < SHORT * limit and has_bad_pivots:
        lane[REPLACEMENT, v] = max(0.1 * lane[REPLACEMENT, v], LEAST_REPLACEMENT)
    lane[LAST_SLOPE, v], lane[STEP, v] = lane[SLOPE, v] * lane[STRETCH, v], 1.0


@njit(error_model="numpy")
def move(plan: Any, state: Any) -> None:
    """The next trial states."""
    d, trial, accepted, direction = plan.dimension, state.trial, state.accepted, state.direction
    unknowns, stretch, step = state.unknowns, load(state.scalars, STRETCH), load(state.scalars, STEP)
    relaxation, zero = load(state.scalars, RELAXATION), splat(0.0)
    for node in range(len(plan.block_of)):
        block = plan.block_of[node]
        if block >= 0:
            for a in range(d):
                row, at = node * d + a, block * d + a
                p = stretch * load(direction, at)
                store(direction, at, p)
                along = fma(step, p, load(accepted, row))
                relaxed = fma(relaxation, load(unknowns, at), load(trial, row))
                store(trial, row, where_greater(relaxation, zero, relaxed, along))
