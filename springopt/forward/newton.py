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
    ENERGY,
    FORCE_SCALE,
    IDLE,
    IS_ACCEPTED,
    LARGEST,
    LONGEST,
    MAGNITUDE,
    SLOPE,
    STEP,
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


@njit(error_model="numpy")
def _take_up(plan: Any, jobs: Any, state: Any, v: int, job: int) -> None:
    """Lane v starts job `job` from rest."""
    d = plan.dimension
    candidate, case = jobs.candidate[job], jobs.case[job]
    state.prestress[v] = 0.0
    for at in range(len(state.scale)):
        state.scale[at, v] = 0.0
        state.direction[at, v] = 0.0
    stiffest = 0.0
    for spring in range(len(plan.ends)):
        k = jobs.stiffness[candidate, spring]
        state.stiffness[spring, v] = k
        state.prestress[v] = max(state.prestress[v], k * abs(plan.prestrains[spring]))
        stiffest = max(stiffest, k)
        for end in range(2):
            block = plan.block_of[plan.ends[spring, end]]
            if block >= 0:
                for a in range(d):
                    state.scale[block * d + a, v] += k
    for at in range(len(state.scale)):
        if state.scale[at, v] == 0.0:  # a node without springs: any positive pivot keeps it at rest
            state.scale[at, v] = stiffest if stiffest > 0.0 else 1.0
    for row in range(len(state.forces)):
        state.forces[row, v] = jobs.forces[case, row]
        state.trial[row, v] = jobs.prescribed[case, row]
        state.accepted[row, v] = jobs.prescribed[case, row]
    state.job[v], state.phase[v], state.iterations[v] = job, STARTING, 0
    state.radius[v], state.step[v], state.size[v] = plan.step_limit, 0.0, np.inf
    state.facts[STEP, v] = 0.0


@njit(error_model="numpy")
def _put_down(state: Any, answers: Any, v: int, code: int) -> None:
    """Lane v is done: write its answer."""
    job = state.job[v]
    for row in range(len(state.accepted)):
        answers.displacements[job, row] = state.accepted[row, v]
    answers.codes[job] = code
    answers.residuals[job], answers.energies[job] = state.size[v], state.energy[v]
    answers.iterations[job] = state.iterations[v]
    state.job[v] = IDLE


@njit(error_model="numpy")
def evaluate(plan: Any, state: Any) -> None:
    """Energy, residual, force scale and tangent at the trial states of all lanes."""
    d, facts = plan.dimension, state.facts
    zero = splat(0.0)
    for row in range(len(state.tangent)):
        store(state.tangent, row, zero)
    for row in range(len(state.internal)):
        store(state.internal, row, zero)
    store(facts, ENERGY, zero)
    add_springs(plan, state.stiffness, state.trial, state.internal, state.tangent, facts, state.delta)
    for number in range(len(plan.kernels)):
        parameters = plan.kernel_parameters[plan.kernel_begins[number] :]
        body = (plan.nodes, parameters, plan.block_of, plan.first, plan.start)
        blocks = (state.trial, state.internal, state.tangent, facts)
        call_kernel(plan.kernels[number], d, len(plan.nodes), body + blocks)

    work, force_scale = zero, zero
    for row in range(len(state.forces)):
        force = load(state.forces, row)
        work = fma(force, load(state.trial, row), work)
        force_scale = maximum(force_scale, absolute(force))
    for row in plan.supported:
        force_scale = maximum(force_scale, absolute(load(state.internal, row) - load(state.forces, row)))
    for node in range(len(plan.block_of)):
        block = plan.block_of[node]
        if block >= 0:
            for a in range(d):
                row = node * d + a
                store(state.unknowns, block * d + a, load(state.forces, row) - load(state.internal, row))
    _pin(plan, state)
    largest = zero
    for at in range(len(state.unknowns)):
        largest = maximum(largest, absolute(load(state.unknowns, at)))
    strain = load(facts, ENERGY)
    store(facts, MAGNITUDE, strain + absolute(work))
    store(facts, ENERGY, strain - work)
    store(facts, FORCE_SCALE, force_scale)
    store(facts, LARGEST, largest)


