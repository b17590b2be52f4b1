"""The factorized tangents of small systems, eight load cases side by side."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springopt.effects.compile import compiled
from springopt.effects.lanes import LANE_COUNT, splat, store
from springopt.forward.evaluation import evaluate
from springopt.forward.factor import factorize, substitute
from springopt.forward.plan import Plan
from springopt.forward.state import Lanes, make_lanes

Floats = NDArray[np.float64]

# A zero pivot becomes this times its scale: nothing moves along a mode that nothing resists.
RIGID = 1e30


@dataclass(frozen=True, eq=False)
class LaneFactors:
    """The tangents of one candidate in several load cases."""

    plan: Plan
    eights: Sequence[Lanes]

    @classmethod
    def of(cls, plan: Plan, candidate: Floats, displacements: Floats) -> "LaneFactors":
        """Factorized at `displacements` (g, n d) for one candidate (s + p,)."""
        factors = cls(plan, [make_lanes(plan) for _ in range(0, len(displacements), LANE_COUNT)])
        for number, state in enumerate(factors.eights):
            _factorize(plan, state, candidate, displacements[number * LANE_COUNT :])
        return factors

    def solve(self, loads: Floats) -> Floats:
        """See `Factors`."""
        answers = np.zeros(loads.shape)
        for number, state in enumerate(self.eights):
            few = slice(number * LANE_COUNT, (number + 1) * LANE_COUNT)
            _solve(self.plan, state.tangent, state.inverse, state.unknowns, loads[few], answers[few])
        return answers


def tangents(plan: Plan, candidate: Floats, displacements: Floats) -> Floats:
    """The tangent stiffness of each load case, shape (g, n d, n d); zero in the supports' rows."""
    d, size = plan.dimension, plan.nodes.size
    state = make_lanes(plan)
    answers = np.zeros((len(displacements), size, size))
    node_of = np.argsort(np.where(plan.block_of < 0, plan.block_of.size, plan.block_of), kind="stable")
    for case, u in enumerate(displacements):
        state.stiffness[:], state.values[:] = (part[:, None] for part in np.split(candidate, [len(plan.ends)]))
        state.trial[:] = u[:, None]
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


@compiled
def _factorize(plan: Any, state: Any, candidate: Any, displacements: Any) -> None:
    """Factorize the tangents of the first eight load cases; spare lanes repeat the last one."""
    d = plan.dimension
    for v in range(LANE_COUNT):
        case = min(v, len(displacements) - 1)
        state.trial[:, v] = displacements[case]
        for spring in range(len(plan.ends)):
            state.stiffness[spring, v] = candidate[spring]
        for number in range(plan.value_count):
            state.values[number, v] = candidate[len(plan.ends) + number]
    state.scale[:] = 0.0
    for spring in range(len(plan.ends)):
        for end in range(2):
            block = plan.block_of[plan.ends[spring, end]]
            if block >= 0:
                state.scale[block * d : block * d + d] += candidate[spring]
    for at in range(len(state.scale)):
        if state.scale[at, 0] == 0.0:
            state.scale[at] = 1.0
        state.meeting[at] = state.scale[at]
    evaluate(plan, state)
    factorize(plan, state.tangent, state.inverse, state.scaled, state.scale, splat(RIGID), state.inertia)


@compiled
def _solve(plan: Any, factor: Any, inverse: Any, unknowns: Any, loads: Any, answers: Any) -> None:
    d, block_of, supported, pinned = plan.dimension, plan.block_of, plan.supported, plan.pinned
    for k in range(loads.shape[1]):
        for node in range(len(block_of)):
            for a in range(d if block_of[node] >= 0 else 0):
                for v in range(len(loads)):
                    unknowns[block_of[node] * d + a, v] = loads[v, k, node * d + a]
        for at in pinned:
            store(unknowns, at, splat(0.0))
        substitute(plan, factor, inverse, unknowns)
        for node in range(len(block_of)):
            for a in range(d if block_of[node] >= 0 else 0):
                for v in range(len(loads)):
                    answers[v, k, node * d + a] = unknowns[block_of[node] * d + a, v]
        for row in supported:
            for v in range(len(loads)):
                answers[v, k, row] = 0.0
