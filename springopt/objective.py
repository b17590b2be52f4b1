"""The objective: the weighted sum of the training load cases' misfits, its gradient and its residuals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springopt.checks import (
    Floats,
    Integers,
    floats,
    require_finite,
    require_nonnegative,
    require_positive,
    require_shape,
)
from springopt.errors import NoEquilibrium, UserError, did_you_mean
from springopt.forward.batch import Equilibria, Group
from springopt.forward.derivatives import Linearization
from springopt.forward.motion.derivatives import MotionLinearization
from springopt.forward.motion.follow import Motions
from springopt.forward.rest_modes import zero_mode_shares
from springopt.forward.status import STATUSES, Status, has_equilibrium
from springopt.load_case import LoadCase
from springopt.misfit import MISFITS, Misfit
from springopt.model import TOLERANCE, Model, Solution
from springopt.parameters import Parameters
from springopt.reference import Reference

if TYPE_CHECKING:
    from scipy.sparse.linalg import LinearOperator

#: The cost cap, in misfits of a body whose every node is off by this many times its size.
CAP_SIZES = 100.0
#: Of a race: a set of supports with more than one in so many of the training load cases is split.
STAGES = 4


@dataclass(frozen=True)
class Evaluation:
    """What the objective says of m candidates."""

    values: Floats  #: never nan, shape (m,)
    codes: NDArray[np.int8]  #: the worst status over the training load cases, see `forward.status`, shape (m,)
    solves: int  #: equilibria that were sought


@dataclass(frozen=True)
class CaseError:
    """How far the model is from the reference in one load case."""

    name: str
    role: str
    distance: float  #: mean node distance [length]
    relative_distance: float  #: the same over the smallest rest length
    least_squares: float  #: half the sum of squared coordinate differences
    max_distance: float  #: of any node [length]
    status: Status


@dataclass(frozen=True, eq=False)
class Stage:
    """Training load cases with the same supports, which a race solves together; see `springopt.race`."""

    cases: Integers  #: their numbers among the training load cases, shape (c,)
    group: Group  #: of them alone


@dataclass(frozen=True, eq=False)
class Objective:
    """The distance of a model from reference positions, as a function of the stiffness (s,).

    Training load cases enter the value; test load cases are reported only.
    """

    model: Model
    cases: Sequence[LoadCase]
    reference_positions: Floats  #: [length], shape (c, n, d), or (c, t, n, d) where cases have times
    minimize: str = "distance"  #: "distance", "relative-distance" or "least-squares"
    weights: Floats | None = None  #: one for each load case; by default 1
    tolerance: float = TOLERANCE  #: of the forward solve
    #: The value of a candidate without an equilibrium, before its grading; values above it are cut down to it.
    cost_cap: float | None = None
    reference: Reference | None = None  #: what gave the positions, for those that learn from its material, too

    def __post_init__(self) -> None:
        self.model.require_what_times_need(self.cases)
        times = [() if case.times is None else (len(case.times),) for case in self.cases[:1]]
        shape = (len(self.cases), *(times[0] if times else ()), *self.model.lattice.nodes.shape)
        reference = require_shape("reference_positions", floats("reference_positions", self.reference_positions), shape)
        object.__setattr__(self, "reference_positions", require_finite("reference_positions", reference))
        if self.minimize not in MISFITS:
            names = ", ".join(MISFITS)
            raise UserError(
                f"minimize must be one of {names}, not {self.minimize!r}.{did_you_mean(self.minimize, MISFITS)}"
            )
        if not len(self._training):
            raise UserError(
                "An objective needs at least one load case with the role 'train'; all have the role 'test'."
            )
        weights = np.ones(len(self.cases)) if self.weights is None else floats("weights", self.weights)
        require_shape("weights", require_nonnegative("weights", weights), (len(self.cases),))
        if not weights[self._training].any():
            raise UserError("the weights of all training load cases are 0, so that nothing is minimized; raise one.")
        object.__setattr__(self, "weights", weights)
        require_positive("tolerance", self.tolerance)
        cap = self._default_cap() if self.cost_cap is None else self.cost_cap
        object.__setattr__(self, "cost_cap", float(require_positive("cost_cap", cap)))

    def __getstate__(self) -> dict[str, object]:
        """Without the groups, which hold addresses of kernels in this process and are made again."""
        return {name: value for name, value in self.__dict__.items() if name not in ("_groups", "stages")}

    def evaluate(self, stiffness: ArrayLike | Parameters) -> Evaluation:
        """The values of many candidates (m, s), or `Parameters` of many.

        A candidate without an equilibrium in some training load case costs the cap times one plus the share of zero
        modes at rest among its unknowns, averaged over the load cases: a spring that stiffens it makes it cheaper.
        """
        if isinstance(stiffness, Parameters):
            return self.fitting(stiffness).evaluate(stiffness.rows())
        candidates = self.model.candidates(stiffness, axes=2)[1]
        misfits, codes = self.misfits(candidates)
        return Evaluation(self.values(candidates, misfits, codes), codes.max(axis=1), codes.size)

    @cached_property
    def stages(self) -> tuple[Stage, ...]:
        """The training load cases in the parts that a race solves one after the other, each with the same supports."""
        # Small displacements have one factor for all load cases of a candidate, which parts would make again.
        is_whole = self.model.kinematics == "linear"
        most = len(self._training) if is_whole else math.ceil(len(self._training) / STAGES)
        return tuple(
            Stage(group.cases[begin : begin + most], group.part(slice(begin, begin + most)))
            for group in self._groups
            for begin in range(0, len(group.cases), most)
        )

    def misfits(
        self, candidates: Floats, stage: Stage | None = None, tolerance: float | None = None
    ) -> tuple[Floats, NDArray[np.int8]]:
        """Misfits and statuses of checked candidates (m, s) in the c training load cases of a stage, shape (m, c).

        By default in all training load cases, with the objective's own tolerance.
        """
        groups = self._groups if stage is None else (stage.group,)
        equilibria = self.model.find(groups, candidates, self.tolerance if tolerance is None else tolerance)
        differences = self._differences(equilibria, slice(None) if stage is None else stage.cases)
        return self._misfit.value(differences, self.smallest_rest_length), equilibria.codes

    def bounds(self, misfits: Floats, codes: NDArray[np.int8]) -> Floats:
        """What candidates cost at least, (m,), by misfits and statuses (m, c); where not all are known yet, 0 each.

        With an equilibrium in all training load cases it is their value.
        """
        # No matrix product: BLAS rounds by the shape of the batch, and a value depends on its candidate alone.
        sums = np.minimum((misfits * self._training_weights).sum(axis=-1), self._cap)
        return np.where(has_equilibrium(codes).all(axis=1), sums, self._cap)

    def values(self, candidates: Floats, misfits: Floats, codes: NDArray[np.int8]) -> Floats:
        """The values (m,) of checked candidates (m, s) that have these misfits and statuses (m, c)."""
        values = self.bounds(misfits, codes)
        failed = np.flatnonzero(~has_equilibrium(codes).all(axis=1))
        if len(failed):
            springs = candidates[failed, : self.model.lattice.spring_count]
            values[failed] = self._cap * (1.0 + zero_mode_shares(self._groups, springs, codes[failed]))
        return values

    @overload
    def gradient(self, stiffness: ArrayLike) -> tuple[float, Floats]: ...
    @overload
    def gradient(self, stiffness: Parameters) -> tuple[float, Parameters]: ...
    def gradient(self, stiffness: ArrayLike | Parameters) -> tuple[float, Floats | Parameters]:
        """Value and gradient (s,) of one candidate (s,), by the adjoint method; raises NoEquilibrium.

        Of `Parameters` the gradient is one as well: of the stiffness, and of each parameter by its name.

        At an underdetermined state the position along a free mode is the search's, and no function of the stiffness:
        the derivatives take it as held by one coordinate. A node without springs stays at rest and does no harm.
        """
        if isinstance(stiffness, Parameters):
            value, gradient = self.fitting(stiffness).gradient(stiffness.rows()[0])
            return value, stiffness.like(gradient)
        candidate, equilibria = self._equilibrium(stiffness)
        differences = self._differences(equilibria)[0]
        value = self._total(differences)
        loads = self._misfit.gradient(differences, self.smallest_rest_length) * self._training_weights[:, None, None]
        derivatives = self._linearize(candidate, equilibria)
        return value, derivatives.against(loads.reshape(len(loads), -1))[self._columns(len(candidate))]

    def fitting(self, given: Parameters) -> Objective:
        """The objective of the model whose candidates differ in the parameters that are named here."""
        model = self.model.fitting(given)
        return self if model is self.model else replace(self, model=model)

    def residuals(self, stiffness: ArrayLike | Parameters) -> Floats:
        """The weighted coordinate differences (r,), whatever the misfit; half their squares' sum is the least squares.

        Flat from (training load cases, n, d). Raises NoEquilibrium.
        """
        if isinstance(stiffness, Parameters):
            return self.fitting(stiffness).residuals(stiffness.rows()[0])
        _, equilibria = self._equilibrium(stiffness)
        return (self._differences(equilibria)[0] * self._root_weights).ravel()

    def value_of(self, residuals: Floats) -> float:
        """The objective's value, in its own misfit, where it has these residuals (r,)."""
        roots = self._root_weights
        weighted = residuals.reshape(len(roots), -1, self.model.lattice.dimension)
        differences = np.divide(weighted, roots, out=np.zeros_like(weighted), where=roots > 0)
        return self._total(differences)

    def jacobian(self, stiffness: ArrayLike | Parameters) -> tuple[Floats, Floats]:
        """The residuals (r,) and their derivatives (r, s) with respect to the stiffness; raises NoEquilibrium.

        Of `Parameters` (r, s + f), as their rows have it.
        """
        if isinstance(stiffness, Parameters):
            return self.fitting(stiffness).jacobian(stiffness.rows()[0])
        candidate, equilibria = self._equilibrium(stiffness)
        differences = self._differences(equilibria)[0]
        derivatives = self._linearize(candidate, equilibria).jacobian()
        weights = self._root_weights
        derivatives *= weights
        by_row = derivatives.reshape(-1, derivatives.shape[-1])
        return (differences * weights).ravel(), by_row[:, self._columns(len(candidate))]

    def linearize(self, stiffness: ArrayLike | Parameters) -> tuple[Floats, LinearOperator]:
        """The residuals (r,) and their derivative as an operator (r, s), for Jacobians that are too large to store.

        Each product, also with the transpose, takes one solve for each load case, by factors that are made once.
        Raises NoEquilibrium.
        """
        from scipy.sparse.linalg import LinearOperator

        if isinstance(stiffness, Parameters):
            return self.fitting(stiffness).linearize(stiffness.rows()[0])
        candidate, equilibria = self._equilibrium(stiffness)
        derivatives, roots = self._linearize(candidate, equilibria), self._root_weights[:, 0]
        residuals = (self._differences(equilibria)[0] * self._root_weights).ravel()

        def along(change: Floats) -> Floats:
            whole = np.zeros(self.model.lattice.spring_count + len(self.model.terms.defaults))
            whole[self._columns(len(candidate))] = change.ravel()
            return (derivatives.along(whole) * roots).ravel()

        def against(loads: Floats) -> Floats:
            return derivatives.against(loads.reshape(len(roots), -1) * roots)[self._columns(len(candidate))]

        shape = (residuals.size, len(candidate))
        return residuals, LinearOperator(shape, matvec=along, rmatvec=against, dtype=float)

    def solution(self, stiffness: ArrayLike | Parameters) -> Solution:
        """The equilibria of one candidate in all load cases, training and test."""
        return self.model.solve(stiffness, self.cases, self.tolerance)

    def errors(self, stiffness: ArrayLike | Parameters) -> list[CaseError]:
        """The error of one candidate in each load case, training and test, in every definition."""
        solution = self.solution(stiffness)
        smallest = self.smallest_rest_length
        differences = solution.displacements - (self.reference_positions - self.model.lattice.nodes)
        differences = differences.reshape(len(self.cases), -1, self.model.lattice.dimension)  # in motion of all times
        return [
            CaseError(
                name=case.name,
                role=case.role,
                distance=float(MISFITS["distance"].value(difference, smallest)),
                relative_distance=float(MISFITS["relative-distance"].value(difference, smallest)),
                least_squares=float(MISFITS["least-squares"].value(difference, smallest)),
                max_distance=float(np.sqrt((difference**2).sum(axis=-1)).max()),
                status=status,
            )
            for case, difference, status in zip(self.cases, differences, solution.status, strict=True)
        ]

    @cached_property
    def smallest_rest_length(self) -> float:
        """The smallest positive rest length of the lattice, by which the paper divides its errors."""
        lengths = self.model.lattice.rest_lengths
        positive = lengths[lengths > 0]
        return float(positive.min()) if len(positive) else 1.0

    @cached_property
    def _training(self) -> NDArray[np.int64]:
        return np.flatnonzero([case.role == "train" for case in self.cases])

    @cached_property
    def _training_weights(self) -> Floats:
        assert self.weights is not None
        return self.weights[self._training]

    @cached_property
    def _root_weights(self) -> Floats:
        return np.sqrt(self._training_weights)[:, None, None]

    @property
    def _cap(self) -> float:
        assert self.cost_cap is not None
        return self.cost_cap

    @cached_property
    def _misfit(self) -> Misfit:
        return MISFITS[self.minimize]

    @cached_property
    def _groups(self) -> tuple[Group, ...]:
        return self.model.groups([self.cases[i] for i in self._training])

    @cached_property
    def _training_displacements(self) -> Floats:
        displacements = self.reference_positions[self._training] - self.model.lattice.nodes
        return displacements.reshape(len(self._training), -1)

    def _total(self, differences: Floats) -> float:
        """The value of one candidate at differences (c, n, d), as `evaluate` has it."""
        misfits = self._misfit.value(differences, self.smallest_rest_length)
        return min(float((misfits * self._training_weights).sum()), self._cap)

    def _default_cap(self) -> float:
        nodes = self.model.lattice.nodes
        size = float(np.linalg.norm(np.ptp(nodes, axis=0))) or 1.0
        off = np.zeros_like(self._training_displacements).reshape(len(self._training), -1, nodes.shape[1])
        off[..., 0] = CAP_SIZES * size
        return float(self._misfit.value(off, self.smallest_rest_length) @ self._training_weights)

    def _differences(self, answers: Equilibria | Motions, which: Integers | slice = slice(None)) -> Floats:
        """Model less reference in the training load cases, shape (m, c, n, d); in motion (m, c, t n, d).

        `which` of them were answered, if not all.
        """
        count, cases = answers.displacements.shape[:2]
        differences = answers.displacements.reshape(count, cases, -1) - self._training_displacements[which]
        return differences.reshape(count, cases, -1, self.model.lattice.dimension)

    def _columns(self, width: int) -> NDArray[np.int64]:
        """Where the numbers of a candidate (width,) are in its row, see `forward.terms`."""
        springs = self.model.lattice.spring_count
        columns = np.arange(springs)
        return columns if width == springs else np.concatenate([columns, springs + self.model.terms.fitted_columns])

    def _linearize(self, candidate: Floats, answers: Equilibria | Motions) -> Linearization | MotionLinearization:
        return self.model.linearize(self._groups, candidate, answers, self.tolerance)

    def _equilibrium(self, stiffness: ArrayLike) -> tuple[Floats, Equilibria | Motions]:
        candidates = self.model.candidates(stiffness, axes=1)[1]
        equilibria = self.model.find(self._groups, candidates, self.tolerance)
        failed = ~has_equilibrium(equilibria.codes[0])
        if failed.any():
            number = int(np.flatnonzero(failed)[0])
            name, status = self.cases[self._training[number]].name, STATUSES[equilibria.codes[0, number]]
            raise NoEquilibrium(f"Load case {name!r} has no equilibrium at this stiffness: {status}.")
        return candidates[0], equilibria
