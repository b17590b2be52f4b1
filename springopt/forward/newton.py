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
from springopt.forward.factor import factorize, negative_direction, substitute
from springopt.forward.state import (
    ACCEPTED,
    CURVATURE,
    ENERGY,
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
    PHASE,
    PRESTRESS,
    RESIDUAL,
    SLOPE,
    STEP,
    STEP_LIMIT,
    STRETCH,
)
from springopt.forward.status import CONVERGED, ITERATION_LIMIT, UNDERDETERMINED, UNSTABLE

PIVOT_REPLACEMENT = 1e-2  # results hardly depend on it between 1e-1 and 1e-3
SUFFICIENT_DECREASE = 1e-4  # Armijo's constant, Nocedal and Wright (2006), section 3.1
SHORTEST_STEP = 1e-10
SHORTEST_ESCAPE = 1e-5
# A negative pivot above this share of its scale, along which no energy falls, is a zero one that rounding moved.
FLAT = -1e-8
# A predicted decrease below this share of the energies involved drowns in their rounding: judge by the residual.
ENERGY_NOISE = 1e-10
# Newton's last step usually lands far below the tolerance; ask for that much, unless progress has ended.
MARGIN = 1e-2
EPSILON = 2.0**-52

STARTING, STEPPING, CERTIFYING, ESCAPING, STALLED, STUCK = range(6)
UNDECIDED = -1  # what the judges say while the search goes on; else the code of a status


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
        _find_directions(plan, state)
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
    """Lane v starts a job from rest."""
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
    for at in range(len(scale)):
        if scale[at, v] == 0.0:  # a node without springs: any positive pivot keeps it at rest
            scale[at, v] = stiffest if stiffest > 0.0 else 1.0
    for row in range(len(state.forces)):
        state.forces[row, v] = jobs.forces[case, row]
        state.trial[row, v] = jobs.prescribed[case, row]
        state.accepted[row, v] = jobs.prescribed[case, row]
    lane[JOB, v], lane[PHASE, v], lane[ITERATIONS, v] = job, STARTING, 0.0
    lane[STEP_LIMIT, v], lane[STEP, v], lane[PRESTRESS, v] = plan.step_limit, 0.0, prestress
    lane[LAST_RESIDUAL, v], lane[LAST_ENERGY, v] = np.inf, 0.0


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
        rounding = _rounding(plan, state, v) if lane[PHASE, v] == STALLED else 0.0
        code = _judge(lane, v, tolerance, iteration_limit, rounding)
        if code != UNDECIDED:
            _put_down(state, answers, v, code)


@njit(error_model="numpy")
def _judge(lane: Any, v: int, tolerance: float, iteration_limit: int, rounding: float) -> int:
    phase = lane[PHASE, v]
    lane[ITERATIONS, v] += 1.0
    if lane[ITERATIONS, v] > iteration_limit:
        return ITERATION_LIMIT
    if phase == STUCK:
        return UNDERDETERMINED if lane[CURVATURE, v] > FLAT else UNSTABLE
    if phase != STARTING and phase != STALLED and not _is_better(lane, v):
        _shorten(lane, v)
        return UNDECIDED
    before, now = lane[LAST_RESIDUAL, v], lane[RESIDUAL, v]
    wanted = tolerance * max(lane[FORCE_SCALE, v], lane[PRESTRESS, v])
    lane[ACCEPTED, v] = 1.0
    lane[LAST_RESIDUAL, v], lane[LAST_ENERGY, v] = now, lane[ENERGY, v]
    if phase == STALLED:
        lane[PHASE, v] = CERTIFYING
        return UNDECIDED if now <= max(wanted, rounding) else ITERATION_LIMIT
    if phase == STEPPING and lane[IS_CAPPED, v] == 1.0 and lane[STEP, v] == 1.0:
        lane[STEP_LIMIT, v] *= 2.0
    is_there = now <= MARGIN * wanted or (now <= wanted and now > 0.1 * before)
    lane[PHASE, v] = CERTIFYING if is_there else STEPPING
    return UNDECIDED


@njit(error_model="numpy")
def _is_better(lane: Any, v: int) -> bool:
    energy, last = lane[ENERGY, v], lane[LAST_ENERGY, v]
    if lane[PHASE, v] == ESCAPING:
        return energy < last
    predicted = lane[STEP, v] * lane[LAST_SLOPE, v]
    if energy <= last + SUFFICIENT_DECREASE * predicted:
        return True
    return -predicted <= ENERGY_NOISE * lane[MAGNITUDE, v] and lane[RESIDUAL, v] <= 0.9 * lane[LAST_RESIDUAL, v]


@njit(error_model="numpy")
def _shorten(lane: Any, v: int) -> None:
    """A shorter step along the same direction: to the parabola's minimum, within a tenth and a half."""
    step, slope = lane[STEP, v], lane[LAST_SLOPE, v]
    if lane[PHASE, v] == ESCAPING:
        shorter = 0.25 * step
        if shorter < SHORTEST_ESCAPE:
            shorter, lane[PHASE, v] = 0.0, STUCK
    else:
        rise = lane[ENERGY, v] - lane[LAST_ENERGY, v]
        parabola = -0.5 * slope * step * step / (rise - slope * step)
        shorter = min(max(parabola, 0.1 * step), 0.5 * step)
        is_noise = -slope * step <= 16.0 * EPSILON * lane[MAGNITUDE, v]
        if is_noise or shorter < SHORTEST_STEP:
            shorter, lane[PHASE, v] = 0.0, STALLED
    lane[STEP, v] = shorter


