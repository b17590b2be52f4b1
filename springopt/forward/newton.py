"""Static equilibria of many candidates and load cases, eight at a time: exact Newton, lane by lane.

Each lane carries one equilibrium: evaluate energy, residual and tangent at a trial state; accept it or shorten the
step; factorize and step on. A lane that is done takes up the next job at once, so a stubborn equilibrium holds up no
other. Steps are limited in length (the limit doubles while full steps succeed) and accepted by the energy, so the
search descends to a minimum; it ends only where the tangent's inertia certifies one. At a stationary point with a
negative pivot it goes on along the direction of negative curvature that the factor yields.
"""

from typing import Any

import numpy as np
from numba import njit

from springopt.effects.compile import compiled
from springopt.effects.effect import call_kernel
from springopt.effects.lanes import LANE_COUNT, absolute, fma, load, maximum, splat, store, where_greater
from springopt.effects.springs import add_springs
from springopt.forward.certificate import SADDLE, VAGUE, certify, safe_pivot
from springopt.forward.factor import factorize, substitute
from springopt.forward.state import (
    ACCEPTED,
    CONTRAST,
    CURVATURE,
    ENERGY,
    FALLBACK,
    FORCE_SCALE,
    IDLE,
    IS_CAPPED,
    ITERATIONS,
    JOB,
    LAST_ENERGY,
    LAST_RESIDUAL,
    LAST_SLOPE,
    LONGEST,
    MAGNITUDE,
    MARGIN,
    PHASE,
    PRESTRESS,
    RELAXATION,
    REPLACEMENT,
    RESIDUAL,
    SLOPE,
    STEP,
    STEP_LIMIT,
    STRETCH,
    UNRELAXED,
    VERDICT,
)
from springopt.forward.status import CONVERGED, ITERATION_LIMIT

# What a pivot that is not positive is replaced by, in relation to its scale. Ten times less while steps are short:
# a weak load is to move what hardly anything resists.
USUAL_REPLACEMENT = 1e-2
LEAST_REPLACEMENT = 1e-13
SHORT = 0.1  # of the step limit
SUFFICIENT_DECREASE = 1e-4  # Armijo's constant, Nocedal and Wright (2006), section 3.1
SHORTEST_STEP = 1e-10
SHORTEST_ESCAPE = 1e-5
# A predicted decrease below this share of the energies involved drowns in their rounding.
ENERGY_NOISE = 1e-10
# Newton's last step usually lands far below the tolerance; ask for that much, unless progress has ended.
USUAL_MARGIN = 1e-2
SLOWLY, HARDLY = 0.1, 0.5  # what remains of a residual in a step; a flat minimum's falls to 0.3
EPSILON = 2.0**-52

STARTING, STEPPING, RELAXING, CERTIFYING, ESCAPING, STALLED, STUCK = range(7)


@compiled
def find_equilibria(plan: Any, jobs: Any, state: Any, answers: Any, tolerance: float, iteration_limit: int) -> None:
    """Answer all jobs. `tolerance` is relative to the largest force: loads, reactions and prestress."""
    waiting = 0
    while True:
        waiting = refill(plan, jobs, state, waiting)
        if state.scalars[JOB].max() == IDLE:
            return
        evaluate(plan, state)
        judge_lanes(plan, state, answers, tolerance, iteration_limit)
        keep_accepted(state)
        _find_directions(plan, state, tolerance)
        set_courses(plan, state, answers)
        move(plan, state)


@njit(error_model="numpy")
def refill(plan: Any, jobs: Any, state: Any, waiting: int) -> int:
    """Idle lanes take up the waiting jobs; returns the first that still waits."""
    for v in range(LANE_COUNT):
        if state.scalars[JOB, v] == IDLE and waiting < len(jobs.case):
            _take_up(plan, jobs, state, v, waiting)
            waiting += 1
    return waiting


@njit(error_model="numpy")
def _take_up(plan: Any, jobs: Any, state: Any, v: int, job: int) -> None:
    """Lane v starts a job."""
    d, scale, lane = plan.dimension, state.scale, state.scalars
    candidate, case = jobs.candidate[job], jobs.case[job]
    for at in range(len(scale)):
        scale[at, v] = 0.0
        state.direction[at, v] = 0.0
    prestress, stiffest = 0.0, 0.0
    for spring in range(len(plan.ends)):
        k = jobs.stiffness[candidate, spring]
        state.stiffness[spring, v] = k
        prestress = max(prestress, k * abs(plan.prestrains[spring]))
        stiffest = max(stiffest, k)
        for end in range(2):
            block = plan.block_of[plan.ends[spring, end]]
            if block >= 0:
                for a in range(d):
                    scale[block * d + a, v] += k
    softest, hardest = np.inf, 0.0
    for at in range(len(scale)):
        if scale[at, v] == 0.0:  # a node without springs: any positive pivot keeps it at rest
            scale[at, v] = stiffest if stiffest > 0.0 else 1.0
        softest, hardest = min(softest, scale[at, v]), max(hardest, scale[at, v])
    for row in range(len(state.forces)):
        state.forces[row, v] = jobs.forces[case, row]
        state.trial[row, v] = jobs.start[job, row]
        state.accepted[row, v] = jobs.start[job, row]
    lane[JOB, v], lane[PHASE, v], lane[ITERATIONS, v] = job, STARTING, 0.0
    lane[STEP_LIMIT, v], lane[STEP, v], lane[PRESTRESS, v] = plan.step_limit, 0.0, prestress
    lane[LAST_RESIDUAL, v], lane[LAST_ENERGY, v], lane[LAST_SLOPE, v] = np.inf, 0.0, -np.inf
    lane[CONTRAST, v], lane[MARGIN, v], lane[REPLACEMENT, v] = hardest / softest, USUAL_MARGIN, USUAL_REPLACEMENT


