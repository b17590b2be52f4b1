"""What the time steps of eight motions read, write and keep."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from springopt.effects.lanes import LANE_COUNT
from springopt.forward.counter import make_counter
from springopt.forward.state import IDLE

# Rows of `Motion.scalars`.
(
    ENERGY,  # scratch of the kernels
    JOB,
    TIME,
    STEP,  # length of the step under way
    LAST_STEP,  # length of the one before; 0: there was none
    LONGEST,  # how long the next step may be
    TARGET,  # which of the times is next
    STEPS_LEFT,  # steps until then, the one under way among them
    STAGE,  # see below
    ITERATIONS,  # of the stage under way
    RESIDUAL,
    LAST_RESIDUAL,
    FORCE_SCALE,  # largest force at the trial state: loads, internal forces, inertia
    LARGEST_FORCE,  # the same over all steps so far
    TO_SPEED,  # speed = TO_SPEED (trial - base)
    TO_ACCELERATION,  # acceleration = TO_ACCELERATION (speed - base speed)
    IS_FRESH,  # 1 where the trial state was not evaluated yet
    STEP_COUNT,
    STRETCH,  # what Newton's step is to be multiplied by, 0 where none is taken
    POTENTIAL,  # strain energy less work at the trial state, where forces are taken there
    LAST_ENERGY,  # all of it where the step begins
    IS_EULER,  # 1 where the step under way is one of the implicit Euler method
    SCALAR_COUNT,
) = range(23)
# What the trial state of a lane is.
AT_START, FIRST_STAGE, SECOND_STAGE = range(3)


class MotionJobs(NamedTuple):
    """Which motions to follow: job q is candidate `candidate[q]` under load case `case[q]`."""

    candidate: NDArray[np.int64]  # (jobs,)
    case: NDArray[np.int64]  # (jobs,)
    candidates: NDArray[np.float64]  # (m, s + p), see `terms`
    masses: NDArray[np.float64]  # (m, n)
    forces: NDArray[np.float64]  # (cases, n d)
    prescribed: NDArray[np.float64]  # (cases, n d)
    times: NDArray[np.float64]  # (cases, t)
    taken: NDArray[np.int64]  # a counter of those that were taken up, or of their candidates

    def part(self, few: slice) -> "MotionJobs":
        """A few of the jobs, all still to be taken up."""
        return self._replace(candidate=self.candidate[few], case=self.case[few], taken=make_counter())


class MotionAnswers(NamedTuple):
    """One row a job."""

    displacements: NDArray[np.float64]  # (jobs, t, n d)
    velocities: NDArray[np.float64]  # (jobs, t, n d)
    codes: NDArray[np.int8]  # (jobs,), see status
    residuals: NDArray[np.float64]  # (jobs,), the largest of all steps
    steps: NDArray[np.int64]  # (jobs,)
    is_euler: NDArray[np.bool_]  # (jobs, t), whether the step that ended at this time was one of implicit Euler

    def part(self, few: slice) -> "MotionAnswers":
        """The rows of a few jobs, to be written in place."""
        u, v, codes, residuals, steps, is_euler = self
        return MotionAnswers(u[few], v[few], codes[few], residuals[few], steps[few], is_euler[few])


class Options(NamedTuple):
    """`Stepping` and tolerance as the kernels read them."""

    step: float
    is_midpoint: bool  # energy-momentum; else l-stable
    allowed: float  # error of a step [length]; 0: any
    tolerance: float


class Motion(NamedTuple):
    """Eight motions under way, in lane blocks of shape (rows, 8)."""

    scalars: NDArray[np.float64]
    stiffness: NDArray[np.float64]  # (s, 8)
    values: NDArray[np.float64]  # (p, 8)
    masses: NDArray[np.float64]  # (n, 8)
    forces: NDArray[np.float64]  # (n d, 8)
    start: NDArray[np.float64]  # (n d, 8), displacements where the step begins
    start_speed: NDArray[np.float64]  # (n d, 8)
    base: NDArray[np.float64]  # (n d, 8), displacements from which the stage goes on
    base_speed: NDArray[np.float64]  # (n d, 8)
    trial: NDArray[np.float64]  # (n d, 8), displacements where the stage may end
    at: NDArray[np.float64]  # (n d, 8), where forces are taken: the trial state, or half way from the base
    speed: NDArray[np.float64]  # (n d, 8), of the trial state
    acceleration: NDArray[np.float64]  # (n d, 8), of the trial state
    stage_speed: NDArray[np.float64]  # (n d, 8), found by the first stage
    stage_acceleration: NDArray[np.float64]  # (n d, 8)
    last_acceleration: NDArray[np.float64]  # (n d, 8), the mean one of the last step
    internal: NDArray[np.float64]  # (n d, 8)
    tangent: NDArray[np.float64]  # the envelope, then its factor; nothing in large systems
    inverse: NDArray[np.float64]  # (B d, 8)
    scaled: NDArray[np.float64]  # scratch of the factorization
    scale: NDArray[np.float64]  # (B d, 8), what pivots are judged by
    meeting: NDArray[np.float64]  # (B d, 8), the stiffness that meets at each unknown
    diagonal: NDArray[np.float64]  # (B d, 8), what inertia adds to the tangent
    unknowns: NDArray[np.float64]  # (B d, 8), right-hand side, then how the trial state changes
    inertia: NDArray[np.float64]  # (3, 8), of the factorized tangent
    delta: NDArray[np.float64]  # (d, 8)


def make_motion(plan: Any) -> Motion:
    """An empty state for this plan."""
    d, node_rows, unknown_count = plan.dimension, plan.nodes.size, len(plan.first) * plan.dimension
    widest = int((np.arange(len(plan.first)) - plan.first).max(initial=0))
    own = {
        "scalars": SCALAR_COUNT,
        "stiffness": len(plan.ends),
        "values": plan.value_count,
        "masses": len(plan.nodes),
        "tangent": plan.block_count * d * d,
        "scaled": widest * d * d,
        "inertia": 3,
        "delta": d,
    }
    own |= dict.fromkeys(("inverse", "scale", "meeting", "diagonal", "unknowns"), unknown_count)
    motion = Motion(**{name: np.zeros((own.get(name, node_rows), LANE_COUNT)) for name in Motion._fields})
    motion.scalars[JOB] = IDLE
    motion.scale[:] = 1.0  # a lane that never gets a job factorizes something harmless
    return motion
