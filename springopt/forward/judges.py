"""Is a trial state better than the accepted one, is it at an equilibrium, and may a lane get any further?"""

from typing import Any

import numpy as np
from numba import njit

from springopt.effects.lanes import LANE_COUNT
from springopt.forward.queue import USUAL_REPLACEMENT, put_down
from springopt.forward.state import (
    ACCEPTED,
    CERTIFYING,
    CURVATURE,
    ENERGY,
    EPSILON,
    ESCAPING,
    FALLBACK,
    FORCE_SCALE,
    IDLE,
    IS_CAPPED,
    ITERATIONS,
    JOB,
    LAST_ENERGY,
    LAST_MAGNITUDE,
    LAST_RESIDUAL,
    LAST_SLOPE,
    MAGNITUDE,
    MARGIN,
    PHASE,
    PRESTRESS,
    RELAXING,
    REPLACEMENT,
    RESIDUAL,
    SLOPE,
    STALLED,
    STARTING,
    STEP,
    STEP_LIMIT,
    STEPPING,
    STUCK,
    UNRELAXED,
)
from springopt.forward.status import ITERATION_LIMIT

SUFFICIENT_DECREASE = 1e-4  # Armijo's constant, Nocedal and Wright (2006), section 3.1
SHORTEST_STEP = 1e-10
SHORTEST_ESCAPE = 1e-5
# A predicted decrease below this share of the energies involved drowns in their rounding.
ENERGY_NOISE = 1e-10
SLOWLY, HARDLY = 0.1, 0.5  # what remains of a residual in a step; a flat minimum's falls to 0.3


@njit(error_model="numpy")
def judge_lanes(plan: Any, state: Any, answers: Any, tolerance: float, iteration_limit: int) -> None:
    """Accept the trial states, shorten the steps, or give up."""
    lane = state.scalars
    for v in range(LANE_COUNT):
        lane[ACCEPTED, v] = 0.0
        if lane[JOB, v] == IDLE:
            continue
        lane[ITERATIONS, v] += 1.0
        if lane[ITERATIONS, v] > iteration_limit:
            put_down(state, answers, v, ITERATION_LIMIT)
        elif lane[PHASE, v] == STUCK:
            put_down(state, answers, v, int(lane[FALLBACK, v]))
        elif (
            lane[PHASE, v] == STARTING
            or lane[PHASE, v] == STALLED
            or _is_better(lane, state.unknowns, state.direction, v)
        ):
            _accept(lane, v, tolerance)
        elif lane[PHASE, v] == STEPPING:
            lane[PHASE, v], lane[UNRELAXED, v] = RELAXING, lane[ENERGY, v]
        else:
            _shorten(lane, v)


@njit(error_model="numpy")
def _accept(lane: Any, v: int, tolerance: float) -> None:
    """The trial state of lane v is the one to step from, or the answer if its residual is small."""
    before, now = lane[LAST_RESIDUAL, v], lane[RESIDUAL, v]
    lane[ACCEPTED, v] = 1.0
    lane[LAST_RESIDUAL, v], lane[LAST_ENERGY, v], lane[LAST_MAGNITUDE, v] = now, lane[ENERGY, v], lane[MAGNITUDE, v]
    if lane[PHASE, v] == STALLED:
        return
    if lane[PHASE, v] != STARTING and lane[PHASE, v] != ESCAPING and lane[IS_CAPPED, v] == 1.0 and lane[STEP, v] == 1.0:
        lane[STEP_LIMIT, v] *= 2.0
    wanted = tolerance * _force_scale(lane, v)
    falls = SLOWLY if lane[MARGIN, v] > 0.0 else HARDLY
    is_there = now <= lane[MARGIN, v] * wanted or (now <= wanted and now > falls * before)
    lane[PHASE, v] = CERTIFYING if is_there else STEPPING


@njit(error_model="numpy")
def _force_scale(lane: Any, v: int) -> float:
    """The largest of loads, reactions and prestress."""
    return max(lane[FORCE_SCALE, v], lane[PRESTRESS, v])


@njit(error_model="numpy")
def _is_better(lane: Any, unknowns: Any, direction: Any, v: int) -> bool:
    energy, last = lane[ENERGY, v], lane[LAST_ENERGY, v]
    noise = 16.0 * EPSILON * lane[MAGNITUDE, v]
    if lane[PHASE, v] == ESCAPING:
        return energy < last - noise or (energy <= last + noise and _still_falls(lane, unknowns, direction, v))
    predicted = lane[STEP, v] * lane[LAST_SLOPE, v]
    if energy <= last + SUFFICIENT_DECREASE * predicted:
        return True
    is_noise = -predicted <= ENERGY_NOISE * lane[MAGNITUDE, v]
    return is_noise and (lane[RESIDUAL, v] <= 0.9 * lane[LAST_RESIDUAL, v] or energy <= last + noise)