@njit(error_model="numpy")
def _put_down(state: Any, answers: Any, v: int, code: int) -> None:
    """Lane v is done: write its answer."""
    lane = state.scalars
    job = int(lane[JOB, v])
    for row in range(len(state.accepted)):
        answers.displacements[job, row] = state.accepted[row, v]
    answers.codes[job] = code
    answers.residuals[job], answers.energies[job] = lane[LAST_RESIDUAL, v], lane[LAST_ENERGY, v]
    answers.iterations[job] = int(lane[ITERATIONS, v])
    lane[JOB, v] = IDLE


@njit(error_model="numpy")
def evaluate(plan: Any, state: Any) -> None:
    """Energy, residual, force scale and tangent at the trial states of all lanes."""
    d, lane, internal, zero = plan.dimension, state.scalars, state.internal, splat(0.0)
    for row in range(len(state.tangent)):
        store(state.tangent, row, zero)
    for row in range(len(internal)):
        store(internal, row, zero)
    store(lane, ENERGY, zero)
    add_springs(plan, state.stiffness, state.trial, internal, state.tangent, lane, state.delta)
    for number in range(len(plan.kernels)):
        parameters = plan.kernel_parameters[plan.kernel_begins[number] :]
        body = (plan.nodes, parameters, plan.block_of, plan.first, plan.start)
        blocks = (state.trial, internal, state.tangent, lane)
        call_kernel(plan.kernels[number], d, len(plan.nodes), body + blocks)

    sum_up(plan, state)
    _pin(plan, state)


@njit(error_model="numpy")
def sum_up(plan: Any, state: Any) -> None:
    """Energy less work, out-of-balance forces and force scale, from strain energy and internal forces."""
    d, lane, unknowns, internal, forces = plan.dimension, state.scalars, state.unknowns, state.internal, state.forces
    work, force_scale, largest = splat(0.0), splat(0.0), splat(0.0)
    for row in range(len(forces)):
        force = load(forces, row)
        work = fma(force, load(state.trial, row), work)
        force_scale = maximum(force_scale, absolute(force))
    for row in plan.supported:
        force_scale = maximum(force_scale, absolute(load(internal, row) - load(forces, row)))
    for node in range(len(plan.block_of)):
        block = plan.block_of[node]
        if block >= 0:
            for a in range(d):
                row = node * d + a
                store(unknowns, block * d + a, load(forces, row) - load(internal, row))
    for at in plan.pinned:
        store(unknowns, at, splat(0.0))
    for at in range(len(unknowns)):
        largest = maximum(largest, absolute(load(unknowns, at)))
    strain = load(lane, ENERGY)
    store(lane, MAGNITUDE, strain + absolute(work))
    store(lane, ENERGY, strain - work)
    store(lane, FORCE_SCALE, force_scale)
    store(lane, RESIDUAL, largest)


@njit(error_model="numpy")
def _pin(plan: Any, state: Any) -> None:
    """Take the pinned unknowns out of the tangent."""
    d = plan.dimension
    for row in plan.pinned_rows:
        store(state.tangent, row, splat(0.0))
    for at in plan.pinned:
        block, a = at // d, at % d
        diagonal = (plan.start[block] + block - plan.first[block]) * d * d + a * d + a
        store(state.tangent, diagonal, load(state.scale, at))


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
            _put_down(state, answers, v, ITERATION_LIMIT)
        elif lane[PHASE, v] == STUCK:
            _put_down(state, answers, v, int(lane[FALLBACK, v]))
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
    lane[LAST_RESIDUAL, v], lane[LAST_ENERGY, v] = now, lane[ENERGY, v]
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
        is_noise = -slope * step <= 16.0 * EPSILON * lane[MAGNITUDE, v]
        if is_noise or not shorter >= SHORTEST_STEP:
            # Once more from here with another direction, if there is one.
            is_last = lane[REPLACEMENT, v] == USUAL_REPLACEMENT
            shorter, lane[PHASE, v] = 0.0, STALLED if is_last else STARTING
        lane[REPLACEMENT, v] = min(10.0 * lane[REPLACEMENT, v], USUAL_REPLACEMENT)
    lane[STEP, v] = shorter


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
def _find_directions(plan: Any, state: Any, tolerance: float) -> None:
    """Newton directions, verdicts on stationary points, and the way down from saddles."""
    lane = state.scalars
    replacement = load(lane, REPLACEMENT)
    factorize(plan, state.tangent, state.inverse, state.scaled, state.scale, replacement, state.inertia)
    substitute(plan, state.tangent, state.inverse, state.unknowns)
    take_directions(state)
    settle(plan, state, tolerance)
    for v in range(LANE_COUNT):
        if lane[PHASE, v] == CERTIFYING and lane[ACCEPTED, v] == 1.0:
            lane[VERDICT, v] = CONVERGED
            if not state.inertia[2, v] > safe_pivot(lane, plan.step_limit, v):
                lane[VERDICT, v] = certify(plan, state, v)
            if lane[VERDICT, v] == SADDLE:
                for at in range(len(state.direction)):
                    state.direction[at, v] = state.unknowns[at, v]
                measure_direction(state, v)


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
                _put_down(state, answers, v, ITERATION_LIMIT)
            elif lane[PHASE, v] == CERTIFYING and lane[VERDICT, v] >= 0.0:
                _put_down(state, answers, v, int(lane[VERDICT, v]))
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
    return 4.0 * EPSILON * largest, longest


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