@njit(error_model="numpy")
def _pin(plan: Any, state: Any) -> None:
    """Take the pinned unknowns out of residual and tangent."""
    d = plan.dimension
    for row in plan.pinned_rows:
        store(state.tangent, row, splat(0.0))
    for at in plan.pinned:
        block, a = at // d, at % d
        diagonal = (plan.start[block] + block - plan.first[block]) * d * d + a * d + a
        store(state.tangent, diagonal, load(state.scale, at))
        store(state.unknowns, at, splat(0.0))


@njit(error_model="numpy")
def _rounding(plan: Any, state: Any, v: int) -> float:
    """The largest residual that rounding of the accepted displacements alone can leave in lane v."""
    d = plan.dimension
    at_node = np.zeros(len(plan.nodes))
    for spring in range(len(plan.ends)):
        reach = abs(plan.prestrains[spring])
        for a in range(d):
            for end in range(2):
                reach += abs(state.accepted[plan.ends[spring, end] * d + a, v])
        for end in range(2):
            at_node[plan.ends[spring, end]] += state.stiffness[spring, v] * reach
    largest = 0.0
    for node in range(len(plan.nodes)):
        if plan.block_of[node] >= 0:
            largest = max(largest, at_node[node])
    return 4.0 * EPSILON * largest


@njit(error_model="numpy")
def _is_better(state: Any, v: int) -> bool:
    energy = state.facts[ENERGY, v]
    if state.phase[v] == ESCAPING:
        return energy < state.energy[v]
    predicted = state.step[v] * state.slope[v]
    if energy <= state.energy[v] + SUFFICIENT_DECREASE * predicted:
        return True
    return -predicted <= ENERGY_NOISE * state.facts[MAGNITUDE, v] and state.facts[LARGEST, v] <= 0.9 * state.size[v]


@njit(error_model="numpy")
def _shorten(state: Any, v: int) -> None:
    """A shorter step along the same direction: to the parabola's minimum, within a tenth and a half."""
    step, slope = state.step[v], state.slope[v]
    rise = state.facts[ENERGY, v] - state.energy[v]
    if state.phase[v] == ESCAPING:
        shorter = 0.25 * step
        if shorter < SHORTEST_ESCAPE:
            shorter, state.phase[v] = 0.0, STUCK
    else:
        parabola = -0.5 * slope * step * step / (rise - slope * step)
        shorter = min(max(parabola, 0.1 * step), 0.5 * step)
        is_noise = -slope * step <= 16.0 * EPSILON * state.facts[MAGNITUDE, v]
        if is_noise or shorter < SHORTEST_STEP:
            shorter, state.phase[v] = 0.0, STALLED
    state.step[v] = shorter
    state.facts[STEP, v] = shorter


@njit(error_model="numpy")
def _judge_all(plan: Any, state: Any, answers: Any, tolerance: float, iteration_limit: int) -> None:
    for v in range(LANE_COUNT):
        _judge(plan, state, answers, v, tolerance, iteration_limit)


@njit(error_model="numpy")
def _judge(plan: Any, state: Any, answers: Any, v: int, tolerance: float, iteration_limit: int) -> None:
    """Accept the trial state of lane v, shorten its step, or give up."""
    facts = state.facts
    facts[IS_ACCEPTED, v] = 0.0
    if state.job[v] == IDLE:
        return
    phase = state.phase[v]
    state.iterations[v] += 1
    if state.iterations[v] > iteration_limit:
        _put_down(state, answers, v, ITERATION_LIMIT)
        return
    if phase == STUCK:
        _put_down(state, answers, v, UNDERDETERMINED if state.curvature[v] > FLAT else UNSTABLE)
        return
    if phase != STARTING and phase != STALLED and not _is_better(state, v):
        _shorten(state, v)
        return
    before, now = state.size[v], facts[LARGEST, v]
    wanted = tolerance * max(facts[FORCE_SCALE, v], state.prestress[v])
    facts[IS_ACCEPTED, v] = 1.0
    state.size[v], state.energy[v] = now, facts[ENERGY, v]
    if phase == STALLED:
        if now > max(wanted, _rounding(plan, state, v)):
            _put_down(state, answers, v, ITERATION_LIMIT)
            return
        state.phase[v] = CERTIFYING
        return
    if phase == STEPPING and state.is_capped[v] and state.step[v] == 1.0:
        state.radius[v] *= 2.0
    is_there = now <= MARGIN * wanted or (now <= wanted and now > 0.1 * before)
    state.phase[v] = CERTIFYING if is_there else STEPPING


