"""The motions of all candidates under all load cases that have times."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from springopt.effects.compile import announce_compilation
from springopt.effects.lanes import LANE_COUNT
from springopt.errors import UserError
from springopt.forward.batch import Group
from springopt.forward.counter import make_counter
from springopt.forward.motion.lanes import follow_motions
from springopt.forward.motion.sparse import MotionSearch
from springopt.forward.motion.state import MotionAnswers, MotionJobs, Options, make_motion
from springopt.forward.motion.stepping import ENERGY_MOMENTUM, Stepping
from springopt.forward.plan import ways_of
from springopt.forward.sparse import SparseEngine, candidates_of
from springopt.forward.threads import run_all

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Motions:
    """Answers for m candidates and c load cases with t times each."""

    displacements: Floats  #: [length], shape (m, c, t, n d)
    velocities: Floats  #: [length / time], shape (m, c, t, n d)
    codes: NDArray[np.int8]  #: see `status`, shape (m, c)
    residuals: Floats  #: largest out-of-balance force of any step, shape (m, c)
    steps: NDArray[np.int64]  #: taken in time, shape (m, c)
    is_euler: NDArray[np.bool_]  #: whether the step that ended at a time was one of implicit Euler, shape (m, c, t)


def move(
    groups: Sequence[Group], candidates: Floats, stepping: Stepping, *, tolerance: float, threads: int = 1
) -> Motions:
    """The motions of all candidates, (m, s) or with parameters (m, s + f), from rest at time 0.

    Raises UserError for a free node without mass where the integrator can't do without.
    """
    terms = groups[0].terms
    rows = terms.rows(candidates)
    masses = terms.masses(rows[:, terms.lattice.spring_count :])
    shape = (len(rows), sum(len(group.cases) for group in groups), groups[0].times.shape[1], terms.lattice.nodes.size)
    motions = Motions(
        displacements=np.zeros(shape),
        velocities=np.zeros(shape),
        codes=np.zeros(shape[:2], dtype=np.int8),
        residuals=np.zeros(shape[:2]),
        steps=np.zeros(shape[:2], dtype=np.int64),
        is_euler=np.zeros(shape[:3], dtype=np.bool_),
    )
    for group in groups:
        _require_masses(group, masses, stepping)
        jobs = _jobs(group, rows, masses)
        with terms.failures_raised():
            answers = _follow(group, jobs, options_of(group, stepping, tolerance), threads)
        at = (jobs.candidate, group.cases[jobs.case])
        motions.displacements[at], motions.velocities[at] = answers.displacements, answers.velocities
        motions.codes[at], motions.residuals[at], motions.steps[at] = answers.codes, answers.residuals, answers.steps
        motions.is_euler[at] = answers.is_euler
    return motions


def options_of(group: Group, stepping: Stepping, tolerance: float) -> Options:
    """What the kernels need to know of the time steps."""
    return Options(
        step=float(stepping.step),
        is_midpoint=stepping.integrator == ENERGY_MOMENTUM,
        allowed=0.0 if stepping.step_error is None else float(stepping.step_error) * group.plan.step_limit,
        tolerance=tolerance,
    )


def _require_masses(group: Group, masses: Floats, stepping: Stepping) -> None:
    free = group.plan.block_of >= 0
    if stepping.integrator == ENERGY_MOMENTUM and (masses[:, free] <= 0.0).any():
        node = np.flatnonzero(free & (masses <= 0.0).any(axis=0))[0]
        raise UserError(
            f"node {node} moves and has no mass, which the energy-momentum integrator can't follow; give every free "
            "node a mass, or choose integrator = 'l-stable'."
        )


def _jobs(group: Group, rows: Floats, masses: Floats) -> MotionJobs:
    candidates, cases = np.divmod(np.arange(len(rows) * len(group.cases)), len(group.cases))
    return MotionJobs(
        candidate=candidates,
        case=cases,
        candidates=np.ascontiguousarray(rows),
        masses=np.ascontiguousarray(masses),
        forces=group.forces,
        prescribed=group.prescribed,
        times=group.times,
        taken=make_counter(),
    )


def _follow(group: Group, jobs: MotionJobs, options: Options, threads: int) -> MotionAnswers:
    shape = (len(jobs.case), group.times.shape[1], group.plan.nodes.size)
    answers = MotionAnswers(
        displacements=np.zeros(shape),
        velocities=np.zeros(shape),
        codes=np.zeros(shape[0], dtype=np.int8),
        residuals=np.zeros(shape[0]),
        steps=np.zeros(shape[0], dtype=np.int64),
        is_euler=np.zeros(shape[:2], dtype=np.bool_),
    )
    follow = _follow_large if isinstance(group.engine, SparseEngine) else _follow_small
    task = partial(follow, group, jobs, answers, options)
    try:
        run_all([task] * min(threads, 1 + shape[0] // LANE_COUNT), threads)
    except BaseException:  # the other threads find nothing more to do
        jobs.taken[0] = shape[0]
        raise
    return answers


def _follow_small(group: Group, jobs: MotionJobs, answers: MotionAnswers, options: Options) -> None:
    announce_compilation(follow_motions)
    ways = ways_of(group.plan, group.terms, is_midpoint=options.is_midpoint)
    follow_motions(group.plan, jobs, make_motion(group.plan), answers, options, ways)


def _follow_large(group: Group, jobs: MotionJobs, answers: MotionAnswers, options: Options) -> None:
    assert isinstance(group.engine, SparseEngine)
    search = MotionSearch.of(group.plan, group.engine.solver)
    ways = ways_of(group.plan, group.terms, is_midpoint=options.is_midpoint)
    for few in candidates_of(jobs.candidate, jobs.taken):
        search.run(jobs.part(few), answers.part(few), options, ways)
