"""The model: a lattice and its effects, solved for given stiffness and load cases."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springopt.checks import Floats, floats, require_finite, require_nonnegative, require_positive, require_shape
from springopt.effects.effect import Effect, checked_effects
from springopt.effects.springs import springs_of
from springopt.errors import UserError, did_you_mean
from springopt.forward.batch import Equilibria, Group, find, group_by_supports
from springopt.forward.choose import require_known
from springopt.forward.derivatives import Linearization, linearize
from springopt.forward.followed import BRANCHES, MINIMUM
from springopt.forward.lane_factors import tangents
from springopt.forward.motion.derivatives import MotionLinearization, linearize_motion
from springopt.forward.motion.follow import Motions, move
from springopt.forward.motion.stepping import Stepping
from springopt.forward.plan import Plan, make_plan
from springopt.forward.spring_forces import forces_per_stiffness
from springopt.forward.status import STATUSES, Status
from springopt.forward.terms import Terms
from springopt.forward.workspace import Workspace
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.parameters import Parameters

TOLERANCE = 1e-8


@dataclass(frozen=True, eq=False)
class Model:
    """A mass-spring model whose stiffness is still open."""

    lattice: SpringLattice
    effects: Sequence[Effect] = ()  #: what acts beside the springs
    #: "exact", or "linear" for small displacements: then one factor serves all load cases of a candidate.
    kinematics: str = "exact"
    #: None leaves the choice to `forward.choose`; "lanes", "sparse" and "iterative" give the same answers.
    engine: str | None = None
    #: Where there are several equilibria: the "minimum" that is found from rest, or the one "followed" by load steps.
    branch: str = MINIMUM
    threads: int = 1  #: that share the candidates of a batch; the answers are the same to the bit
    stepping: Stepping | None = None  #: how motion goes on in time, which load cases with times need
    #: Parameters of effects in which candidates differ, as "volume.modulus": columns behind the stiffness.
    fitted: Sequence[str] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "effects", checked_effects(self.effects))
        if self.kinematics == "nonlinear":  # what exact kinematics were called once
            object.__setattr__(self, "kinematics", "exact")
        require_known(self.kinematics, self.engine)
        if isinstance(self.threads, bool) or not isinstance(self.threads, Integral) or self.threads < 1:
            raise UserError(f"threads must be a whole number from 1 on, not {self.threads!r}.")
        if self.branch not in BRANCHES:
            hint = did_you_mean(self.branch, BRANCHES)
            raise UserError(f"branch must be one of {', '.join(BRANCHES)}, not {self.branch!r}.{hint}")
        if self.stepping is not None and not isinstance(self.stepping, Stepping):
            raise UserError(f"stepping must be Stepping(step), not {self.stepping!r}.")
        fitted = (self.fitted,) if isinstance(self.fitted, str) else tuple(self.fitted or ())
        object.__setattr__(self, "fitted", fitted)
        _require_expansions(self.terms, self.kinematics)  # makes the terms: options that do not fit are refused here
        if self.branch != MINIMUM:
            _require_loads_that_grow(self.terms)

    def __getstate__(self) -> dict[str, object]:
        """Without the terms, which hold compiled kernels and are made again."""
        return {name: value for name, value in self.__dict__.items() if name != "terms"}

    @cached_property
    def terms(self) -> Terms:
        """What the effects bring to this lattice."""
        return Terms.of(self.lattice, self.effects, self.fitted)

    def solve(
        self, stiffness: ArrayLike | Parameters, cases: Sequence[LoadCase], tolerance: float = TOLERANCE
    ) -> "Solution":
        """The equilibria of one candidate, stiffness [force/length] (s,), where 0 is no spring, or `Parameters`.

        `tolerance` bounds the out-of-balance force in relation to the largest of loads, reactions and prestress.
        A load case that has no equilibrium says so in its status and never raises.
        """
        model, candidates = self.candidates(stiffness, axes=1)
        batch = model._solve(model.groups(cases), candidates, cases, tolerance)
        return Solution(batch, candidates[0, : self.lattice.spring_count], model.terms.rows(candidates)[0])

    def solve_many(
        self, stiffness: ArrayLike | Parameters, cases: Sequence[LoadCase], tolerance: float = TOLERANCE
    ) -> "Batch":
        """The equilibria of many candidates, stiffness (m, s) or `Parameters`; each depends on its own row alone."""
        model, candidates = self.candidates(stiffness, axes=2)
        return model._solve(model.groups(cases), candidates, cases, tolerance)

    def candidates(self, given: ArrayLike | Parameters, axes: int) -> tuple["Model", Floats]:
        """(the model that fits what is given, its candidates (m, s + f)), `given` with so many axes.

        Without `Parameters` the columns behind the stiffness may be left out; effects then act as they are stated.
        """
        if isinstance(given, Parameters):
            model = self.fitting(given)
            return model, model._checked(given.rows(), given.stiffness.ndim, axes)
        candidates = floats("stiffness", given)
        return self, self._checked(np.atleast_2d(candidates), candidates.ndim, axes)

    def fitting(self, given: Parameters) -> "Model":
        """The model whose candidates differ in the parameters that are named here; refuses numbers that do not fit."""
        model = self if self.fitted == given.names else replace(self, fitted=given.names)
        leading = given.stiffness.shape[:-1]
        require_shape("stiffness", given.stiffness, (*leading, self.lattice.spring_count))
        for name, value in given.values.items():
            require_shape(name, np.asarray(value), (*leading, model.terms.count(name)))
            model.terms.require_allowed(name, np.asarray(value))
        return model

    def _checked(self, candidates: Floats, ndim: int, axes: int) -> Floats:
        springs = self.lattice.spring_count
        width = candidates.shape[1] if candidates.ndim == 2 else 0
        wide = springs + len(self.terms.fitted_columns)
        if ndim != axes or width not in (springs, wide):
            require_shape("stiffness", candidates if ndim == 2 else candidates[0], ("m", springs)[-axes:])
        require_nonnegative("stiffness", candidates[:, :springs])
        require_finite("parameters", candidates[:, springs:])
        return candidates

    def find(self, groups: Sequence[Group], candidates: Floats, tolerance: float) -> Equilibria | Motions:
        """The equilibria of checked candidates (m, s) on the model's branch; their motions where cases have times."""
        if groups[0].times.shape[1]:
            assert self.stepping is not None  # or there were no groups
            return move(groups, candidates, self.stepping, tolerance=tolerance, threads=self.threads)
        return find(groups, candidates, tolerance=tolerance, branch=self.branch, threads=self.threads)

    def linearize(
        self, groups: Sequence[Group], candidate: Floats, answers: Equilibria | Motions, tolerance: float
    ) -> Linearization | MotionLinearization:
        """How the answers to one candidate (s + f,) change with its row (s + p,), see `forward.terms`."""
        row = self.terms.rows(candidate[None])[0]
        if isinstance(answers, Equilibria):
            return linearize(groups, row, answers.displacements[0])
        assert self.stepping is not None  # or nothing would have moved
        return linearize_motion(groups, row, candidate, self.stepping, tolerance=tolerance)

    def forces_per_stiffness(self, positions: ArrayLike) -> Floats:
        """What each spring pulls its first node with at positions (c, n, d), over its stiffness [length], (c, s, d)."""
        shape = ("c", *self.lattice.nodes.shape)
        displacements = require_shape("positions", floats("positions", positions), shape) - self.lattice.nodes
        is_linear = self.kinematics == "linear"
        flat = displacements.reshape(len(displacements), -1)
        return forces_per_stiffness(springs_of(self.terms.lattice), flat, is_linear=is_linear)

    def constant_forces(self) -> Floats:
        """The sum of what the effects bring as constant nodal forces [force], shape (n, d)."""
        return self.terms.constant_forces

    def groups(self, cases: Sequence[LoadCase]) -> tuple[Group, ...]:
        """The load cases as the forward solve takes them, grouped by their supports."""
        if isinstance(cases, LoadCase):
            raise UserError("The load cases must come in a list, also a single one; write [case].")
        if not cases:
            raise UserError("At least one load case is needed to solve a model; none came.")
        for case in cases:
            if case.forces.shape != self.lattice.nodes.shape:
                raise UserError(
                    f"Load case {case.name!r} has forces of shape {case.forces.shape}, "
                    f"but the lattice has nodes of shape {self.lattice.nodes.shape}."
                )
        self.require_what_times_need(cases)
        return group_by_supports(self.terms, cases, kinematics=self.kinematics, engine=self.engine)

    def require_what_times_need(self, cases: Sequence[LoadCase]) -> None:
        """Refuses load cases with times that this model can't follow, or not beside each other."""
        counts = {0 if case.times is None else len(case.times) for case in cases}
        if counts == {0}:
            return
        if len(counts) > 1:
            raise UserError(
                "load cases of one solve have equally many times, or none of them has any; solve them apart."
            )
        if not any(term.has_masses for term in self.terms.terms):
            raise UserError(
                f"load case {cases[0].name!r} has times, and nothing has a mass; add the effect inertia, or leave the "
                "times out."
            )
        if self.stepping is None:
            raise UserError(
                f"load case {cases[0].name!r} has times, and no step is stated; give stepping = Stepping(step), as "
                "long as the accuracy allows."
            )
        if self.kinematics == "linear":
            raise UserError("motion is followed with exact kinematics only; choose kinematics = 'exact'.")

    def _solve(
        self, groups: Sequence[Group], candidates: Floats, cases: Sequence[LoadCase], tolerance: float
    ) -> "Batch":
        require_positive("tolerance", float(floats("tolerance", tolerance)))
        return Batch(self.find(groups, candidates, tolerance), candidates, self.terms, cases)


