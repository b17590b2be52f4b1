"""The time steps of eight motions, each lane by its own clock.

A lane starts a step at a predicted state and takes Newton steps until the forces balance; then its next stage or step
begins. Between two of the times that are asked for steps are equal, and end on them. Under an error that is allowed, a
step is judged by how the acceleration changed since the last one: the local error of both integrators is some h^3 / 12
times the third derivative.
"""

from typing import Any

import numpy as np
from numba import njit

from springopt.effects.compile import compiled
from springopt.effects.lanes import LANE_COUNT, load, splat, store, where_greater
from springopt.forward.counter import draw
from springopt.forward.motion.state import (
    AT_START,
    FIRST_STAGE,
    FORCE_SCALE,
    IS_EULER,
    IS_FRESH,
    ITERATIONS,
    JOB,
    LARGEST_FORCE,
    LAST_ENERGY,
    LAST_RESIDUAL,
    LAST_STEP,
    LONGEST,
    POTENTIAL,
    RESIDUAL,
    SECOND_STAGE,
    STAGE,
    STEP,
    STEP_COUNT,
    STEPS_LEFT,
    STRETCH,
    TARGET,
    TIME,
    TO_ACCELERATION,
    TO_SPEED,
)
from springopt.forward.state import EPSILON, IDLE
from springopt.forward.status import CONVERGED, ITERATION_LIMIT

GAMMA = 1.0 - np.sqrt(0.5)  # makes the method of two stages L-stable and of second order
NEWTON_LIMIT = 40
# Energies drift with what is left out of balance, step by step; Newton's last steps are cheap.
MARGIN = 1e-3
SLOWLY = 0.1
# A step of two stages that gains more than this share of what moves met something in between, such as an impact.
GAIN = 0.01
SHORTEST = 2.0**-30  # of the longest step: no error is allowed so small
MOST_STEPS = 1e9


@compiled
def take_up_motions(plan: Any, jobs: Any, motion: Any, options: Any) -> bool:
    """Idle lanes take up waiting jobs; whether any lane has one."""
    is_busy = False
    for v in range(LANE_COUNT):
        if motion.scalars[JOB, v] == IDLE:
            job = draw(jobs.taken, len(jobs.case))
            if job >= 0:
                _take_up(plan, jobs, motion, options, v, job)
        is_busy |= motion.scalars[JOB, v] != IDLE
    return is_busy


@njit(error_model="numpy")
def _take_up(plan: Any, jobs: Any, motion: Any, options: Any, v: int, job: int) -> None:
    """Lane v starts at rest, with its supports where they are prescribed to be."""
    d, candidate, case, lane = plan.dimension, jobs.candidate[job], jobs.case[job], motion.scalars
    for number in range(len(motion.values)):
        motion.values[number, v] = jobs.candidates[candidate, len(plan.ends) + number]
    for at in range(len(motion.meeting)):
        motion.meeting[at, v] = 0.0
    prestress = 0.0
    for spring in range(len(plan.ends)):
        k = jobs.candidates[candidate, spring]
        motion.stiffness[spring, v] = k
        prestress = max(prestress, k * abs(plan.prestrains[spring]))
        for end in range(2):
            block = plan.block_of[plan.ends[spring, end]]
            if block >= 0:
                for a in range(d):
                    motion.meeting[block * d + a, v] += k
    for at in range(len(motion.meeting)):
        if motion.meeting[at, v] == 0.0:  # nothing but inertia, which stands on the diagonal
            motion.meeting[at, v] = 1e-300
    for node in range(len(plan.nodes)):
        motion.masses[node, v] = jobs.masses[candidate, node]
    for row in range(len(motion.forces)):
        motion.forces[row, v] = jobs.forces[case, row]
        motion.start[row, v] = jobs.prescribed[case, row]
        motion.base[row, v] = motion.trial[row, v] = motion.start[row, v]
        motion.start_speed[row, v] = motion.base_speed[row, v] = motion.last_acceleration[row, v] = 0.0
    lane[JOB, v], lane[TIME, v], lane[TARGET, v], lane[STEP_COUNT, v] = job, 0.0, 0.0, 0.0
    lane[STEP, v], lane[LAST_STEP, v], lane[STEPS_LEFT, v], lane[LONGEST, v] = 0.0, 0.0, 0.0, options.step
    lane[LARGEST_FORCE, v], lane[STAGE, v], lane[IS_FRESH, v] = prestress, AT_START, 1.0
    lane[TO_SPEED, v], lane[TO_ACCELERATION, v] = 1.0 / options.step, 1.0 / options.step
    lane[IS_EULER, v], lane[LAST_ENERGY, v] = 0.0, 0.0


