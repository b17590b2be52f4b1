"""A body and the potentials that act on it from outside, such as contact."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol, Self

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


@dataclass(frozen=True, eq=False)
class BodyAmongEffects:
    """A body with the potentials of effects, which grow with the load: `share` of them is there."""

    body: Body
    lattice: SpringLattice  #: the nodes and cells of the body
    potentials: Sequence[tuple[Kernel, Floats]]  #: kernels, and the parameters of each, shape (k,)
    share: float = 1.0

    @classmethod
    def of(cls, body: Body, lattice: SpringLattice, effects: Sequence[Effect]) -> Self:
        """Laws of springs are left out; refuses other potentials that do not act from outside."""
        potentials = []
        for effect in effects:
            kernel = None if effect.scales_with_stiffness else effect.potential(lattice)
            if kernel is not None:
                _require_outside(effect)
                potentials.append((kernel, np.concatenate([np.zeros(0), *effect.parameters(lattice).values()])))
        return cls(body, lattice, potentials)

    def under(self, share: float) -> Self:
        """With another share of the effects."""
        return replace(self, share=share) if self.potentials else self

    def is_admissible(self, displacements: Floats) -> bool:
        return self.body.is_admissible(displacements)

    def internal_forces(self, displacements: Floats) -> Floats:
        forces = self.body.internal_forces(displacements)
        for kernel, values in self.potentials:
            forces = forces + self.share * self._probe(kernel, values, displacements).forces.reshape(forces.shape)
        return forces

    def tangent(self, displacements: Floats) -> csc_matrix:
        tangent = self.body.tangent(displacements)
        for kernel, values in self.potentials:
            blocks = self._probe(kernel, values, displacements).blocks[0]
            tangent = tangent + self.share * _matrix(kernel, blocks, displacements.size)
        return csc_matrix(tangent)

    def _probe(self, kernel: Kernel, values: Floats, displacements: Floats) -> Probe:
        nothing = np.zeros(self.lattice.spring_count)
        return probe(kernel, self.lattice, displacements.reshape(1, -1), stiffness=nothing, values=values)


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
