"""Small displacements: K u = f with the tangent at rest, one factor for all load cases of a candidate.

The energy is its second-order expansion at rest, prestress and nonlinear effects included: with prestrain the forces at
rest are on the right-hand side, and the tangent carries their geometric part. A load on a mode that has no stiffness at
rest has no small answer: a mechanism, whatever larger displacements would do.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from springopt.effects.compile import announce_compilation
from springopt.effects.lanes import LANE_COUNT
from springopt.forward.lane_factors import RIGID
from springopt.forward.plan import Plan
from springopt.forward.solver import Solver
from springopt.forward.sparse import Search, candidates_of
from springopt.forward.sparse_kernels import evaluate_forces
from springopt.forward.state import ENERGY, EPSILON, Answers, Jobs
from springopt.forward.status import CONVERGED, ITERATION_LIMIT, MECHANISM, UNDERDETERMINED, UNSTABLE
from springopt.forward.workspace import Workspace

Floats = NDArray[np.float64]

# What a zero pivot becomes, in relation to its scale, where its mode is sought.
SOFT = 1e-8


@dataclass(frozen=True, eq=False)
class LinearEngine:
    """Solutions for small displacements, with one solver."""

    plan: Plan
    whole: Plan  #: the same without any support: its products tell reactions and what moved supports do
    solver: Solver

    def find(self, jobs: Jobs, answers: Answers, tolerance: float) -> None:
        """See `Engine`; an answer takes one iteration."""
        announce_compilation(evaluate_forces)
        system = _System.of(self)
        for all_cases in candidates_of(jobs.candidate, jobs.taken):
            system.factorize(jobs.candidates[jobs.candidate[all_cases.start]])
            for few in _eights(all_cases.start, all_cases.stop):
                forces, prescribed = jobs.forces[jobs.case[few]], jobs.start[few]
                system.answer(forces, prescribed, answers.part(few), tolerance)

    def factorize(self, candidate: Floats, displacements: Floats) -> "EqualFactors":
        """See `Engine`; one factor serves all load cases."""
        system = _System.of(self)
        system.factorize(candidate)
        return EqualFactors(system)


@dataclass(frozen=True, eq=False)
class EqualFactors:
    """The tangent that all load cases share."""

    system: "_System"

    def solve(self, loads: Floats) -> Floats:
        """See `Factors`."""
        flat = loads.reshape(-1, loads.shape[2])
        answers = np.empty(flat.shape)
        for few in _eights(0, len(flat)):
            answers[few] = self.system.solve(flat[few], surely=True)
        return answers.reshape(loads.shape)


def _eights(begin: int, end: int) -> list[slice]:
    return [slice(first, min(first + LANE_COUNT, end)) for first in range(begin, end, LANE_COUNT)]


@dataclass(eq=False)
class _System:
    """The linear system of one candidate; factorized again for the next one."""

    search: Search
    whole: Workspace
    null: Floats | None = None  #: orthonormal modes without stiffness, shape (B d, modes), where there are any

    @classmethod
    def of(cls, engine: LinearEngine) -> "_System":
        return cls(Search.of(engine.plan, engine.solver), Workspace.of(engine.whole))

    def factorize(self, candidate: Floats) -> None:
        """The factor at rest, and the forces there."""
        rest = np.zeros((1, self.whole.plan.nodes.size))
        self.whole.evaluate(candidate, rest)
        if not self.search.solver.is_direct:
            self.search.factorize_rest(candidate)
        self.search.work.evaluate(candidate, rest)
        self.search.factorize(0, RIGID)
        self.null = self._null_modes() if self.search.solver.is_direct else None

    def _null_modes(self) -> Floats | None:
        """By inverse iteration with a factor whose zero pivots became small ones."""
        negative_count, zero_count = self.search.exact.inertia[:2].astype(int)
        is_loose = self.search.work.loose_unknowns()  # at rest as they are
        is_loose[self.search.work.plan.pinned] = False
        zero_count -= np.count_nonzero(is_loose)
        if negative_count or zero_count <= 0:
            return None
        soft = replace(self.search, exact=self.search.solver.matrices()[0])
        soft.factorize(0, SOFT)
        modes = np.random.default_rng(0).standard_normal((len(self.search.work.state.unknowns), zero_count))
        modes[self.search.work.plan.pinned] = 0.0
        modes[is_loose] = 0.0
        for _ in range(3):
            for few in _eights(0, zero_count):
                modes[:, few] = soft.exact.solve(np.ascontiguousarray(modes[:, few]))
            modes = np.linalg.qr(modes)[0]
        return modes

    def solve(self, loads: Floats, *, surely: bool) -> Floats:
        """K^+ of up to eight loads (c, n d), of all solutions the shortest: free modes are kept at rest.

        What iterations leave unsolved raises NoEquilibrium, or else the caller judges.
        """
        solver = self.search.solve_surely if surely else self.search.solve_equal_tangents
        solution = solver(self._without_null(self.search.work.gather(loads)))
        return self._at_nodes(self._without_null(solution))[: len(loads)]

    def _without_null(self, unknowns: Floats) -> Floats:
        return unknowns if self.null is None else unknowns - self.null @ (self.null.T @ unknowns)

    def answer(self, forces: Floats, prescribed: Floats, answers: Answers, tolerance: float) -> None:
        """Displacements, status, residual and energy for up to eight load cases, forces (c, n d)."""
        state = self.whole.state
        at_rest = state.internal[:, 0].copy()  # the forces of prestress
        u = prescribed.copy()
        for _ in range(2):  # the second time takes the rounding of the first one out
            u += self.solve(forces - at_rest - self._stiffness_times(u), surely=False)
        pushed = self._stiffness_times(u)
        out_of_balance = forces - at_rest - pushed
        answers.displacements[:] = u
        answers.residuals[:] = np.abs(self.search.work.gather(out_of_balance)).max(axis=0, initial=0.0)[: len(u)]
        answers.energies[:] = state.scalars[ENERGY, 0] + (u * (at_rest + 0.5 * pushed - forces)).sum(axis=1)
        answers.iterations[:] = 1
        scale = np.abs(forces).max(axis=1, initial=0.0)
        reactions = np.abs(out_of_balance[:, self.search.work.plan.supported])
        scale = np.maximum(scale, reactions.max(axis=1, initial=0.0))
        prestress = (state.stiffness[:, 0] * np.abs(self.whole.plan.prestrains)).max(initial=0.0)
        wanted = tolerance * np.maximum(scale, prestress)
        answers.codes[:] = self._statuses(answers.residuals <= np.maximum(wanted, self._rounding(u)))

    def _statuses(self, is_balanced: NDArray[np.bool_]) -> NDArray[np.int64]:
        negative_count, zero_count = self.search.exact.inertia[:2]
        if negative_count:
            return np.full(len(is_balanced), UNSTABLE)
        if zero_count:
            return np.where(is_balanced, UNDERDETERMINED, MECHANISM)
        return np.where(is_balanced, CONVERGED, ITERATION_LIMIT)

    def _rounding(self, u: Floats) -> Floats:
        """The largest residual that rounding of the displacements alone can leave, as in `newton`."""
        plan = self.whole.plan
        by_node = np.abs(u).reshape(len(u), len(plan.nodes), -1).sum(axis=2)
        reach = by_node[:, plan.ends].sum(axis=2) + np.abs(plan.prestrains)
        forces = self.whole.state.stiffness[:, 0] * reach
        at_node = [np.bincount(plan.ends.ravel(), np.repeat(force, 2)).max(initial=0.0) for force in forces]
        return 4.0 * EPSILON * np.array(at_node)

    def _stiffness_times(self, u: Floats) -> Floats:
        """K u with the rows and columns of the supports, shape (c, n d)."""
        work = self.whole
        product = work.multiply(work.gather(u))
        at_nodes = np.empty((work.plan.nodes.size, LANE_COUNT))
        work.spread_out(product, at_nodes)
        return at_nodes.T[: len(u)]

    def _at_nodes(self, unknowns: Floats) -> Floats:
        at_nodes = np.empty((self.whole.plan.nodes.size, LANE_COUNT))
        self.search.work.spread_out(unknowns, at_nodes)
        return at_nodes.T