@compiled
def judge_motions(plan: Any, jobs: Any, motion: Any, answers: Any, options: Any) -> bool:
    """Lanes in balance go on to their next stage or step; whether any lane is to take a Newton step."""
    needs_direction, lane = False, motion.scalars
    for v in range(LANE_COUNT):
        if lane[JOB, v] == IDLE:
            continue
        lane[IS_FRESH, v] = 1.0
        if lane[STAGE, v] == AT_START:
            _begin(plan, jobs, motion, options, v)
        elif _is_balanced(plan, motion, options, v):
            _end_stage(plan, jobs, motion, answers, options, v)
        elif not np.isfinite(lane[RESIDUAL, v]) or lane[ITERATIONS, v] >= NEWTON_LIMIT:
            _give_up_step(plan, jobs, motion, answers, options, v)
        else:
            lane[IS_FRESH, v] = 0.0
            needs_direction = True
            lane[LAST_RESIDUAL, v] = lane[RESIDUAL, v]
            lane[ITERATIONS, v] += 1.0
    return needs_direction


@njit(error_model="numpy")
def _is_balanced(plan: Any, motion: Any, options: Any, v: int) -> bool:
    lane = motion.scalars
    residual, last = lane[RESIDUAL, v], lane[LAST_RESIDUAL, v]
    wanted = options.tolerance * max(lane[LARGEST_FORCE, v], lane[FORCE_SCALE, v])
    if residual <= MARGIN * wanted or (residual <= wanted and residual > SLOWLY * last):
        return True
    if not residual > SLOWLY * last:
        return False
    return residual <= _rounding(plan, motion, v)


@njit(error_model="numpy")
def _rounding(plan: Any, motion: Any, v: int) -> float:
    """The largest residual that rounding of the displacements can leave."""
    longest, stiffest = 0.0, 0.0
    for row in range(len(motion.trial)):
        longest = max(longest, abs(motion.trial[row, v]))
    for at in range(len(motion.scale)):
        stiffest = max(stiffest, motion.scale[at, v])
    return 16.0 * EPSILON * stiffest * longest * plan.dimension


@njit(error_model="numpy")
def _begin(plan: Any, jobs: Any, motion: Any, options: Any, v: int) -> None:
    """The acceleration at the start, and the first step."""
    d = plan.dimension
    for node in range(len(plan.block_of)):
        block, mass = plan.block_of[node], motion.masses[node, v]
        for a in range(d):
            if block >= 0 and mass > 0.0:
                motion.last_acceleration[node * d + a, v] = motion.unknowns[block * d + a, v] / mass
    motion.scalars[LAST_ENERGY, v] = motion.scalars[POTENTIAL, v]
    _begin_step(jobs, motion, options, v)


@njit(error_model="numpy")
def _begin_step(jobs: Any, motion: Any, options: Any, v: int) -> None:
    """Lane v sets out from its start: as many equal steps as fit until the next of its times."""
    lane = motion.scalars
    if options.allowed > 0.0 or lane[STEPS_LEFT, v] == 0.0:
        case = jobs.case[int(lane[JOB, v])]
        left = jobs.times[case, int(lane[TARGET, v])] - lane[TIME, v]
        lane[STEPS_LEFT, v] = max(np.ceil(left / lane[LONGEST, v] - 1e-9), 1.0)
        lane[STEP, v] = left / lane[STEPS_LEFT, v]
    h = lane[STEP, v]
    lane[STAGE, v] = FIRST_STAGE
    reach = h if options.is_midpoint or lane[IS_EULER, v] == 1.0 else GAMMA * h
    lane[TO_SPEED, v] = 1.0 / reach
    lane[TO_ACCELERATION, v] = 2.0 / h if options.is_midpoint else 1.0 / reach
    lane[ITERATIONS, v], lane[LAST_RESIDUAL, v] = 0.0, np.inf
    for row in range(len(motion.start)):
        base, speed = motion.start[row, v], motion.start_speed[row, v]
        motion.base[row, v], motion.base_speed[row, v] = base, speed
        motion.trial[row, v] = base + reach * (speed + 0.5 * reach * motion.last_acceleration[row, v])