@njit(error_model="numpy")
def _still_falls(lane: Any, unknowns: Any, direction: Any, v: int) -> bool:
    """Whether the energy of an escape falls at the trial state; where it falls too little to be seen, the forces tell.

    At least a tenth as steep as the curvature at the saddle foretells.
    """
    slope = 0.0
    for at in range(len(direction)):
        slope -= unknowns[at, v] * direction[at, v]
    return slope <= 0.1 * lane[CURVATURE, v] * lane[STEP, v]


@njit(error_model="numpy")
def _shorten(lane: Any, v: int) -> None:
    """A shorter step along the same direction: to the parabola's minimum, within a tenth and a half."""
    step, slope = lane[STEP, v], lane[LAST_SLOPE, v]
    if lane[PHASE, v] == ESCAPING:
        shorter = 0.25 * step
        if shorter < SHORTEST_ESCAPE:
            shorter, lane[PHASE, v] = 0.0, STUCK
    else:
        lane[PHASE, v] = STEPPING
        rise = lane[UNRELAXED, v] - lane[LAST_ENERGY, v]
        parabola = -0.5 * slope * step * step / (rise - slope * step)
        shorter = min(max(parabola, 0.1 * step), 0.5 * step)
        # Not the refused state's magnitude, which may be beyond all bounds where an effect stiffens.
        is_noise = -slope * step <= 16.0 * EPSILON * lane[LAST_MAGNITUDE, v]
        if is_noise or not shorter >= SHORTEST_STEP:
            # Once more from here with another direction, if there is one.
            is_last = lane[REPLACEMENT, v] == USUAL_REPLACEMENT
            shorter, lane[PHASE, v] = 0.0, STALLED if is_last else STARTING
        lane[REPLACEMENT, v] = min(10.0 * lane[REPLACEMENT, v], USUAL_REPLACEMENT)
    lane[STEP, v] = shorter


@njit(error_model="numpy")
def settle(plan: Any, state: Any, tolerance: float) -> None:
    """Lanes that get no further are to be certified, if they are at an equilibrium as far as digits go."""
    lane = state.scalars
    for v in range(LANE_COUNT):
        if lane[JOB, v] == IDLE or lane[ACCEPTED, v] == 0.0:
            continue
        is_at_its_end = lane[PHASE, v] == STALLED or _makes_no_progress(lane, v)
        if is_at_its_end and _is_balanced(plan, state, v, tolerance):
            lane[PHASE, v] = CERTIFYING


@njit(error_model="numpy")
def _makes_no_progress(lane: Any, v: int) -> bool:
    """Whether the last step, too small for the energy to judge, made the next one hardly smaller."""
    foretold = -lane[SLOPE, v]
    is_noise = foretold <= ENERGY_NOISE * lane[MAGNITUDE, v]
    return lane[PHASE, v] == STEPPING and is_noise and foretold > -0.5 * lane[LAST_SLOPE, v]


@njit(error_model="numpy")
def _is_balanced(plan: Any, state: Any, v: int, tolerance: float) -> bool:
    """Whether lane v, which gets no further, is at an equilibrium as far as its displacements have digits.

    Rounding of displacements leaves forces out of balance, in proportion to the stiffness, that no step can remove.
    They tell nothing of softer parts; the energy that the next step would still gain does, whatever the stiffness: it
    is the error's own energy, and must vanish beside that of the equilibrium.
    """
    lane = state.scalars
    if lane[LAST_RESIDUAL, v] <= tolerance * _force_scale(lane, v):
        return True
    rounding, longest = _rounding(plan, state, v)
    gain = -lane[SLOPE, v]
    is_small = gain <= tolerance * tolerance * lane[MAGNITUDE, v] + 16.0 * EPSILON * rounding * longest
    return is_small and lane[LAST_RESIDUAL, v] <= rounding


@njit(error_model="numpy")
def _rounding(plan: Any, state: Any, v: int) -> tuple[float, float]:
    """(the largest residual that rounding of the accepted displacements alone can leave in lane v, the longest)."""
    d = plan.dimension
    at_node = np.zeros(len(plan.nodes))
    longest = 0.0
    for spring in range(len(plan.ends)):
        reach = abs(plan.prestrains[spring])
        for end in range(2):
            for a in range(d):
                moved = abs(state.accepted[plan.ends[spring, end] * d + a, v])
                reach += moved
                longest = max(longest, moved)
        for end in range(2):
            at_node[plan.ends[spring, end]] += state.stiffness[spring, v] * reach
    largest = 0.0
    for node in range(len(plan.nodes)):
        if plan.block_of[node] >= 0:
            largest = max(largest, at_node[node])
    if len(plan.potentials.table):
        for at in range(len(state.scale)):
            largest = max(largest, 2.0 * d * longest * state.scale[at, v])
    return 4.0 * EPSILON * largest, longest
