"""One large system at a time: the load cases of a candidate side by side, and factors where they pay.

The search is that of `newton`, with the same judges. A Newton system is solved by conjugate gradients, preconditioned
by one factor of the tangent at rest that all load cases of a candidate share; where a tangent curves down, or its
system stays unsolved, the exact factor with replaced pivots gives the direction, as in `newton`. Every answer is
certified by the exact factor of its tangent, or by what the solver has in its place.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springopt.effects.compile import announce_compilation
from springopt.effects.lanes import LANE_COUNT
from springopt.errors import NoEquilibrium
from springopt.forward.certificate import SADDLE, certify_direction
from springopt.forward.conjugate_gradients import solve_lanes
from springopt.forward.counter import draw
from springopt.forward.courses import measure_direction
from springopt.forward.engine import ITERATION_LIMIT
from springopt.forward.lane_factors import RIGID
from springopt.forward.plan import Plan
from springopt.forward.queue import USUAL_REPLACEMENT
from springopt.forward.solver import Solver
from springopt.forward.sparse_kernels import aim, arrive, depart
from springopt.forward.state import (
    ACCEPTED,
    CERTIFYING,
    IDLE,
    JOB,
    PHASE,
    RELAXING,
    REPLACEMENT,
    VERDICT,
    Answers,
    Jobs,
)
from springopt.forward.status import CONVERGED, UNDERDETERMINED
from springopt.forward.workspace import Workspace

Floats = NDArray[np.float64]

# How far conjugate gradients reduce the preconditioned residual of a Newton system, and that of an adjoint one.
REDUCTION = 1e-3
ADJOINT_REDUCTION = 1e-12


@dataclass(frozen=True, eq=False)
class SparseEngine:
    """Equilibria of large systems, with one solver."""

    plan: Plan
    solver: Solver

    def find(self, jobs: Jobs, answers: Answers, tolerance: float) -> None:
        """See `Engine`."""
        announce_compilation(arrive)
        search = Search.of(self.plan, self.solver)
        for few in candidates_of(jobs.candidate, jobs.taken):
            search.run(jobs.part(few), answers.part(few), tolerance)

    def factorize(self, candidate: Floats, displacements: Floats) -> "SparseFactors":
        """See `Engine`."""
        search = Search.of(self.plan, self.solver)
        if not self.solver.is_direct:
            search.factorize_rest(candidate)
        return SparseFactors([search.at(candidate, u) for u in displacements])


def candidates_of(candidate: NDArray[np.int64], taken: NDArray[np.int64]) -> Iterator[slice]:
    """The jobs of one candidate (jobs,) after the other, as long as no thread has taken them."""
    edges = np.flatnonzero(np.diff(candidate, prepend=-1, append=-1)).tolist()
    while (number := draw(taken, len(edges) - 1)) >= 0:
        yield slice(edges[number], edges[number + 1])


@dataclass(frozen=True, eq=False)
class Search:
    """The search for all equilibria of one candidate, and linear systems with its tangents."""

    work: Workspace
    solver: Solver
    exact: Any  #: a `Matrix`, for exact factors
    at_rest: Any  #: a `Matrix`, which preconditions

    @classmethod
    def of(cls, plan: Plan, solver: Solver) -> "Search":
        return cls(Workspace.of(plan), solver, *solver.matrices())

    def run(self, jobs: Jobs, answers: Answers, tolerance: float) -> None:
        """Answer all jobs, which are those of one candidate."""
        plan, state = self.work.plan, self.work.state
        self.factorize_rest(jobs.candidates[jobs.candidate[0]])
        while arrive(plan, jobs, state, self.work.tangents, answers, tolerance, ITERATION_LIMIT):
            self._find_directions(tolerance)
            depart(plan, state, answers)

    def factorize_rest(self, candidate: Floats) -> None:
        """The preconditioner, scaled by a power of two into the range of single precision."""
        work = self.work
        work.evaluate_rest(candidate)
        weight = 2.0 ** -np.round(np.log2(work.state.scale.max(initial=1e-300)))
        work.fill(self.at_rest, self.solver.layout, 0, weight)
        self.at_rest.factorize(USUAL_REPLACEMENT)

    def factorize(self, lane: int, replacement: float) -> None:
        """The exact factor of the tangent of one lane."""
        self.work.fill(self.exact, self.solver.layout, lane)
        self.exact.factorize(replacement)

    def at(self, candidate: Floats, displacements: Floats) -> "Search":
        """Another one whose tangents are all that at these displacements (n d,), factorized; with what it can share."""
        if self.solver.is_direct:
            other = replace(self, exact=self.solver.matrices()[0])
        else:
            other = replace(self, work=Workspace.of(self.work.plan))
        other.work.evaluate(candidate, displacements[None])
        if self.solver.is_direct:
            other.factorize(0, RIGID)
        return other

    def solve_equal_tangents(self, sides: Floats) -> Floats:
        """The same for the tangent that was factorized last, which all lanes share."""
        if self.solver.is_direct:
            return self.exact.solve(sides)
        return self._iterate(sides, (sides != 0.0).any(axis=0), ADJOINT_REDUCTION)[0]

    def solve_surely(self, sides: Floats) -> Floats:
        """As `solve_equal_tangents`; nodes without springs stay at rest, what stays unsolved raises NoEquilibrium."""
        if self.solver.is_direct:
            return self.exact.solve(sides)
        sides[self.work.loose_unknowns()] = 0.0
        is_wanted = (sides != 0.0).any(axis=0)
        solution, is_solved = self._iterate(sides, is_wanted, ADJOINT_REDUCTION)
        if not is_solved[is_wanted].all():
            raise NoEquilibrium(
                "Derivatives of a state with free modes are beyond the iterative engine; give the springs that hold "
                "them a stiffness, or choose engine = 'sparse'."
            )
        return solution

    def _iterate(
        self, sides: Floats, is_wanted: NDArray[np.bool_], reduction: float
    ) -> tuple[Floats, NDArray[np.bool_]]:
        return solve_lanes(
            self.work.multiply,
            self._precondition,
            sides,
            is_wanted,
            scale=self.work.state.scale,
            reduction=reduction,
            limit=self.solver.product_limit,
        )

    def _precondition(self, sides: Floats) -> Floats:
        _, exponents = np.frexp(np.abs(sides).max(axis=0, initial=0.0))
        return np.ldexp(self.at_rest.solve(np.ldexp(sides, -exponents)), exponents)

    def _find_directions(self, tolerance: float) -> None:
        """Newton directions where the trial state was accepted or is relaxed; verdicts, and ways down from saddles."""
        state = self.work.state
        is_under_way = state.scalars[JOB] != IDLE
        is_accepted = is_under_way & (state.scalars[ACCEPTED] == 1.0)
        is_relaxing = is_under_way & (state.scalars[PHASE] == RELAXING) & ~is_accepted
        is_moving = is_relaxing | (is_accepted & (state.scalars[PHASE] != CERTIFYING))
        if is_moving.any():
            self._solve_newton(is_moving)
        aim(self.work.plan, state, tolerance)
        for lane in np.flatnonzero(is_accepted & (state.scalars[PHASE] == CERTIFYING)).tolist():
            self._certify(lane)

    def _solve_newton(self, is_moving: NDArray[np.bool_]) -> None:
        state = self.work.state
        solution, is_solved = self._iterate(state.unknowns, is_moving, REDUCTION)
        state.inertia[:, is_moving] = 0.0
        for lane in np.flatnonzero(is_moving & ~is_solved).tolist():
            if self.solver.is_direct:
                self.factorize(lane, state.scalars[REPLACEMENT, lane])
                state.inertia[:2, lane] = self.exact.inertia[:2]
                solution[:, lane] = self.exact.solve(state.unknowns[:, lane : lane + 1])[:, 0]
            elif not solution[:, lane].any():
                # The first direction curves down: follow it. Else what was solved until one did is a way down.
                side = state.unknowns[:, lane]
                solution[:, lane] = self._precondition(side[:, None])[:, 0]
                if not side @ solution[:, lane] > 0.0:  # an effect curves down at rest, and so does what preconditions
                    solution[:, lane] = side / state.scale[:, lane]
        state.unknowns[:] = solution

    def _certify(self, lane: int) -> None:
        """The verdict on the state of one lane, as in `certificate`, with the most negative pivot for all."""
        state, plan = self.work.state, self.work.plan
        self.factorize(lane, state.scalars[REPLACEMENT, lane])
        negative_count, zero_count = self.exact.inertia[:2]
        state.inertia[:2, lane] = negative_count, zero_count
        state.direction[:, lane] = self.exact.solve(state.residual[:, lane : lane + 1])[:, 0]
        measure_direction(state, lane)
        if not negative_count:
            state.scalars[VERDICT, lane] = UNDERDETERMINED if zero_count else CONVERGED
            return
        state.unknowns[:, lane] = self.exact.negative_direction()
        curvature = float(state.unknowns[:, lane] @ self.work.multiply(state.unknowns)[:, lane])
        state.scalars[VERDICT, lane] = certify_direction(plan, state, lane, curvature)
        if state.scalars[VERDICT, lane] == SADDLE:
            state.direction[:, lane] = state.unknowns[:, lane]
            measure_direction(state, lane)


@dataclass(frozen=True, eq=False)
class SparseFactors:
    """The tangent of each load case."""

    searches: Sequence[Search]

    def solve(self, loads: Floats) -> Floats:
        """See `Factors`; eight right-hand sides at a time. Raises NoEquilibrium where iterations do not solve them."""
        answers = np.empty(loads.shape)
        at_nodes = np.empty((loads.shape[2], LANE_COUNT))
        for case, search in enumerate(self.searches):
            for begin in range(0, loads.shape[1], LANE_COUNT):
                few = slice(begin, begin + LANE_COUNT)
                solution = search.solve_surely(search.work.gather(loads[case, few]))
                search.work.spread_out(solution, at_nodes)
                answers[case, few] = at_nodes.T[: len(answers[case, few])]
        return answers