@njit(error_model="numpy")
def _end_stage(plan: Any, jobs: Any, motion: Any, answers: Any, options: Any, v: int) -> None:
    lane = motion.scalars
    job = int(lane[JOB, v])
    lane[LARGEST_FORCE, v] = max(lane[LARGEST_FORCE, v], lane[FORCE_SCALE, v])
    answers.residuals[job] = max(answers.residuals[job], lane[RESIDUAL, v])
    if not options.is_midpoint and lane[STAGE, v] == FIRST_STAGE and lane[IS_EULER, v] == 0.0:
        _begin_second_stage(motion, v)
        return
    if not options.is_midpoint:
        energy, moving = _energy(plan, motion, v)
        if lane[IS_EULER, v] == 0.0 and energy > lane[LAST_ENERGY, v] + GAIN * moving:
            lane[IS_EULER, v] = 1.0
            _begin_step(jobs, motion, options, v)
            return
        lane[LAST_ENERGY, v] = energy
    if options.allowed > 0.0:
        share = _error(motion, options.is_midpoint, v) / options.allowed
        factor = min(2.0, max(0.2, 0.9 * max(share, 1e-12) ** (-1.0 / 3.0)))
        if share > 1.0 and lane[STEP, v] > SHORTEST * options.step:
            lane[LONGEST, v] = lane[STEP, v] * min(factor, 0.9)
            _begin_step(jobs, motion, options, v)
            return
        lane[LONGEST, v] = min(options.step, lane[STEP, v] * factor)
    _end_step(jobs, motion, answers, options, v)


@njit(error_model="numpy")
def _energy(plan: Any, motion: Any, v: int) -> tuple[float, float]:
    """(all energy at the trial state, the larger kinetic one of the step's two ends)."""
    d, now, before = plan.dimension, 0.0, 0.0
    for node in range(len(plan.nodes)):
        for a in range(d):
            row = node * d + a
            now += 0.5 * motion.masses[node, v] * motion.speed[row, v] ** 2
            before += 0.5 * motion.masses[node, v] * motion.start_speed[row, v] ** 2
    return motion.scalars[POTENTIAL, v] + now, max(now, before)


@njit(error_model="numpy")
def _begin_second_stage(motion: Any, v: int) -> None:
    """From where the first stage's slopes lead in the share of the step that is theirs."""
    lane = motion.scalars
    h = lane[STEP, v]
    reach = GAMMA * h
    for row in range(len(motion.start)):
        speed, acceleration = motion.speed[row, v], motion.acceleration[row, v]
        motion.stage_speed[row, v], motion.stage_acceleration[row, v] = speed, acceleration
        base = motion.start[row, v] + (h - reach) * speed
        base_speed = motion.start_speed[row, v] + (h - reach) * acceleration
        motion.base[row, v], motion.base_speed[row, v] = base, base_speed
        motion.trial[row, v] = base + reach * (base_speed + reach * acceleration)
    lane[STAGE, v], lane[ITERATIONS, v], lane[LAST_RESIDUAL, v] = SECOND_STAGE, 0.0, np.inf


@njit(error_model="numpy")
def _mean_acceleration(motion: Any, is_midpoint: bool, row: int, v: int) -> float:
    """Over the step that ends in the trial state."""
    if is_midpoint:
        return motion.acceleration[row, v]
    return (motion.speed[row, v] - motion.start_speed[row, v]) / motion.scalars[STEP, v]


