"""The jobs that wait: a lane takes one up, and puts it down when its equilibrium is found or given up."""

from typing import Any

import numpy as np
from numba import njit

from springopt.effects.lanes import LANE_COUNT
from springopt.forward.counter import draw
from springopt.forward.state import (
    CONTRAST,
    IDLE,
    ITERATIONS,
    JOB,
    LAST_ENERGY,
    LAST_RESIDUAL,
    LAST_SLOPE,
    MARGIN,
    PHASE,
    PRESTRESS,
    REPLACEMENT,
    STARTING,
    STEP,
    STEP_LIMIT,
)

# What a pivot that is not positive is replaced by, in relation to its scale; see `courses`.
USUAL_REPLACEMENT = 1e-2
# Newton's last step usually lands far below the tolerance; ask for that much, unless progress has ended.
USUAL_MARGIN = 1e-2


@njit(error_model="numpy")
def refill(plan: Any, jobs: Any, state: Any) -> bool:
    """Idle lanes take up waiting jobs; whether any lane has one."""
    is_busy = False
    for v in range(LANE_COUNT):
        if state.scalars[JOB, v] == IDLE:
            job = draw(jobs.taken, len(jobs.case))
            if job >= 0:
                _take_up(plan, jobs, state, v, job)
        is_busy |= state.scalars[JOB, v] != IDLE
    return is_busy


@njit(error_model="numpy")
def _take_up(plan: Any, jobs: Any, state: Any, v: int, job: int) -> None:
    """Lane v starts a job."""
    d, scale, lane = plan.dimension, state.scale, state.scalars
    candidate, case = jobs.candidate[job], jobs.case[job]
    for at in range(len(scale)):
        scale[at, v] = 0.0
        state.direction[at, v] = 0.0
    prestress, stiffest = 0.0, 0.0
    for spring in range(len(plan.ends)):
        k = jobs.candidates[candidate, spring]
        state.stiffness[spring, v] = k
        prestress = max(prestress, k * abs(plan.prestrains[spring]))
        stiffest = max(stiffest, k)
        for end in range(2):
            block = plan.block_of[plan.ends[spring, end]]
            if block >= 0:
                for a in range(d):
                    scale[block * d + a, v] += k
    for number in range(len(state.values)):
        state.values[number, v] = jobs.candidates[candidate, len(plan.ends) + number]
    softest, hardest = np.inf, 0.0
    for at in range(len(scale)):
        if scale[at, v] == 0.0:  # a node without springs: any positive pivot keeps it at rest
            scale[at, v] = stiffest if stiffest > 0.0 else 1.0
        softest, hardest = min(softest, scale[at, v]), max(hardest, scale[at, v])
        state.meeting[at, v] = scale[at, v]
    for row in range(len(state.forces)):
        state.forces[row, v] = jobs.forces[case, row]
        state.trial[row, v] = jobs.start[job, row]
        state.accepted[row, v] = jobs.start[job, row]
    lane[JOB, v], lane[PHASE, v], lane[ITERATIONS, v] = job, STARTING, 0.0
    lane[STEP_LIMIT, v], lane[STEP, v], lane[PRESTRESS, v] = plan.step_limit, 0.0, prestress
    lane[LAST_RESIDUAL, v], lane[LAST_ENERGY, v], lane[LAST_SLOPE, v] = np.inf, 0.0, -np.inf
    lane[CONTRAST, v], lane[MARGIN, v], lane[REPLACEMENT, v] = hardest / softest, USUAL_MARGIN, USUAL_REPLACEMENT


@njit(error_model="numpy")
def put_down(state: Any, answers: Any, v: int, code: int) -> None:
    """Lane v is done: write its answer."""
    lane = state.scalars
    job = int(lane[JOB, v])
    for row in range(len(state.accepted)):
        answers.displacements[job, row] = state.accepted[row, v]
    answers.codes[job] = code
    answers.residuals[job], answers.energies[job] = lane[LAST_RESIDUAL, v], lane[LAST_ENERGY, v]
    answers.iterations[job] = int(lane[ITERATIONS, v])
    lane[JOB, v] = IDLE