def _require_loads_that_grow(terms: Terms) -> None:
    """Load steps scale loads; what is a load until it is fitted would be there from the first one on."""
    for term in terms.terms:
        is_load = term.effect.constant_forces(terms.lattice) is not None
        if term.potential is not None and is_load:
            raise UserError(
                f"the branch 'followed' grows loads from nothing, and {term.name} is none where its parameters are "
                "fitted; choose branch = 'minimum', or state them."
            )


def _require_expansions(terms: Terms, kinematics: str) -> None:
    for term in terms.terms:
        if kinematics == "linear" and not term.effect.has_expansion_at_rest:
            raise UserError(f"small displacements would leave {term.name} out; choose kinematics = 'exact'.")


@dataclass(frozen=True, eq=False)
class Batch:
    """Equilibria of m candidates under c load cases; motions have an axis of t times before the nodes."""

    equilibria: Equilibria | Motions
    candidates: Floats = field(repr=False)  #: shape (m, s + f)
    terms: Terms = field(repr=False)
    cases: Sequence[LoadCase] = field(repr=False)

    @property
    def lattice(self) -> SpringLattice:
        """With the rest lengths that the effects leave it."""
        return self.terms.lattice

    @cached_property
    def displacements(self) -> Floats:
        """[length], shape (m, c, n, d)."""
        return self._by_node(self.equilibria.displacements)

    @cached_property
    def velocities(self) -> Floats:
        """[length / time], shape (m, c, t, n, d); of equilibria none."""
        if isinstance(self.equilibria, Equilibria):
            raise UserError("equilibria have no velocities; give the load cases times.")
        return self._by_node(self.equilibria.velocities)

    def _by_node(self, flat: Floats) -> Floats:
        return flat.reshape(*flat.shape[:-1], *self.lattice.nodes.shape)

    @cached_property
    def positions(self) -> Floats:
        """[length], shape (m, c, n, d); without an equilibrium, where the search ended."""
        return self.lattice.nodes + self.displacements

    @cached_property
    def status(self) -> NDArray[np.object_]:
        """A `Status` for each candidate and load case, shape (m, c)."""
        return STATUSES[self.equilibria.codes]

    @property
    def residual(self) -> Floats:
        """The largest out-of-balance force of a free degree of freedom, shape (m, c)."""
        return self.equilibria.residuals

    @cached_property
    def energy(self) -> Floats:
        """Strain energy less forces . positions, weights included, shape (m, c).

        In motion with the kinetic energy, shape (m, c, t).
        """
        if isinstance(self.equilibria, Motions):
            return self._energies_in_motion()
        weight = self.terms.constant_forces
        at_rest = [np.vdot(case.forces + weight, self.lattice.nodes) for case in self.cases]
        return self.equilibria.energies - np.array(at_rest)

    def _energies_in_motion(self) -> Floats:
        rows = self.terms.rows(self.candidates)
        masses = self.terms.masses(rows[:, self.lattice.spring_count :])
        # With the supports of each load case, since a node that is held is not in contact.
        works = [Workspace.of(make_plan(self.terms, case.supports)) for case in self.cases]
        forces = np.array([case.forces + self.terms.constant_forces for case in self.cases])
        kinetic = 0.5 * np.einsum("mn,mctnd->mct", masses, self.velocities**2)
        potential = -np.einsum("cnd,mctnd->mct", forces, self.positions)
        for candidate, row in enumerate(rows):
            for case, work in enumerate(works):
                states = self.displacements[candidate, case].reshape(-1, self.lattice.nodes.size)
                potential[candidate, case] += work.energies(row, states)
        return kinetic + potential

    @property
    def iterations(self) -> NDArray[np.int64]:
        """Evaluations of force and tangent, in motion steps in time, shape (m, c)."""
        return self.equilibria.steps if isinstance(self.equilibria, Motions) else self.equilibria.iterations