@njit(error_model="numpy")
def _rounding(plan: Any, state: Any, v: int) -> float:
    """The largest residual that rounding of the accepted displacements alone can leave in lane v."""
    d = plan.dimension
    at_node = np.zeros(len(plan.nodes))
    for spring in range(len(plan.ends)):
        reach = abs(plan.prestrains[spring])
        for end in range(2):
            for a in range(d):
                reach += abs(state.accepted[plan.ends[spring, end] * d + a, v])
        for end in range(2):
            at_node[plan.ends[spring, end]] += state.stiffness[spring, v] * reach
    largest = 0.0
    for node in range(len(plan.nodes)):
        if plan.block_of[node] >= 0:
            largest = max(largest, at_node[node])
    return 4.0 * EPSILON * largest


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
def _find_directions(plan: Any, state: Any) -> None:
    """Newton directions where the trial state was accepted, downwards from a saddle where one was found."""
    factorize(plan, state.tangent, state.inverse, state.scaled, state.scale, PIVOT_REPLACEMENT, state.inertia)
    substitute(plan, state.tangent, state.inverse, state.unknowns)
    take_directions(state)
    lane = state.scalars
    for v in range(LANE_COUNT):
        if lane[JOB, v] != IDLE and lane[ACCEPTED, v] == 1.0 and is_at_saddle(state, v):
            negative_direction(plan, state.tangent, v, int(state.inertia[2, v]), state.direction)
            measure_direction(state, v)


@compiled
def take_directions(state: Any) -> None:
    """The solutions in `unknowns` become the directions of accepted lanes; their slope and length."""
    direction, unknowns, residual = state.direction, state.unknowns, state.residual
    is_accepted, half = load(state.scalars, ACCEPTED), splat(0.5)
    slope, longest = splat(0.0), splat(0.0)
    for at in range(len(direction)):
        p = where_greater(is_accepted, half, load(unknowns, at), load(direction, at))
        store(direction, at, p)
        longest = maximum(longest, absolute(p))
        slope = slope - p * load(residual, at)
    store(state.scalars, SLOPE, slope)
    store(state.scalars, LONGEST, longest)


@njit(error_model="numpy")
def set_courses(plan: Any, state: Any, answers: Any) -> None:
    """After the factorization: lanes end, escape from a saddle, or take their Newton step."""
    lane = state.scalars
    for v in range(LANE_COUNT):
        lane[STRETCH, v] = 1.0
        if lane[JOB, v] == IDLE or lane[ACCEPTED, v] == 0.0:
            continue
        limit = lane[STEP_LIMIT, v]
        if lane[PHASE, v] == CERTIFYING:
            if state.inertia[0, v] == 0.0:
                _put_down(state, answers, v, UNDERDETERMINED if state.inertia[1, v] > 0.0 else CONVERGED)
                continue
            lane[PHASE, v], lane[CURVATURE, v] = ESCAPING, state.inertia[3, v]
            limit = plan.step_limit
        lane[IS_CAPPED, v] = 1.0 if lane[LONGEST, v] > limit or lane[PHASE, v] == ESCAPING else 0.0
        if lane[IS_CAPPED, v] == 1.0:
            lane[STRETCH, v] = limit / lane[LONGEST, v]
        if lane[PHASE, v] == ESCAPING and lane[SLOPE, v] > 0.0:
            lane[STRETCH, v] = -lane[STRETCH, v]
        lane[LAST_SLOPE, v], lane[STEP, v] = lane[SLOPE, v] * lane[STRETCH, v], 1.0


@njit(error_model="numpy")
def is_at_saddle(state: Any, v: int) -> bool:
    return state.scalars[PHASE, v] == CERTIFYING and state.inertia[0, v] > 0.0


@compiled
def measure_direction(state: Any, v: int) -> None:
    """Slope and length of the direction of lane v."""
    longest, slope = 0.0, 0.0
    for at in range(len(state.direction)):
        longest = max(longest, abs(state.direction[at, v]))
        slope -= state.direction[at, v] * state.residual[at, v]
    state.scalars[LONGEST, v], state.scalars[SLOPE, v] = longest, slope


@njit(error_model="numpy")
def move(plan: Any, state: Any) -> None:
    """The next trial states."""
    d, trial, accepted, direction = plan.dimension, state.trial, state.accepted, state.direction
    stretch, step = load(state.scalars, STRETCH), load(state.scalars, STEP)
    for node in range(len(plan.block_of)):
        block = plan.block_of[node]
        if block >= 0:
            for a in range(d):
                row, at = node * d + a, block * d + a
                p = stretch * load(direction, at)
                store(direction, at, p)
                store(trial, row, fma(step, p, load(accepted, row)))
