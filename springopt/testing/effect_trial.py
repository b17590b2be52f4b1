"""An effect on the small lattices of its checks, and the states there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from springopt.checks import Floats
from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.effects.lanes import LANE_COUNT
from springopt.errors import UserError
from springopt.lattice import SpringLattice
from springopt.testing.kernel_calls import Answers, Failed, States, Stray, answers
from springopt.testing.verdict import NotJudged, told

EffectSubject = type[Effect] | Effect


@dataclass(frozen=True, eq=False)
class Body:
    """A lattice on which an effect is checked."""

    title: str  #: as it stands in a sentence
    lattice: SpringLattice

    @cached_property
    def size(self) -> float:
        """The length of a typical spring, or of the body where there is none."""
        springs = self.lattice.nodes[self.lattice.springs]
        lengths = np.linalg.norm(springs[:, 1] - springs[:, 0], axis=1)
        return float(np.median(lengths)) if lengths.any() else float(np.ptp(self.lattice.nodes)) or 1.0

    def states(self, values: Floats) -> States:
        """Eight of them, every number of its own: half near rest, half far; values (k,) are varied by a tenth."""
        rng = np.random.default_rng(20040607)
        count = LANE_COUNT
        reach = self.size * np.where(np.arange(count) % 2, 0.5, 0.12)[:, None]
        return States(
            reach * rng.standard_normal((count, self.lattice.nodes.size)),
            self.size * rng.standard_normal((count, self.lattice.nodes.size)),
            rng.uniform(0.5, 2.0, (count, self.lattice.spring_count)),
            values * rng.uniform(0.9, 1.1, (count, len(values))),
        )


@dataclass(frozen=True, eq=False)
class KernelTrial:
    """A kernel of an effect on one body."""

    what: str  #: as it stands in a sentence
    effect: Effect
    body: Body
    lattice: SpringLattice
    kernel: Kernel
    fitted: frozenset[str]
    values: Floats  #: of all parameters as the effect states them, shape (k,)

    @cached_property
    def states(self) -> States:
        return self.body.states(self.values)

    def answers(self, states: States) -> Answers:
        """Raises NotJudged where the kernel writes what it should not."""
        try:
            return answers(self.kernel, self.lattice, states)
        except (Stray, Failed) as fault:
            raise NotJudged(f"{self.what} has another fault ({fault}); mend that first.") from fault

    def at(self, lane: int, **instead: Floats) -> Answers:
        """At one of the states, with other rows of some of its numbers, shape (l, ...)."""
        given = self.states.take([lane])._asdict() | instead
        count = max(map(len, instead.values()), default=1)
        return self.answers(States(**{k: np.broadcast_to(v, (count, v.shape[1])) for k, v in given.items()}))


def bodies_of(effect: Effect, lattice: SpringLattice | None) -> list[Body]:
    """The bodies that the effect does not refuse; raises NotJudged where there is none."""
    reasons, taken = [], []
    for body in all_bodies() if lattice is None else [Body("the lattice that was given", lattice)]:
        try:
            effect.parameters(body.lattice)
            effect.constant_forces(body.lattice)
            effect.potential(body.lattice)
            effect.dissipation(body.lattice)
        except UserError as error:
            reasons.append(str(error))
        except Exception as error:
            raise NotJudged(f"{effect.name} fails on {body.title} ({told(error)}); mend that first.") from error
        else:
            taken.append(body)
    if not taken:
        raise NotJudged(f"{effect.name} refuses every lattice here; give check_effect one that it fits. {reasons[0]}")
    return taken


def all_bodies() -> list[Body]:
    """Small lattices with cells of every kind, one of them under prestress."""
    triangles = SpringLattice.grid((3, 3), cell="triangle")
    stretched = np.random.default_rng(1).uniform(0.9, 1.1, triangles.spring_count)
    return [
        Body("a lattice of nine nodes with square cells", SpringLattice.grid((3, 3))),
        Body(
            "a lattice of nine nodes with triangles, under prestress",
            replace(triangles, rest_lengths=triangles.rest_lengths * stretched),
        ),
        Body("a lattice of eight nodes with a cube for its cell", SpringLattice.grid((2, 2, 2))),
        Body("a lattice of twelve nodes with tetrahedra", SpringLattice.grid((3, 2, 2), cell="tetra")),
    ]


def flat(parameters: Mapping[str, Floats]) -> Floats:
    """Parameters as a kernel finds them, shape (k,)."""
    return np.concatenate([np.zeros(0), *(np.asarray(values, dtype=float) for values in parameters.values())])


def choices_to_fit(effect: Effect, lattice: SpringLattice) -> list[frozenset[str]]:
    """None of the parameters, each of them, and all."""
    names = list(effect.parameters(lattice))
    return list(dict.fromkeys([NOT_FITTED, *(frozenset([name]) for name in names), frozenset(names)]))


def potentials(effect: Effect, lattice: SpringLattice | None) -> Iterator[KernelTrial]:
    """The potential on every body, where none and where all of the parameters are fitted."""
    for body in bodies_of(effect, lattice):
        for fitted in (NOT_FITTED, frozenset(effect.parameters(body.lattice))):
            used = lattice_with_its_rest_lengths(effect, body.lattice, fitted)
            kernel = effect.potential(used, fitted)
            if kernel is not None:
                values = flat(effect.parameters(used))
                where = f"{' whose parameters are fitted' if fitted else ''} on {body.title}"
                yield KernelTrial(f"the potential of {effect.name}{where}", effect, body, used, kernel, fitted, values)
            if not effect.parameters(body.lattice):
                break  # fitted or not, it is the same


def dissipations(effect: Effect, lattice: SpringLattice | None) -> Iterator[KernelTrial]:
    """The dissipation on every body."""
    for body in bodies_of(effect, lattice):
        kernel = effect.dissipation(body.lattice)
        if kernel is not None:
            what = f"the dissipation of {effect.name} on {body.title}"
            values = flat(effect.parameters(body.lattice))
            yield KernelTrial(what, effect, body, body.lattice, kernel, NOT_FITTED, values)


def kernels(effect: Effect, lattice: SpringLattice | None) -> Iterator[KernelTrial]:
    yield from potentials(effect, lattice)
    yield from dissipations(effect, lattice)


def lattice_with_its_rest_lengths(effect: Effect, lattice: SpringLattice, fitted: frozenset[str]) -> SpringLattice:
    """The lattice as the effect leaves it."""
    rest_lengths = effect.rest_lengths(lattice, fitted)
    try:
        return lattice if rest_lengths is None else replace(lattice, rest_lengths=rest_lengths)
    except UserError as error:
        raise NotJudged(f"the rest lengths of {effect.name} have another fault ({error}); mend that first.") from error


def constant_forces(effect: Effect, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Floats | None:
    """Its constant forces, shape (n, d), or None; raises NotJudged for another shape."""
    forces = effect.constant_forces(lattice, fitted)
    if forces is not None and np.shape(forces) != lattice.nodes.shape:
        raise NotJudged(f"the constant forces of {effect.name} have another shape than (n, d); mend that first.")
    return forces


def matrix(kernel: Kernel, blocks: Floats, node_count: int) -> Floats:
    """The symmetric matrix that blocks (q, d, d) of its pairs stand for, shape (n d, n d)."""
    d = blocks.shape[-1]
    dense = np.zeros((node_count, d, node_count, d))
    for (i, j), block in zip(kernel.pairs, blocks, strict=True):
        dense[i, :, j] += block
        if i != j:
            dense[j, :, i] += block.T
    return dense.reshape(node_count * d, node_count * d)


def spring_forces(lattice: SpringLattice, displacements: Floats, stiffness: Floats) -> Floats:
    """Internal forces of the lattice's springs alone, at displacements (n d,), shape (n d,)."""
    i, j = lattice.springs.T
    positions = lattice.nodes + displacements.reshape(lattice.nodes.shape)
    vectors = positions[j] - positions[i]
    lengths = np.linalg.norm(vectors, axis=1)
    pulls = (stiffness * (lengths - lattice.rest_lengths) / lengths)[:, None] * vectors
    forces = np.zeros(lattice.nodes.shape)
    np.add.at(forces, j, pulls)
    np.add.at(forces, i, -pulls)
    return forces.ravel()
