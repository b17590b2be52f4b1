"""How far a candidate without an equilibrium is from having one: the modes that nothing resists at rest.

How stiff the springs are plays no part: all that exist count as equally stiff and unstretched, so that the tangent's
zero pivots are the zero modes, far from rounding. A spring between nodes at the same place resists every direction if
its rest length is 0, else none: it has no direction yet.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springopt.effects.compile import compiled
from springopt.effects.lanes import LANE_COUNT, splat
from springopt.forward.batch import Group
from springopt.forward.evaluation import evaluate
from springopt.forward.factor import factorize
from springopt.forward.lane_factors import RIGID
from springopt.forward.linear import LinearEngine
from springopt.forward.linear_lanes import LinearLanesEngine
from springopt.forward.plan import Plan, without_effects
from springopt.forward.sparse import Search, SparseEngine
from springopt.forward.state import make_lanes
from springopt.forward.status import has_equilibrium

LARGEST_ENVELOPE = 1_000_000  # blocks; in three dimensions eight lanes of them take 0.6 GB


def zero_mode_shares(
    groups: Sequence[Group], stiffness: NDArray[np.float64], codes: NDArray[np.int8]
) -> NDArray[np.float64]:
    """The mean over all load cases of zero modes at rest, per free degree of freedom, shape (m,).

    `stiffness` (m, s); `codes` (m, c), the statuses: a load case with an equilibrium counts as 0. All modes count,
    loaded or not: then no spring that is added can raise the share, also where it ties a loaded part to a loose one.
    """
    totals = np.zeros(len(stiffness))
    for group in groups:
        failed = np.count_nonzero(~has_equilibrium(codes[:, group.cases]), axis=1)
        candidates = np.flatnonzero(failed)
        if len(candidates):
            unknown_count = group.plan.nodes.size - len(group.plan.supported)
            counts = zero_mode_counts(group, stiffness[candidates] > 0)
            totals[candidates] += failed[candidates] * counts / max(unknown_count, 1)
    return totals / codes.shape[1]


def zero_mode_counts(group: Group, exists: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Zero modes at rest of lattices with some of the springs, exists (m, s), and without effects, shape (m,).

    Where neither a direct solver nor the lanes' memory reaches they stay uncounted, as 0.
    """
    plan = _unstretched(group.plan)
    has_direction = (plan.lengths > 0.0) | (group.plan.natural_lengths == 0.0)
    stiffness = np.where(exists & has_direction, 1.0, 0.0)
    counts = np.zeros(len(exists))
    engine = group.engine.rest if isinstance(group.engine, LinearLanesEngine) else group.engine
    if isinstance(engine, SparseEngine | LinearEngine) and engine.solver.is_direct:
        search = Search.of(plan, engine.solver)
        for m, candidate in enumerate(stiffness):
            search.work.evaluate(candidate, np.zeros((1, plan.nodes.size)))
            search.factorize(0, RIGID)
            counts[m] = search.exact.inertia[:2].sum()
    elif plan.block_count <= LARGEST_ENVELOPE:
        _count_in_lanes(plan, make_lanes(plan), stiffness, counts)
    return counts


def _unstretched(plan: Plan) -> Plan:
    """The same lattice at its rest lengths, springs alone."""
    alone = without_effects(plan)
    return alone._replace(natural_lengths=plan.lengths, prestrains=np.zeros_like(plan.prestrains))


@compiled
def _count_in_lanes(plan: Any, state: Any, stiffness: Any, counts: Any) -> None:
    d = plan.dimension
    for begin in range(0, len(stiffness), LANE_COUNT):
        for v in range(LANE_COUNT):
            candidate = min(begin + v, len(stiffness) - 1)
            for at in range(len(state.scale)):
                state.scale[at, v] = 0.0
            for spring in range(len(plan.ends)):
                k = stiffness[candidate, spring]
                state.stiffness[spring, v] = k
                for end in range(2):
                    block = plan.block_of[plan.ends[spring, end]]
                    if block >= 0:
                        for a in range(d):
                            state.scale[block * d + a, v] += k
            for at in range(len(state.scale)):
                if state.scale[at, v] == 0.0:
                    state.scale[at, v] = 1.0
        evaluate(plan, state)
        factorize(plan, state.tangent, state.inverse, state.scaled, state.scale, splat(RIGID), state.inertia)
        for v in range(min(LANE_COUNT, len(stiffness) - begin)):
            counts[begin + v] = state.inertia[0, v] + state.inertia[1, v]
