"""Motion of one large system at a time, its load cases side by side.

The steps are those of `motion.steps`. Newton systems are solved by conjugate gradients, preconditioned by one factor
at rest that all load cases of a candidate share, inertia included; what stays unsolved gets a factor of its own.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springopt.effects.compile import compiled
from springopt.effects.lanes import absolute, fma, load, maximum, splat, store
from springopt.effects.springs import elongation, tension_per_length
from springopt.forward.conjugate_gradients import solve_lanes
from springopt.forward.motion.evaluation import add_effects, balance, between, follow_trial
from springopt.forward.motion.state import (
    ENERGY,
    IS_FRESH,
    JOB,
    POTENTIAL,
    Motion,
    MotionAnswers,
    MotionJobs,
    Options,
    make_motion,
)
from springopt.forward.motion.steps import GAMMA, judge_motions, step_on, take_up_motions
from springopt.forward.plan import Plan, Ways
from springopt.forward.solver import Solver
from springopt.forward.sparse import REDUCTION
from springopt.forward.state import IDLE
from springopt.forward.workspace import Workspace

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MotionSearch:
    """The motions of one candidate; made for each call of an engine."""

    work: Workspace
    motion: Motion
    solver: Solver
    exact: Any
    at_rest: Any

    @classmethod
    def of(cls, plan: Plan, solver: Solver) -> "MotionSearch":
        work, motion = Workspace.of(plan, in_motion=True), make_motion(plan._replace(block_count=0))
        # What products and matrices of the tangent are made from is the same array for both.
        state = work.state
        motion = motion._replace(at=state.trial, stiffness=state.stiffness, values=state.values, scale=state.scale)
        return cls(work, motion, solver, *solver.matrices())

    def run(self, jobs: MotionJobs, answers: MotionAnswers, options: Options, ways: Ways) -> None:
        """Answer all jobs, which are those of one candidate."""
        plan, motion = self.work.plan, self.motion
        self._factorize_rest(jobs, options)
        while take_up_motions(plan, jobs, motion, options):
            _evaluate(plan, motion, ways, self.work.tangents, options.is_midpoint)
            if judge_motions(plan, jobs, motion, answers, options):
                self._solve((motion.scalars[IS_FRESH] == 0.0) & (motion.scalars[JOB] != IDLE))
                step_on(plan, motion)

    def _factorize_rest(self, jobs: MotionJobs, options: Options) -> None:
        work, plan = self.work, self.work.plan
        candidate = jobs.candidate[0]
        work.evaluate_rest(jobs.candidates[candidate])
        share = 0.5 if options.is_midpoint else 1.0
        stiff = 2.0 / options.step**2 if options.is_midpoint else (GAMMA * options.step) ** -2
        by_axis = np.repeat(jobs.masses[candidate][:, None], plan.dimension, axis=1)
        diagonal = stiff * work.gather(by_axis.reshape(1, -1))[:, 0]
        weight = 2.0 ** -np.round(np.log2((work.state.scale[:, 0] + diagonal).max(initial=1e-300)))
        work.fill(self.at_rest, self.solver.layout, 0, weight * share)
        self._add_diagonal(self.at_rest, weight * diagonal)
        self.at_rest.factorize(1.0)

    def _add_diagonal(self, matrix: Any, diagonal: Floats) -> None:
        matrix.entries[self.solver.layout.diagonal] += diagonal.astype(matrix.entries.dtype)
        matrix.scale[: len(diagonal)] += diagonal

    def _solve(self, is_wanted: NDArray[np.bool_]) -> None:
        motion = self.motion
        solution, is_solved = solve_lanes(
            self._multiply,
            self._precondition,
            motion.unknowns,
            is_wanted,
            scale=motion.scale,
            reduction=REDUCTION,
            limit=self.solver.product_limit,
        )
        for lane in np.flatnonzero(is_wanted & ~is_solved).tolist() if self.solver.is_direct else ():
            self.work.fill(self.exact, self.solver.layout, lane)
            self._add_diagonal(self.exact, motion.diagonal[:, lane])
            self.exact.factorize(1.0)
            solution[:, lane] = self.exact.solve(motion.unknowns[:, lane : lane + 1])[:, 0]
        motion.unknowns[:] = solution

    def _multiply(self, p: Floats) -> Floats:
        product = self.work.multiply(p) + self.motion.diagonal * p
        product[self.work.plan.pinned] = 0.0
        return product

    def _precondition(self, sides: Floats) -> Floats:
        _, exponents = np.frexp(np.abs(sides).max(axis=0, initial=0.0))
        return np.ldexp(self.at_rest.solve(np.ldexp(sides, -exponents)), exponents)


@compiled
def _evaluate(plan: Any, motion: Any, ways: Any, tangents: Any, is_midpoint: bool) -> None:
    """As `evaluate_motion`, with the tangent as in `sparse_kernels`."""
    d, internal, cache, delta = plan.dimension, motion.internal, tangents.cache, motion.delta
    follow_trial(motion, is_midpoint)
    internal[:] = 0.0
    store(motion.scalars, ENERGY, splat(0.0))
    tangents.coupled[:] = 0.0
    places = (ways[0].coupled_places, ways[2].coupled_places)
    add_effects(plan, motion, ways, tangents.coupled, places, is_midpoint)
    energy = load(motion.scalars, POTENTIAL)
    for spring in range(len(plan.ends)):
        i, j = plan.ends[spring, 0] * d, plan.ends[spring, 1] * d
        if is_midpoint:
            tension, axial = between(plan, motion, spring)
            store(cache, 2 * spring, tension * 0.5)
            store(cache, 2 * spring + 1, axial * 0.5)
        else:
            natural, k = plan.natural_lengths[spring], load(motion.stiffness, spring)
            rest, prestrain = plan.lengths[spring], plan.prestrains[spring]
            length, longer = elongation(motion.trial, i, j, plan.rest_vectors, spring, rest, natural, prestrain, delta)
            energy = fma(k * longer, longer * 0.5, energy)
            tension, length = tension_per_length(k, natural, length, longer)
            store(cache, 2 * spring, tension)
            store(cache, 2 * spring + 1, (k - tension) / (length * length))
        for a in range(d):
            force = tension * load(delta, a)
            store(internal, j + a, load(internal, j + a) + force)
            store(internal, i + a, load(internal, i + a) - force)
    store(motion.scalars, POTENTIAL, energy)
    balance(plan, motion)
    _scale(plan, motion, tangents.coupled)


@compiled
def _scale(plan: Any, motion: Any, coupled: Any) -> None:
    """What pivots are judged by: springs, inertia and effects."""
    d = plan.dimension
    for at in range(len(motion.scale)):
        store(motion.scale, at, load(motion.meeting, at) + load(motion.diagonal, at))
    for block in range(len(plan.coupled)):
        row, column = plan.coupled[block]
        if row == column:
            for a in range(d):
                at = row * d + a
                stands = maximum(absolute(load(coupled, block * d * d + a * d + a)), splat(0.0))
                store(motion.scale, at, load(motion.scale, at) + stands)
