"""What one search in a large system works on: eight load cases of one candidate, and the matrices of their tangents."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from springopt.effects.lanes import LANE_COUNT
from springopt.forward.layout import Layout
from springopt.forward.plan import Plan, as_at_rest
from springopt.forward.solver import Matrix
from springopt.forward.sparse_kernels import Tangents, evaluate_forces, multiply, scatter
from springopt.forward.state import ENERGY, Lanes, make_lanes

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Workspace:
    """Made for each call of an engine, so that calls may run side by side."""

    plan: Plan
    state: Lanes
    tangents: Tangents
    spread: Floats  #: scratch, shape (n d, 8)
    product: Floats  #: the last product with the tangents, shape (B d, 8)

    @classmethod
    def of(cls, plan: Plan, *, in_motion: bool = False) -> "Workspace":
        has_blocks = len(plan.potentials.table) or in_motion
        rows = len(plan.coupled) * plan.dimension**2 if has_blocks else 0
        tangents = Tangents(
            cache=np.zeros((2 * len(plan.ends), LANE_COUNT)),
            coupled=np.zeros((rows, LANE_COUNT)),
        )
        state = make_lanes(plan._replace(block_count=0))
        return cls(plan, state, tangents, np.zeros((plan.nodes.size, LANE_COUNT)), np.zeros_like(state.unknowns))

    def evaluate(self, candidate: Floats, displacements: Floats) -> None:
        """Forces and tangents of one candidate (s + p,) at up to eight states (c, n d); spare lanes repeat the last."""
        lanes = np.minimum(np.arange(LANE_COUNT), len(displacements) - 1)
        stiffness, values = np.split(candidate, [len(self.plan.ends)])
        self.state.stiffness[:], self.state.values[:] = stiffness[:, None], values[:, None]
        self.state.trial[:] = displacements[lanes].T
        self.state.scale[:] = self.state.meeting[:] = meeting_stiffness(self.plan, stiffness)[:, None]
        evaluate_forces(self.plan, self.state, self.tangents)

    def evaluate_rest(self, candidate: Floats) -> None:
        """The same for one candidate at rest, to precondition with: contact may be over there, or not have begun."""
        rest = replace(self, plan=as_at_rest(self.plan))
        self.tangents.coupled[:] = 0.0
        rest.evaluate(candidate, np.zeros((1, self.plan.nodes.size)))

    def energies(self, candidate: Floats, displacements: Floats) -> Floats:
        """Strain energies of one candidate (s + p,) at any number of states (c, n d), shape (c,)."""
        answers = np.empty(len(displacements))
        for begin in range(0, len(displacements), LANE_COUNT):
            few = displacements[begin : begin + LANE_COUNT]
            self.evaluate(candidate, few)
            answers[begin : begin + len(few)] = self.state.scalars[ENERGY, : len(few)]
        return answers

    def loose_unknowns(self) -> NDArray[np.bool_]:
        """Which unknowns (B d,) belong to nodes that no spring holds, where no effect may hold them either."""
        d, size = self.plan.dimension, len(self.plan.first)
        if len(self.plan.potentials.table):
            return np.zeros(size * d, dtype=np.bool_)
        at_node = np.bincount(self.plan.ends.ravel(), np.repeat(self.state.stiffness[:, 0], 2), len(self.plan.nodes))
        is_loose = np.zeros(size, dtype=np.bool_)
        is_free = self.plan.block_of >= 0
        is_loose[self.plan.block_of[is_free]] = at_node[is_free] == 0.0
        return np.repeat(is_loose, d)

    def multiply(self, p: Floats) -> Floats:
        """The tangents of the lanes times p (B d, 8), valid until the next product."""
        multiply(self.plan, self.state, self.tangents, self.spread, p, self.product)
        return self.product

    def gather(self, at_nodes: Floats) -> Floats:
        """Numbers at the nodes of up to eight lanes (c, n d), in the order of the unknowns, shape (B d, 8)."""
        d, is_free = self.plan.dimension, self.plan.block_of >= 0
        blocks = np.zeros((len(self.plan.first), d, LANE_COUNT))
        by_node = at_nodes.T.reshape(len(self.plan.nodes), d, len(at_nodes))
        blocks[self.plan.block_of[is_free], :, : len(at_nodes)] = by_node[is_free]
        unknowns = blocks.reshape(-1, LANE_COUNT)
        unknowns[self.plan.pinned] = 0.0
        return unknowns

    def spread_out(self, unknowns: Floats, at_nodes: Floats) -> None:
        """The way back, into (n d, 8): zero at the supports."""
        d, is_free = self.plan.dimension, self.plan.block_of >= 0
        by_node = at_nodes.reshape(len(self.plan.nodes), d, LANE_COUNT)
        by_node[:] = 0.0
        blocks = np.zeros((len(self.plan.first), d, LANE_COUNT))
        blocks[:, :, : unknowns.shape[1]] = unknowns.reshape(len(self.plan.first), d, unknowns.shape[1])
        by_node[is_free] = blocks[self.plan.block_of[is_free]]
        at_nodes[self.plan.supported] = 0.0

    def fill(self, matrix: Matrix, layout: Layout, lane: int, weight: float = 1.0) -> None:
        """The tangent of one lane, times `weight`, into a matrix."""
        matrix.clear()
        matrix.scale[: len(self.state.scale)] = weight * self.state.scale[:, lane]
        places = (layout.springs, layout.coupled, layout.pinned)
        scatter(self.plan, self.state, self.tangents, lane, weight, *places, matrix.entries)


def meeting_stiffness(plan: Plan, stiffness: Floats) -> Floats:
    """What pivots are judged by: the stiffness that meets at each unknown, the stiffest where there is none."""
    at_node = np.bincount(plan.ends.ravel(), np.repeat(stiffness, 2), minlength=len(plan.nodes))
    at_block = np.zeros(len(plan.first))
    is_free = plan.block_of >= 0
    at_block[plan.block_of[is_free]] = at_node[is_free]
    stiffest = stiffness.max(initial=0.0)
    at_block[at_block == 0.0] = stiffest if stiffest > 0 else 1.0
    return np.repeat(at_block, plan.dimension)
