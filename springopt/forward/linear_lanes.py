"""Small displacements of many small systems: eight candidates at a time, one factor each for all load cases.

What `linear` does, for springs alone and candidates whose tangent at rest is positive definite; the others, whose free
modes must be told, and effects are left to it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from springopt.effects.compile import announce_compilation, compiled
from springopt.effects.lanes import LANE_COUNT, fma, load, splat, store
from springopt.effects.springs import tension_per_length
from springopt.forward.counter import draw
from springopt.forward.evaluation import evaluate
from springopt.forward.factor import factorize, substitute
from springopt.forward.lane_factors import RIGID
from springopt.forward.linear import EqualFactors, LinearEngine
from springopt.forward.plan import Plan
from springopt.forward.state import ENERGY, EPSILON, Answers, Jobs, make_lanes
from springopt.forward.status import CONVERGED, ITERATION_LIMIT

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LinearLanesEngine:
    """Solutions for small displacements of small systems."""

    plan: Plan
    rest: LinearEngine  #: what the others are left to

    def find(self, jobs: Jobs, answers: Answers, tolerance: float) -> None:
        """See `Engine`."""
        if not len(jobs.candidate):  # loads push parts of every candidate away
            return
        announce_compilation(solve_eights)
        edges = np.flatnonzero(np.diff(jobs.candidate, prepend=-1, append=-1))
        is_left = np.zeros(len(edges) - 1, dtype=np.bool_)
        solve_eights(self.plan, jobs, edges, is_left, make_lanes(self.plan), answers, tolerance)
        bounds = np.flatnonzero(np.diff(is_left, prepend=False, append=False)).reshape(-1, 2)
        for first, end in bounds.tolist():
            few = slice(int(edges[first]), int(edges[end]))
            self.rest.find(jobs.part(few), answers.part(few), tolerance)

    def factorize(self, candidate: Floats, displacements: Floats) -> EqualFactors:
        """See `Engine`."""
        return self.rest.factorize(candidate, displacements)


@compiled
def solve_eights(plan: Any, jobs: Any, edges: Any, is_left: Any, state: Any, answers: Any, tolerance: float) -> None:
    """Answer all jobs, which are sorted by candidate; `edges` says where those of each begin, `is_left` whose are left.

    Threads that are given the same jobs share the candidates.
    """
    pushed = np.zeros((plan.nodes.size, LANE_COUNT))
    count = len(edges) - 1
    while True:
        first = draw(jobs.taken, (count + LANE_COUNT - 1) // LANE_COUNT) * LANE_COUNT
        if first < 0:
            return
        lanes = min(LANE_COUNT, count - first)
        most = _take_up(plan, jobs, edges, first, lanes, state)
        evaluate(plan, state)
        factorize(plan, state.tangent, state.inverse, state.scaled, state.scale, splat(RIGID), state.inertia)
        for v in range(lanes):
            is_left[first + v] = state.inertia[0, v] + state.inertia[1, v] > 0.0
        for number in range(most):
            _answer(plan, jobs, edges, first, lanes, number, is_left, state, pushed, answers, tolerance)


@njit(error_model="numpy")
def _take_up(plan: Any, jobs: Any, edges: Any, first: int, lanes: int, state: Any) -> int:
    """Eight candidates at rest, spare lanes repeat the last one; the largest number of load cases of one."""
    d, most = plan.dimension, 0
    state.trial[:] = 0.0
    state.forces[:] = 0.0
    state.scale[:] = 0.0
    for v in range(LANE_COUNT):
        own = first + min(v, lanes - 1)
        candidate = jobs.candidate[edges[own]]
        most = max(most, edges[own + 1] - edges[own])
        for spring in range(len(plan.ends)):
            k = jobs.candidates[candidate, spring]
            state.stiffness[spring, v] = k
            for end in range(2):
                block = plan.block_of[plan.ends[spring, end]]
                if block >= 0:
                    for a in range(d):
                        state.scale[block * d + a, v] += k
        for at in range(len(state.scale)):
            if state.scale[at, v] == 0.0:
                state.scale[at, v] = 1.0
    return most


@njit(error_model="numpy")
def _answer(
    plan: Any,
    jobs: Any,
    edges: Any,
    first: int,
    lanes: int,
    number: int,
    is_left: Any,
    state: Any,
    pushed: Any,
    answers: Any,
    tolerance: float,
) -> None:
    """The load case of this number of each of the candidates."""
    u = state.accepted
    for v in range(LANE_COUNT):
        own = first + min(v, lanes - 1)
        job = min(edges[own] + number, edges[own + 1] - 1)
        for row in range(len(u)):
            u[row, v] = jobs.start[job, row]
            state.forces[row, v] = jobs.forces[jobs.case[job], row]
    _push(plan, state, u, pushed)
    for _ in range(2):  # the second time takes the rounding of the first one out
        _gather(plan, state, pushed)
        substitute(plan, state.tangent, state.inverse, state.unknowns)
        _add(plan, state.unknowns, u)
        _push(plan, state, u, pushed)
    _gather(plan, state, pushed)
    for v in range(lanes):
        job = edges[first + v] + number
        if job < edges[first + v + 1] and not is_left[first + v]:
            _put_down(plan, state, pushed, answers, job, v, tolerance)


@njit(error_model="numpy")
def _push(plan: Any, state: Any, u: Any, pushed: Any) -> None:
    """pushed = K u with the rows of the supports; at rest, as the springs' own tangent has it."""
    d, ends = plan.dimension, plan.ends
    pushed[:] = 0.0
    for spring in range(len(ends)):
        i, j = ends[spring, 0] * d, ends[spring, 1] * d
        k, prestrain = load(state.stiffness, spring), splat(plan.prestrains[spring])
        tension, length = tension_per_length(k, plan.natural_lengths[spring], splat(plan.lengths[spring]), prestrain)
        along = splat(0.0)
        for a in range(d):
            along = fma(load(u, j + a) - load(u, i + a), splat(plan.rest_vectors[spring, a]), along)
        along = along * (k - tension) / (length * length)
        for a in range(d):
            force = fma(tension, load(u, j + a) - load(u, i + a), along * plan.rest_vectors[spring, a])
            store(pushed, j + a, load(pushed, j + a) + force)
            store(pushed, i + a, load(pushed, i + a) - force)


