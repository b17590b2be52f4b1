"""One large system at a time: the load cases of a candidate side by side, and factors where they pay.

The search is that of `newton`, with the same judges. A Newton system is solved by conjugate gradients, preconditioned
by one factor of the tangent at rest that all load cases of a candidate share; where a tangent curves down, or its
system stays unsolved, the exact factor with replaced pivots gives the direction, as in `newton`. Every answer is
certified by the exact factor of its tangent.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from springopt.effects.compile import announce_compilation
from springopt.effects.lanes import LANE_COUNT
from springopt.forward.conjugate_gradients import solve_lanes
from springopt.forward.engine import ITERATION_LIMIT
from springopt.forward.layout import Layout, lay_out
from springopt.forward.matrix import Matrix
from springopt.forward.newton import CERTIFYING, PIVOT_REPLACEMENT, measure_direction, take_directions
from springopt.forward.plan import Plan
from springopt.forward.sparse_kernels import arrive, depart
from springopt.forward.state import ACCEPTED, IDLE, JOB, PHASE, Answers, Jobs
from springopt.forward.workspace import Workspace

Floats = NDArray[np.float64]

# How far conjugate gradients reduce the preconditioned residual of a Newton system.
REDUCTION = 1e-3
# After so many products a load case is better served by a factor of its own.
PRODUCT_LIMIT = 25


@dataclass(frozen=True, eq=False)
class SparseEngine:
    """Equilibria of large systems, with one kind of factor."""

    plan: Plan

    @cached_property
    def width(self) -> int:
        """The half-bandwidth of the tangent."""
        widest = int((np.arange(len(self.plan.first)) - self.plan.first).max(initial=0))
        return widest * self.plan.dimension + self.plan.dimension - 1

    @property
    def unknown_count(self) -> int:
        return len(self.plan.first) * self.plan.dimension

    @cached_property
    def layout(self) -> Layout:
        from springopt.forward.band import Band

        stride = Band.stride_of(self.width)
        return lay_out(self.plan, lambda row, column: column * stride + row)

    def matrix(self, kind: type) -> Matrix:
        from springopt.forward.band import Band

        return Band.empty(self.unknown_count, self.width, kind)

    def find(self, jobs: Jobs, answers: Answers, tolerance: float) -> None:
        """See `Engine`."""
        announce_compilation(arrive)
        search = Search(self.layout, Workspace.of(self.plan), self.matrix(np.float64), self.matrix(np.float32))
        for begin, end in _candidates(jobs):
            few = jobs._replace(candidate=jobs.candidate[begin:end], case=jobs.case[begin:end])
            search.run(few, Answers(*(answer[begin:end] for answer in answers)), tolerance)


def _candidates(jobs: Jobs) -> Iterator[tuple[int, int]]:
    """The ranges of the jobs of one candidate each."""
    edges = np.flatnonzero(np.diff(jobs.candidate, prepend=-1, append=-1))
    yield from zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)


@dataclass(frozen=True, eq=False)
class Search:
    """The search for all equilibria of one candidate."""

    layout: Layout
    work: Workspace
    exact: Matrix
    at_rest: Matrix

    def run(self, jobs: Jobs, answers: Answers, tolerance: float) -> None:
        """Answer all jobs, which are those of one candidate."""
        plan, state = self.work.plan, self.work.state
        self._factorize_rest(jobs.stiffness[jobs.candidate[0]])
        waiting = 0
        while True:
            waiting = arrive(plan, jobs, state, self.work.tangents, answers, waiting, tolerance, ITERATION_LIMIT)
            if state.scalars[JOB].max() == IDLE and waiting == len(jobs.case):
                return
            self._find_directions()
            depart(plan, state, answers)

    def _factorize_rest(self, stiffness: Floats) -> None:
        """The preconditioner, scaled by a power of two into the range of single precision."""
        work = self.work
        work.evaluate(stiffness, np.zeros((1, work.plan.nodes.size)))
        weight = 2.0 ** -np.round(np.log2(work.state.scale.max(initial=1e-300)))
        work.fill(self.at_rest, self.layout, 0, weight)
        self.at_rest.factorize(PIVOT_REPLACEMENT)

    def _precondition(self, sides: Floats) -> Floats:
        _, exponents = np.frexp(np.abs(sides).max(axis=0))
        return np.ldexp(self.at_rest.solve(np.ldexp(sides, -exponents)), exponents)

    def _find_directions(self) -> None:
        """Newton directions where the trial state was accepted, downwards from a saddle where one was found."""
        state = self.work.state
        is_accepted = (state.scalars[JOB] != IDLE) & (state.scalars[ACCEPTED] == 1.0)
        is_certifying = is_accepted & (state.scalars[PHASE] == CERTIFYING)
        is_stepping = is_accepted & ~is_certifying
        if is_stepping.any():
            self._solve_newton(is_stepping)
        take_directions(state)
        for lane in np.flatnonzero(is_certifying).tolist():
            self._factorize(lane)
            if self.exact.inertia[0] > 0:
                state.direction[:, lane] = self.exact.negative_direction()
                measure_direction(state, lane)

    def _solve_newton(self, is_stepping: NDArray[np.bool_]) -> None:
        state = self.work.state
        solution, is_solved = solve_lanes(
            self.work.multiply,
            self._precondition,
            state.residual,
            is_stepping,
            scale=state.scale,
            reduction=REDUCTION,
            limit=PRODUCT_LIMIT,
        )
        for lane in np.flatnonzero(is_stepping & ~is_solved).tolist():
            self._factorize(lane)
            solution[:, lane] = self.exact.solve(state.residual[:, lane : lane + 1])[:, 0]
        state.unknowns[:] = solution

    def _factorize(self, lane: int) -> None:
        self.work.fill(self.exact, self.layout, lane)
        self.exact.factorize(PIVOT_REPLACEMENT)
        self.work.state.inertia[:, lane] = self.exact.inertia
