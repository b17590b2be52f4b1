"""What the search for equilibria reads, writes and keeps for each lane."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from springopt.effects.lanes import LANE_COUNT
from springopt.forward.counter import make_counter

# Rows of `Lanes.scalars`: what the search remembers of each lane.
(
    ENERGY,  # at the trial state
    MAGNITUDE,  # strain energy plus work, whose rounding the energy carries
    RESIDUAL,  # largest out-of-balance force at the trial state
    FORCE_SCALE,  # largest of loads and reactions at the trial state
    ACCEPTED,  # 1 where the trial state was accepted, else 0
    SLOPE,  # of the energy along the direction found, per step 1
    LONGEST,  # largest component of that direction
    STRETCH,  # what that direction is to be multiplied by
    STEP,  # share of the direction that the trial state goes
    JOB,
    PHASE,
    ITERATIONS,
    LAST_ENERGY,  # at the accepted state
    LAST_MAGNITUDE,
    LAST_RESIDUAL,
    LAST_SLOPE,
    IS_CAPPED,  # 1 where the step was shortened to the limit
    STEP_LIMIT,
    CURVATURE,  # of the energy along the direction of an escape, per step 1 squared; negative
    PRESTRESS,  # largest force in a spring at rest
    CONTRAST,  # of the stiffness that meets at one unknown to that at another, at most
    MARGIN,  # share of the tolerance that ends the search
    RELAXATION,  # share of a Newton step from the trial state that the next trial state goes; 0: none
    UNRELAXED,  # energy at the trial state before that step
    REPLACEMENT,  # of a pivot that is not positive, in relation to its scale
    FALLBACK,  # the status if the escape under way finds no way down
    VERDICT,  # on the accepted state, if it was to be certified
    SCALAR_COUNT,
) = range(28)

IDLE = -1  # the job of a lane that has none
# What the trial state of a lane is, as row PHASE says.
(
    STARTING,  # where its job begins, or begins again
    STEPPING,  # a Newton step on from the accepted state
    RELAXING,  # another step on from there, since that one was refused
    CERTIFYING,  # balanced, a minimum or not
    ESCAPING,  # a step down from a saddle
    STALLED,  # the accepted state, since no step leads on
    STUCK,  # the accepted state, a saddle that no step leads down from
) = range(7)
EPSILON = 2.0**-52


class Jobs(NamedTuple):
    """Which equilibria to find: job q is candidate `candidate[q]` under load case `case[q]`.

    Threads that are given the same jobs share them.
    """

    candidate: NDArray[np.int64]  # (jobs,)
    case: NDArray[np.int64]  # (jobs,)
    candidates: NDArray[np.float64]  # (m, s + p), stiffness and the parameters of effects, see `terms`
    forces: NDArray[np.float64]  # (cases, n d)
    start: NDArray[np.float64]  # (jobs, n d), displacements to search from; those of the supports stay
    taken: NDArray[np.int64]  # a counter of those that were taken up, or of their candidates

    def part(self, few: slice) -> "Jobs":
        """A few of the jobs, all still to be taken up."""
        candidate, case, start = self.candidate[few], self.case[few], self.start[few]
        return Jobs(candidate, case, self.candidates, self.forces, start, make_counter())


class Answers(NamedTuple):
    """One row a job."""

    displacements: NDArray[np.float64]  # (jobs, n d)
    codes: NDArray[np.int8]  # (jobs,), see status
    residuals: NDArray[np.float64]  # (jobs,), largest out-of-balance force of a free degree of freedom
    energies: NDArray[np.float64]  # (jobs,), strain energy less forces . displacements
    iterations: NDArray[np.int64]  # (jobs,)

    def part(self, few: slice) -> "Answers":
        """The rows of a few jobs, to be written in place."""
        u, codes, residuals, energies, iterations = self
        return Answers(u[few], codes[few], residuals[few], energies[few], iterations[few])


class Lanes(NamedTuple):
    """The states under way, in lane blocks of shape (rows, 8)."""

    scalars: NDArray[np.float64]  # rows as numbered above
    inertia: NDArray[np.float64]  # (3, 8), of the factorized tangent
    stiffness: NDArray[np.float64]  # (s, 8)
    values: NDArray[np.float64]  # (p, 8), the parameters of effects
    forces: NDArray[np.float64]  # (n d, 8)
    trial: NDArray[np.float64]  # (n d, 8), displacements where everything is evaluated
    accepted: NDArray[np.float64]  # (n d, 8), displacements of the last accepted state
    internal: NDArray[np.float64]  # (n d, 8), internal forces at the trial state
    tangent: NDArray[np.float64]  # the envelope, then its factor
    inverse: NDArray[np.float64]  # (B d, 8), inverse pivots
    scaled: NDArray[np.float64]  # scratch of the factorization
    scale: NDArray[np.float64]  # (B d, 8), the stiffness that meets at each unknown, effects included
    meeting: NDArray[np.float64]  # (B d, 8), that of the springs alone
    residual: NDArray[np.float64]  # (B d, 8), forces less internal forces at the accepted state
    direction: NDArray[np.float64]  # (B d, 8)
    unknowns: NDArray[np.float64]  # (B d, 8), right-hand side, then solution
    delta: NDArray[np.float64]  # (d, 8), the vector of one spring


def make_lanes(plan: Any) -> Lanes:
    """An empty state for this plan."""
    d, node_rows, unknown_count = plan.dimension, plan.nodes.size, len(plan.first) * plan.dimension
    widest = int((np.arange(len(plan.first)) - plan.first).max(initial=0))

    rows = {
        "scalars": SCALAR_COUNT,
        "inertia": 3,
        "stiffness": len(plan.ends),
        "values": plan.value_count,
        "forces": node_rows,
        "trial": node_rows,
        "accepted": node_rows,
        "internal": node_rows,
        "inverse": unknown_count,
        "scaled": widest * d * d,
        "scale": unknown_count,
        "meeting": unknown_count,
        "residual": unknown_count,
        "direction": unknown_count,
        "unknowns": unknown_count,
        "delta": d,
    }
    whole, begin, blocks = np.zeros((sum(rows.values()), LANE_COUNT)), 0, {}
    for name, count in rows.items():
        blocks[name] = whole[begin : begin + count]
        begin += count
    # The tangent is large, and always filled before it is read.
    state = Lanes(tangent=np.empty((plan.block_count * d * d, LANE_COUNT)), **blocks)
    state.scalars[JOB] = IDLE
    state.scale[:] = 1.0  # a lane that never gets a job factorizes something harmless
    return state
