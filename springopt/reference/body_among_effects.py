"""A body and the potentials that act on it from outside, such as contact."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol, Self

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix

from springopt.checks import Floats
from springopt.effects.effect import Effect, Kernel
from springopt.effects.probe import Probe, probe
from springopt.errors import UserError
from springopt.lattice import SpringLattice


class Body(Protocol):
    """What an equilibrium is sought of, by displacements [length], shape (n, d)."""

    def is_admissible(self, displacements: Floats) -> bool:
        """Whether no element is turned inside out."""

    def internal_forces(self, displacements: Floats) -> Floats:
        """The forces that hold the nodes there [force], shape (n, d)."""

    def tangent(self, displacements: Floats) -> csc_matrix:
        """Their derivative [force / length], shape (n d, n d)."""


@dataclass(frozen=True, eq=False)
class LinearBody:
    """A body at small displacements."""

    stiffness: csc_matrix

    def is_admissible(self, displacements: Floats) -> bool:
        return True

    def internal_forces(self, displacements: Floats) -> Floats:
        return (self.stiffness @ displacements.ravel()).reshape(displacements.shape)

    def tangent(self, displacements: Floats) -> csc_matrix:
        return self.stiffness


class Potential(NamedTuple):
    """What an effect brings, and how much of it is there."""

    kernel: Kernel
    values: Floats  #: of its parameters, shape (k,)
    shares: Floats | None = None  #: of each node, for a potential of single nodes, shape (n,); the whole where None


@dataclass(frozen=True, eq=False)
class BodyAmongEffects:
    """A body with the potentials of effects, which grow with the load: `share` of them is there."""

    body: Body
    lattice: SpringLattice  #: the nodes and cells of the body
    potentials: Sequence[Potential]
    share: float = 1.0

    @classmethod
    def of(cls, body: Body, lattice: SpringLattice, effects: Sequence[Effect]) -> Self:
        """Laws of springs are left out; refuses other potentials that do not act from outside."""
        found = outside_potentials(lattice, effects)
        return cls(body, lattice, [Potential(kernel, values) for _, kernel, values in found])

    def under(self, share: float) -> Self:
        """With another share of the effects."""
        return replace(self, share=share) if self.potentials else self

    def is_admissible(self, displacements: Floats) -> bool:
        return self.body.is_admissible(displacements)

    def internal_forces(self, displacements: Floats) -> Floats:
        forces = self.body.internal_forces(displacements)
        for potential in self.potentials:
            own = self._probe(potential, displacements).forces.reshape(forces.shape)
            forces = forces + self.share * (own if potential.shares is None else potential.shares[:, None] * own)
        return forces

    def tangent(self, displacements: Floats) -> csc_matrix:
        tangent = self.body.tangent(displacements)
        for potential in self.potentials:
            blocks, kernel = self._probe(potential, displacements).blocks[0], potential.kernel
            if potential.shares is not None:
                blocks = potential.shares[kernel.pairs[:, 0], None, None] * blocks
            tangent = tangent + self.share * _matrix(kernel, blocks, displacements.size)
        return csc_matrix(tangent)

    def _probe(self, potential: Potential, displacements: Floats) -> Probe:
        nothing, row = np.zeros(self.lattice.spring_count), displacements.reshape(1, -1)
        return probe(potential.kernel, self.lattice, row, stiffness=nothing, values=potential.values)


def outside_potentials(lattice: SpringLattice, effects: Sequence[Effect]) -> Iterator[tuple[Effect, Kernel, Floats]]:
    """Effects with a potential, its kernel and the values of its parameters; without laws of springs."""
    for effect in effects:
        kernel = None if effect.scales_with_stiffness else effect.potential(lattice)
        if kernel is not None:
            _require_outside(effect)
            yield effect, kernel, np.concatenate([np.zeros(0), *effect.parameters(lattice).values()])


def _require_outside(effect: Effect) -> None:
    if not effect.acts_from_outside:
        raise UserError(
            f"{effect.name or type(effect).__name__} is a part of a lattice, and would make a finite element body "
            "another one; leave it out, or say acts_from_outside = True in an effect of your own."
        )


def _matrix(kernel: Kernel, blocks: Floats, size: int) -> csc_matrix:
    """The symmetric matrix of blocks (q, d, d) of pairs of nodes."""
    d = blocks.shape[-1]
    axes = np.arange(d)
    i, j = (kernel.pairs[:, end, None] * d + axes for end in (0, 1))
    rows, columns = np.broadcast_arrays(i[:, :, None], j[:, None, :])
    upper = coo_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))
    off = kernel.pairs[:, 0] != kernel.pairs[:, 1]
    lower = coo_matrix((blocks[off].ravel(), (columns[off].ravel(), rows[off].ravel())), shape=(size, size))
    return csc_matrix(upper + lower)
