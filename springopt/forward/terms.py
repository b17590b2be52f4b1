"""What the effects of a model bring, gathered once for all supports.

A candidate is a row of numbers: the stiffness of each spring, then the parameters of every effect that brings a kernel
or masses, fitted or not. So candidates may differ in any of them, and kernels find their own.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from springopt.checks import Floats
from springopt.effects.effect import Effect, Kernel
from springopt.errors import UserError, did_you_mean
from springopt.lattice import SpringLattice


@dataclass(frozen=True, eq=False)
class Term:
    """One effect, and what it brings to one lattice."""

    name: str  #: unique among the terms of a model
    effect: Effect
    constant_forces: Floats | None
    potential: Kernel | None
    dissipation: Kernel | None
    parameters: dict[str, Floats]  #: those that are columns of a candidate, shape (k,) each
    first: int  #: the column where they begin, counted from behind the stiffness
    has_masses: bool

    @property
    def columns(self) -> slice:
        """Its columns, counted from behind the stiffness."""
        return slice(self.first, self.first + sum(map(len, self.parameters.values())))


@dataclass(frozen=True, eq=False)
class Terms:
    """All effects of a model."""

    lattice: SpringLattice  #: with the rest lengths that the effects leave it
    terms: tuple[Term, ...]
    fitted: tuple[
        str, ...
    ]  #: the parameters in which candidates differ, as "effect.parameter", in columns of their own

    @classmethod
    def of(cls, lattice: SpringLattice, effects: Sequence[Effect] = (), fitted: Sequence[str] = ()) -> "Terms":
        """Raises UserError where options do not fit the lattice, and for a fitted parameter that there is not."""
        names = list(_names(effects))
        _require_known(fitted, {f"{n}.{p}" for n, e in zip(names, effects, strict=True) for p in e.parameters(lattice)})
        fitted_of = [_own(name, fitted) for name in names]
        bare = lattice
        for effect, own in zip(effects, fitted_of, strict=True):
            rest_lengths = effect.rest_lengths(bare, own)
            if rest_lengths is not None:
                lattice = replace(lattice, rest_lengths=rest_lengths * _shares(lattice, bare))
        terms: list[Term] = []
        for name, effect, own in zip(names, effects, fitted_of, strict=True):
            first = terms[-1].columns.stop if terms else 0
            terms.append(_term(name, effect, lattice, own, first))
        _require_one_law_and_no_moving_rest_lengths(terms)
        return cls(lattice, tuple(terms), tuple(fitted))

    def fitted_of(self, term: Term) -> frozenset[str]:
        """The own names of those parameters of a term in which candidates differ."""
        return _own(term.name, self.fitted)

    @property
    def constant_forces(self) -> Floats:
        """Their sum [force], shape (n, d)."""
        total = np.zeros(self.lattice.nodes.shape)
        for term in self.terms:
            if term.constant_forces is not None:
                total += term.constant_forces
        return total

    @property
    def potentials(self) -> tuple[tuple[Term, Kernel], ...]:
        """The terms with a potential."""
        return tuple((term, term.potential) for term in self.terms if term.potential is not None)

    @property
    def dissipations(self) -> tuple[tuple[Term, Kernel], ...]:
        """The terms with a dissipation."""
        return tuple((term, term.dissipation) for term in self.terms if term.dissipation is not None)

    @property
    def defaults(self) -> Floats:
        """The columns behind the stiffness, as the effects state them, shape (p,)."""
        return np.concatenate([np.zeros(0), *(v for term in self.terms for v in term.parameters.values())])

    @contextmanager
    def failures_raised(self) -> Iterator[None]:
        """Kernels in Python that failed in here say so at the end, whatever the search made of it."""
        try:
            yield
        finally:
            for _, kernel in self.potentials + self.dissipations:
                kernel.raise_failure()

    def columns(self, name: str) -> slice:
        """Where a parameter, "effect.parameter", is among the columns behind the stiffness."""
        for term in self.terms:
            first = term.first
            for own, values in term.parameters.items():
                if name == f"{term.name}.{own}":
                    return slice(first, first + len(values))
                first += len(values)
        raise KeyError(name)

    def count(self, name: str) -> int:
        """How many numbers a parameter has."""
        columns = self.columns(name)
        return columns.stop - columns.start

    def rows(self, candidates: Floats) -> Floats:
        """Candidates (m, s) or (m, s + f), with the fitted parameters behind the stiffness, as whole rows (m, s + p).

        What is not given is as the effects state it.
        """
        springs = self.lattice.spring_count
        if not self.terms:
            return candidates
        rows = np.concatenate([candidates[:, :springs], np.tile(self.defaults, (len(candidates), 1))], axis=1)
        if candidates.shape[1] > springs:
            rows[:, springs + self.fitted_columns] = candidates[:, springs:]
        return rows

    @property
    def fitted_columns(self) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
        """The columns behind the stiffness of the fitted parameters, in their order, shape (f,)."""
        every = np.arange(len(self.defaults))
        return np.concatenate([np.zeros(0, dtype=np.int64), *(every[self.columns(name)] for name in self.fitted)])

    def masses(self, row: Floats) -> Floats:
        """Mass of each node for the columns (..., p) behind the stiffness, shape (..., n)."""
        total = np.zeros((*row.shape[:-1], self.lattice.node_count))
        for term in self.terms:
            if term.has_masses:
                mass = term.effect.masses(self.lattice, self.values(term, row))
                assert mass is not None  # it said so when the term was made
                total += mass
        return total

    def require_allowed(self, name: str, value: Floats) -> None:
        """Refuses a value (k,) of a parameter that its effect would refuse as that of its option of this name."""
        of, own = name.split(".", 1)
        term = next(term for term in self.terms if term.name == of)
        stated: Any = getattr(term.effect, own, None)
        shape = np.shape(stated)
        if _refusal(term.effect, own, np.full(shape, term.parameters[own].flat[0]), self.lattice):
            return  # another option stands for it
        for extreme in {float(value.min()), float(value.max())}:
            refusal = _refusal(term.effect, own, np.full(shape, extreme), self.lattice)
            if refusal:
                raise UserError(f"{name} is {extreme:g}, and {refusal}")

    @staticmethod
    def values(term: Term, row: Floats) -> dict[str, Floats]:
        """The parameters of one term in the columns (..., p) behind the stiffness."""
        values, first = {}, term.first
        for name, default in term.parameters.items():
            values[name] = row[..., first : first + len(default)]
            first += len(default)
        return values


def _own(name: str, fitted: Sequence[str]) -> frozenset[str]:
    return frozenset(parameter.split(".", 1)[1] for parameter in fitted if parameter.split(".", 1)[0] == name)


def _refusal(effect: Effect, option: str, value: Floats, lattice: SpringLattice) -> str:
    """What an effect says of a value of its option; nothing where it takes it."""
    try:
        replace(effect, **{option: value}).parameters(lattice)
    except (UserError, TypeError) as error:  # it has no option of this name
        return str(error)
    return ""


def _names(effects: Sequence[Effect]) -> Iterable[str]:
    """ "contact", and for the second one "contact-2"."""
    seen: dict[str, int] = {}
    for effect in effects:
        name = effect.name or type(effect).__name__.lower()
        seen[name] = seen.get(name, 0) + 1
        yield name if seen[name] == 1 else f"{name}-{seen[name]}"


def _require_known(fitted: Sequence[str], known: set[str]) -> None:
    for name in fitted:
        if not isinstance(name, str):
            raise UserError(f"fitted parameters are named as 'volume.modulus', not by {name!r}.")
        if name not in known:
            names = ", ".join(sorted(known)) or "none"
            raise UserError(
                f"there is no parameter {name!r} to fit; the effects here have {names}.{did_you_mean(name, known)}"
            )
    if len(set(fitted)) < len(fitted):
        raise UserError(f"each fitted parameter should be named once, not as in {', '.join(fitted)}.")


def _shares(lattice: SpringLattice, bare: SpringLattice) -> Floats:
    """How far other effects have scaled the rest lengths already."""
    ones = np.ones(lattice.spring_count)
    return np.divide(lattice.rest_lengths, bare.rest_lengths, out=ones, where=bare.rest_lengths > 0)


def _term(name: str, effect: Effect, lattice: SpringLattice, fitted: frozenset[str], first: int) -> Term:
    potential, dissipation = effect.potential(lattice, fitted), effect.dissipation(lattice)
    parameters = effect.parameters(lattice)
    has_masses = effect.masses(lattice, parameters) is not None
    if potential is None and dissipation is None and not has_masses:
        parameters = {}
    constant = effect.constant_forces(lattice, fitted)
    return Term(name, effect, constant, potential, dissipation, parameters, first, has_masses)


def _require_one_law_and_no_moving_rest_lengths(terms: Sequence[Term]) -> None:
    laws = [term.name for term in terms if term.potential is not None and term.effect.scales_with_stiffness]
    if len(laws) > 1:
        raise UserError(
            f"{' and '.join(laws)} both change the law of the springs, each as if it were alone; keep one of them, "
            "or do not fit the rest lengths."
        )