@njit(error_model="numpy")
def _set_course(plan: Any, state: Any, answers: Any, v: int) -> None:
    """After the factorization: lane v ends, escapes from a saddle, or takes its Newton step."""
    facts = state.facts
    if state.job[v] == IDLE or facts[IS_ACCEPTED, v] == 0.0:
        return
    largest, slope = facts[LONGEST, v], facts[SLOPE, v]
    limit = state.radius[v]
    if state.phase[v] == CERTIFYING:
        if state.inertia[0, v] == 0.0:
            _put_down(state, answers, v, UNDERDETERMINED if state.inertia[1, v] > 0.0 else CONVERGED)
            return
        negative_direction(plan, state.tangent, v, int(state.inertia[2, v]), state.direction)
        largest, slope = 0.0, 0.0
        for at in range(len(state.direction)):
            largest = max(largest, abs(state.direction[at, v]))
            slope -= state.direction[at, v] * state.residual[at, v]
        limit = -plan.step_limit if slope > 0.0 else plan.step_limit
        state.phase[v], state.curvature[v] = ESCAPING, state.inertia[3, v]
        state.is_capped[v] = True
    else:
        state.is_capped[v] = largest > limit
    if state.is_capped[v]:
        factor = limit / largest
        for at in range(len(state.direction)):
            state.direction[at, v] *= factor
        slope *= factor
    state.slope[v], state.step[v] = slope, 1.0
    facts[STEP, v] = 1.0


@njit(error_model="numpy")
def _keep_accepted(state: Any) -> None:
    """Where the trial state was accepted it becomes the state to step from."""
    accepted, half = load(state.facts, IS_ACCEPTED), splat(0.5)
    for row in range(len(state.trial)):
        store(state.accepted, row, where_greater(accepted, half, load(state.trial, row), load(state.accepted, row)))
    for at in range(len(state.unknowns)):
        old = load(state.residual, at)
        store(state.residual, at, where_greater(accepted, half, load(state.unknowns, at), old))


@njit(error_model="numpy")
def _find_directions(plan: Any, state: Any) -> None:
    """Newton directions where the trial state was accepted; their slope and length."""
    factorize(plan, state.tangent, state.inverse, state.scaled, state.scale, PIVOT_REPLACEMENT, state.inertia)
    substitute(plan, state.tangent, state.inverse, state.unknowns)
    accepted, half = load(state.facts, IS_ACCEPTED), splat(0.5)
    slope, longest = splat(0.0), splat(0.0)
    for at in range(len(state.direction)):
        p = where_greater(accepted, half, load(state.unknowns, at), load(state.direction, at))
        store(state.direction, at, p)
        longest = maximum(longest, absolute(p))
        slope = slope - p * load(state.residual, at)
    store(state.facts, SLOPE, slope)
    store(state.facts, LONGEST, longest)


@njit(error_model="numpy")
def _move(plan: Any, state: Any) -> None:
    d, step = plan.dimension, load(state.facts, STEP)
    for node in range(len(plan.block_of)):
        block = plan.block_of[node]
        if block >= 0:
            for a in range(d):
                row = node * d + a
                p = load(state.direction, block * d + a)
                store(state.trial, row, fma(step, p, load(state.accepted, row)))


@compiled
def find_equilibria(plan: Any, jobs: Any, state: Any, answers: Any, tolerance: float, iteration_limit: int) -> None:
    """Answer all jobs. `tolerance` is relative to the largest force: loads, reactions and prestress."""
    waiting = 0
    while True:
        is_busy = False
        for v in range(LANE_COUNT):
            if state.job[v] == IDLE and waiting < len(jobs.case):
                _take_up(plan, jobs, state, v, waiting)
                waiting += 1
            is_busy = is_busy or state.job[v] != IDLE
        if not is_busy:
            return
        evaluate(plan, state)
        _judge_all(plan, state, answers, tolerance, iteration_limit)
        _keep_accepted(state)
        _find_directions(plan, state)
        for v in range(LANE_COUNT):
            _set_course(plan, state, answers, v)
        _move(plan, state)