@njit(error_model="numpy")
def _error(motion: Any, is_midpoint: bool, v: int) -> float:
    """The largest local error of the step that ends in the trial state [length]."""
    h, before, change = motion.scalars[STEP, v], motion.scalars[LAST_STEP, v], 0.0
    for row in range(len(motion.start)):
        now = _mean_acceleration(motion, is_midpoint, row, v)
        change = max(change, abs(now - motion.last_acceleration[row, v]))
    return h**3 / 12.0 * change / (0.5 * (h + before))


@njit(error_model="numpy")
def _end_step(jobs: Any, motion: Any, answers: Any, options: Any, v: int) -> None:
    """The trial state is where the step ends, and the next one begins."""
    lane = motion.scalars
    h, job, target = lane[STEP, v], int(lane[JOB, v]), int(lane[TARGET, v])
    for row in range(len(motion.start)):
        mean = _mean_acceleration(motion, options.is_midpoint, row, v)
        speed = motion.start_speed[row, v] + h * mean if options.is_midpoint else motion.speed[row, v]
        motion.start[row, v], motion.start_speed[row, v] = motion.trial[row, v], speed
        motion.last_acceleration[row, v] = mean
    lane[TIME, v] += h
    lane[LAST_STEP, v] = h
    lane[STEP_COUNT, v] += 1.0
    lane[STEPS_LEFT, v] -= 1.0
    if lane[STEPS_LEFT, v] == 0.0:
        lane[TIME, v] = jobs.times[jobs.case[job], target]
        for row in range(len(motion.start)):
            answers.displacements[job, target, row] = motion.start[row, v]
            answers.velocities[job, target, row] = motion.start_speed[row, v]
        answers.is_euler[job, target] = lane[IS_EULER, v] == 1.0
        lane[TARGET, v] += 1.0
        if lane[TARGET, v] == jobs.times.shape[1]:
            _put_down(motion, answers, v, CONVERGED)
            return
    lane[IS_EULER, v] = 0.0
    if lane[STEP_COUNT, v] >= MOST_STEPS:
        _put_down(motion, answers, v, ITERATION_LIMIT)
        return
    _begin_step(jobs, motion, options, v)


@njit(error_model="numpy")
def _give_up_step(plan: Any, jobs: Any, motion: Any, answers: Any, options: Any, v: int) -> None:
    """No balance was found at the end of this step: a shorter one, where steps may be shortened, or the end."""
    lane = motion.scalars
    if options.allowed > 0.0 and lane[STEP, v] > SHORTEST * options.step:
        lane[LONGEST, v] = 0.25 * lane[STEP, v]
        _begin_step(jobs, motion, options, v)
        return
    job = int(lane[JOB, v])
    for target in range(int(lane[TARGET, v]), jobs.times.shape[1]):  # where it stopped
        for row in range(len(motion.start)):
            answers.displacements[job, target, row] = motion.start[row, v]
            answers.velocities[job, target, row] = motion.start_speed[row, v]
    answers.residuals[job] = lane[RESIDUAL, v]
    _put_down(motion, answers, v, ITERATION_LIMIT)


@njit(error_model="numpy")
def _put_down(motion: Any, answers: Any, v: int, code: int) -> None:
    job = int(motion.scalars[JOB, v])
    answers.codes[job], answers.steps[job] = code, int(motion.scalars[STEP_COUNT, v])
    motion.scalars[JOB, v] = IDLE


@compiled
def step_on(plan: Any, motion: Any) -> None:
    """Newton's steps, in `unknowns`, of the lanes that are to take one; none is longer than a typical spring."""
    d, lane = plan.dimension, motion.scalars
    for v in range(LANE_COUNT):
        longest = 0.0
        for at in range(len(motion.unknowns)):
            longest = max(longest, abs(motion.unknowns[at, v]))
        stretch = plan.step_limit / max(longest, plan.step_limit)
        lane[STRETCH, v] = 0.0 if lane[IS_FRESH, v] == 1.0 or lane[JOB, v] == IDLE else stretch
    stretch, zero = load(lane, STRETCH), splat(0.0)
    for node in range(len(plan.block_of)):
        block = plan.block_of[node]
        if block >= 0:
            for a in range(d):
                row = node * d + a
                moved = load(motion.trial, row) + stretch * load(motion.unknowns, block * d + a)
                store(motion.trial, row, where_greater(stretch, zero, moved, load(motion.trial, row)))