@njit(error_model="numpy")
def _gather(plan: Any, state: Any, pushed: Any) -> None:
    """What is out of balance, in the order of the unknowns; `internal` are the forces at rest."""
    d, unknowns = plan.dimension, state.unknowns
    for node in range(len(plan.block_of)):
        block = plan.block_of[node]
        for a in range(d if block >= 0 else 0):
            row = node * d + a
            store(unknowns, block * d + a, load(state.forces, row) - load(state.internal, row) - load(pushed, row))
    for at in plan.pinned:
        store(unknowns, at, splat(0.0))


@njit(error_model="numpy")
def _add(plan: Any, unknowns: Any, u: Any) -> None:
    d = plan.dimension
    for node in range(len(plan.block_of)):
        block = plan.block_of[node]
        for a in range(d if block >= 0 else 0):
            row = node * d + a
            store(u, row, load(u, row) + load(unknowns, block * d + a))


@njit(error_model="numpy")
def _put_down(plan: Any, state: Any, pushed: Any, answers: Any, job: int, v: int, tolerance: float) -> None:
    """One answer, judged as `linear` judges it."""
    residual, scale, energy, rounding = 0.0, 0.0, state.scalars[ENERGY, v], 0.0
    for at in range(len(state.unknowns)):
        residual = max(residual, abs(state.unknowns[at, v]))
    for row in range(len(state.forces)):
        force, rest, push = state.forces[row, v], state.internal[row, v], pushed[row, v]
        scale = max(scale, abs(force))
        energy += state.accepted[row, v] * (rest + 0.5 * push - force)
        answers.displacements[job, row] = state.accepted[row, v]
    for row in plan.supported:
        scale = max(scale, abs(state.forces[row, v] - state.internal[row, v] - pushed[row, v]))
    at_node = np.zeros(len(plan.nodes))
    for spring in range(len(plan.ends)):
        k, reach = state.stiffness[spring, v], abs(plan.prestrains[spring])
        scale = max(scale, k * reach)
        for end in range(2):
            for a in range(plan.dimension):
                reach += abs(state.accepted[plan.ends[spring, end] * plan.dimension + a, v])
        for end in range(2):
            at_node[plan.ends[spring, end]] += k * reach
    for node in range(len(at_node)):
        rounding = max(rounding, 4.0 * EPSILON * at_node[node])
    is_balanced = residual <= max(tolerance * scale, rounding)
    answers.codes[job] = CONVERGED if is_balanced else ITERATION_LIMIT
    answers.residuals[job], answers.energies[job], answers.iterations[job] = residual, energy, 1
