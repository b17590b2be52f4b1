"""Derivatives of equilibria with respect to the stiffness, by the adjoint method, on the tangent that Newton used.

At an equilibrium K du = -(dF/dk) dk, where the internal force of spring s changes by its elongation along it. With
K lambda = g, the derivative of any function of the positions with gradient g is -lambda . dF/dk: one solve for a
gradient, one for each coordinate for the Jacobian. Modes without stiffness are kept at rest, in the derivative too.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from springopt.effects.compile import compiled
from springopt.effects.lanes import LANE_COUNT, fma, load, splat, store
from springopt.effects.springs import elongation, tension_per_length
from springopt.forward.evaluation import evaluate
from springopt.forward.factor import factorize, substitute
from springopt.forward.plan import Plan
from springopt.forward.state import make_lanes

# A zero pivot becomes this times its scale: nothing moves along a mode that nothing resists.
RIGID = 1e30


def gradients(
    plan: Plan, stiffness: NDArray[np.float64], displacements: NDArray[np.float64], loads: NDArray[np.float64]
) -> NDArray[np.float64]:
    """d(g . u)/dk for each load case of one set of supports, shape (g, s).

    `stiffness` (s,); `displacements` (g, n d), the equilibria; `loads` (g, n d), the gradients g with respect to u.
    """
    answers = np.zeros((len(loads), len(stiffness)))
    _gradients(plan, make_lanes(plan, len(stiffness)), stiffness, displacements, loads, answers)
    return answers


def jacobians(plan: Plan, stiffness: NDArray[np.float64], displacements: NDArray[np.float64]) -> NDArray[np.float64]:
    """du/dk for each load case, shape (g, n d, s); arguments as in `gradients`."""
    answers = np.zeros((len(displacements), plan.nodes.size, len(stiffness)))
    _jacobians(plan, make_lanes(plan, len(stiffness)), stiffness, displacements, answers)
    return answers


def tangents(plan: Plan, stiffness: NDArray[np.float64], displacements: NDArray[np.float64]) -> NDArray[np.float64]:
    """The tangent stiffness of each load case, shape (g, n d, n d); zero in the supports' rows."""
    d, size = plan.dimension, plan.nodes.size
    state = make_lanes(plan, len(stiffness))
    answers = np.zeros((len(displacements), size, size))
    node_of = np.argsort(np.where(plan.block_of < 0, plan.block_of.size, plan.block_of), kind="stable")
    for case, u in enumerate(displacements):
        state.stiffness[:], state.trial[:] = stiffness[:, None], u[:, None]
        evaluate(plan, state)
        blocks = state.tangent[:, 0].reshape(-1, d, d)
        for row in range(len(plan.first)):
            for column in range(plan.first[row], row + 1):
                block = blocks[plan.start[row] + column - plan.first[row]]
                i, j = node_of[row] * d, node_of[column] * d
                answers[case, i : i + d, j : j + d] = block
                answers[case, j : j + d, i : i + d] = block.T
        answers[case, plan.supported] = 0.0
        answers[case, :, plan.supported] = 0.0
    return answers


@njit(error_model="numpy")
def _prepare(plan: Any, state: Any, stiffness: Any, displacements: Any, begin: int) -> None:
    """Factorize the tangents of eight load cases from `begin` on; spare lanes repeat the last one."""
    d = plan.dimension
    for v in range(LANE_COUNT):
        case = min(begin + v, len(displacements) - 1)
        state.trial[:, v] = displacements[case]
        state.stiffness[:, v] = stiffness
    state.scale[:] = 0.0
    for spring in range(len(plan.ends)):
        for end in range(2):
            block = plan.block_of[plan.ends[spring, end]]
            if block >= 0:
                state.scale[block * d : block * d + d] += stiffness[spring]
    for at in range(len(state.scale)):
        if state.scale[at, 0] == 0.0:
            state.scale[at] = 1.0
    evaluate(plan, state)
    factorize(plan, state.tangent, state.inverse, state.scaled, state.scale, splat(RIGID), state.inertia)


@njit(error_model="numpy")
def _adjoint(plan: Any, state: Any) -> None:
    """Solve for the adjoints in `state.unknowns`; into `state.internal` (n d, 8), zero at the supports."""
    d = plan.dimension
    for at in plan.pinned:
        store(state.unknowns, at, splat(0.0))
    substitute(plan, state.tangent, state.inverse, state.unknowns)
    for node in range(len(plan.block_of)):
        block = plan.block_of[node]
        for a in range(d):
            value = load(state.unknowns, block * d + a) if block >= 0 else splat(0.0)
            store(state.internal, node * d + a, value)


@njit(error_model="numpy")
def _against_springs(plan: Any, state: Any, spring: int) -> Any:
    """-lambda . dF/dk of one spring, for eight load cases."""
    d = plan.dimension
    i, j = plan.ends[spring, 0] * d, plan.ends[spring, 1] * d
    natural = plan.natural_lengths[spring]
    length, longer = elongation(
        state.trial,
        i,
        j,
        plan.rest_vectors,
        spring,
        plan.lengths[spring],
        natural,
        plan.prestrains[spring],
        state.delta,
    )
    per_length, _ = tension_per_length(splat(1.0), natural, length, longer)
    total = splat(0.0)
    for a in range(d):
        change = load(state.internal, i + a) - load(state.internal, j + a)
        total = fma(change * per_length, load(state.delta, a), total)
    return total


@compiled
def _gradients(plan: Any, state: Any, stiffness: Any, displacements: Any, loads: Any, answers: Any) -> None:
    d = plan.dimension
    for begin in range(0, len(displacements), LANE_COUNT):
        count = min(LANE_COUNT, len(displacements) - begin)
        _prepare(plan, state, stiffness, displacements, begin)
        state.unknowns[:] = 0.0
        for node in range(len(plan.block_of)):
            block = plan.block_of[node]
            if block >= 0:
                for a in range(d):
                    for v in range(count):
                        state.unknowns[block * d + a, v] = loads[begin + v, node * d + a]
        _adjoint(plan, state)
        spring_gradients(plan, state, answers[begin : begin + count])


@compiled
def spring_gradients(plan: Any, state: Any, answers: Any) -> None:
    """-lambda . dF/dk of all springs into `answers` (lanes, s), for the adjoints in `state.internal` (n d, 8)."""
    for spring in range(len(plan.ends)):
        store(state.scalars, 0, _against_springs(plan, state, spring))
        for v in range(len(answers)):
            answers[v, spring] = state.scalars[0, v]


@compiled
def _jacobians(plan: Any, state: Any, stiffness: Any, displacements: Any, answers: Any) -> None:
    d = plan.dimension
    is_supported = np.zeros(plan.nodes.size, dtype=np.bool_)
    is_supported[plan.supported] = True
    for begin in range(0, len(displacements), LANE_COUNT):
        count = min(LANE_COUNT, len(displacements) - begin)
        _prepare(plan, state, stiffness, displacements, begin)
        for row in range(plan.nodes.size):
            if is_supported[row]:
                continue
            state.unknowns[:] = 0.0
            state.unknowns[plan.block_of[row // d] * d + row % d] = 1.0
            _adjoint(plan, state)
            for spring in range(len(plan.ends)):
                store(state.scalars, 0, _against_springs(plan, state, spring))
                for v in range(count):
                    answers[begin + v, row, spring] = state.scalars[0, v]