@dataclass(frozen=True, eq=False)
class Solution:
    """Equilibria of one candidate under c load cases: the first axis of `Batch` taken off."""

    batch: Batch
    stiffness: Floats = field(repr=False)
    row: Floats = field(repr=False)  #: the stiffness, and the parameters of all effects, shape (s + p,)

    @property
    def displacements(self) -> Floats:
        """[length], shape (c, n, d)."""
        return self.batch.displacements[0]

    @property
    def positions(self) -> Floats:
        """[length], shape (c, n, d); without an equilibrium, where the search ended."""
        return self.batch.positions[0]

    @property
    def status(self) -> NDArray[np.object_]:
        """A `Status` for each load case, shape (c,)."""
        return self.batch.status[0]

    @property
    def residual(self) -> Floats:
        """The largest out-of-balance force of a free degree of freedom, shape (c,)."""
        return self.batch.residual[0]

    @property
    def energy(self) -> Floats:
        """Strain energy less forces . positions, weights included, shape (c,); in motion with what moves, (c, t)."""
        return self.batch.energy[0]

    @property
    def velocities(self) -> Floats:
        """[length / time], shape (c, t, n, d); of equilibria none."""
        return self.batch.velocities[0]

    @cached_property
    def zero_modes(self) -> list[Floats]:
        """For each load case that is underdetermined, its modes without stiffness, orthonormal, shape (modes, n, d)."""
        modes = [np.zeros((0, *self.batch.lattice.nodes.shape)) for _ in self.batch.cases]
        for number, case in enumerate(self.batch.cases):
            if self.status[number] == Status.UNDERDETERMINED:
                # A plan of its own: one that was sent here has addresses of kernels in another process.
                plan = make_plan(self.batch.terms, case.supports)
                modes[number] = _zero_modes(plan, self.row, self.displacements[number].ravel())
        return modes


def _zero_modes(plan: Plan, row: Floats, displacements: Floats) -> Floats:
    nodes = plan.nodes
    free = np.setdiff1d(np.arange(nodes.size), plan.supported)
    tangent = tangents(plan, row, displacements[None])[0][np.ix_(free, free)]
    values, vectors = np.linalg.eigh(tangent)
    is_zero = np.abs(values) <= 1e-10 * max(np.abs(values).max(initial=0.0), np.finfo(float).tiny)
    modes = np.zeros((np.count_nonzero(is_zero), nodes.size))
    modes[:, free] = vectors[:, is_zero].T
    return modes.reshape(-1, *nodes.shape)
