"""What the search for equilibria reads, writes and keeps for each lane."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from springopt.effects.lanes import LANE_COUNT

IDLE = -1  # the job of a lane that has none


class Jobs(NamedTuple):
    """Which equilibria to find: job q is candidate `candidate[q]` under load case `case[q]`."""

    candidate: NDArray[np.int64]  # (jobs,)
    case: NDArray[np.int64]  # (jobs,)
    stiffness: NDArray[np.float64]  # (m, s)
    forces: NDArray[np.float64]  # (cases, n d)
    prescribed: NDArray[np.float64]  # (cases, n d), displacements of the supports, 0 elsewhere


class Answers(NamedTuple):
    """One row a job."""

    displacements: NDArray[np.float64]  # (jobs, n d)
    codes: NDArray[np.int8]  # (jobs,), see status
    residuals: NDArray[np.float64]  # (jobs,), largest out-of-balance force of a free degree of freedom
    energies: NDArray[np.float64]  # (jobs,), strain energy less forces . displacements
    iterations: NDArray[np.int64]  # (jobs,)


class Lanes(NamedTuple):
    """The states under way; arrays of shape (rows, 8) are lane blocks, those of shape (8,) scalars of each lane."""

    stiffness: NDArray[np.float64]
    forces: NDArray[np.float64]
    trial: NDArray[np.float64]  # displacements where everything is evaluated
    accepted: NDArray[np.float64]  # displacements of the last accepted state
    internal: NDArray[np.float64]  # internal forces at the trial state
    tangent: NDArray[np.float64]
    inverse: NDArray[np.float64]
    scaled: NDArray[np.float64]
    scale: NDArray[np.float64]
    residual: NDArray[np.float64]  # forces - internal forces of the unknowns at the accepted state
    direction: NDArray[np.float64]
    unknowns: NDArray[np.float64]  # right-hand side, then solution
    delta: NDArray[np.float64]
    inertia: NDArray[np.float64]
    facts: NDArray[np.float64]  # rows: see the constants below
    job: NDArray[np.int64]
    phase: NDArray[np.int64]
    iterations: NDArray[np.int64]
    is_capped: NDArray[np.bool_]
    energy: NDArray[np.float64]
    slope: NDArray[np.float64]
    step: NDArray[np.float64]
    size: NDArray[np.float64]  # largest residual at the accepted state
    radius: NDArray[np.float64]
    curvature: NDArray[np.float64]  # the negative pivot that is being escaped from, in relation to its scale
    prestress: NDArray[np.float64]


ENERGY, MAGNITUDE, LARGEST, FORCE_SCALE, IS_ACCEPTED, SLOPE, LONGEST, STEP, FACT_COUNT = range(9)


def make_lanes(plan: Any, spring_count: int) -> Lanes:
    """An empty state for this plan."""
    widths = np.arange(len(plan.first)) - plan.first
    d, unknown_count, node_rows = plan.dimension, len(plan.first) * plan.dimension, plan.nodes.size

    def block(rows: int) -> NDArray[np.float64]:
        return np.zeros((rows, LANE_COUNT))

    def scalar(kind: type = np.float64) -> Any:
        return np.zeros(LANE_COUNT, dtype=kind)

    return Lanes(
        stiffness=np.ones((spring_count, LANE_COUNT)),
        forces=block(node_rows),
        trial=block(node_rows),
        accepted=block(node_rows),
        internal=block(node_rows),
        tangent=block(plan.block_count * d * d),
        inverse=block(unknown_count),
        scaled=block(int(widths.max(initial=0)) * d * d),
        scale=np.ones((unknown_count, LANE_COUNT)),
        residual=block(unknown_count),
        direction=block(unknown_count),
        unknowns=block(unknown_count),
        delta=block(d),
        inertia=block(4),
        facts=block(FACT_COUNT),
        job=np.full(LANE_COUNT, IDLE, dtype=np.int64),
        phase=scalar(np.int64),
        iterations=scalar(np.int64),
        is_capped=scalar(np.bool_),
        energy=scalar(),
        slope=scalar(),
        step=scalar(),
        size=scalar(),
        radius=scalar(),
        curvature=scalar(),
        prestress=scalar(),
    )
