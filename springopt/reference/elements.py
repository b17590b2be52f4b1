"""Finite elements at large strain: what all the cells of a mesh answer to the displacements of their nodes."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from springopt.checks import Floats
from springopt.reference.discretization import Discretization
from springopt.reference.law import Law


class Elements(Protocol):
    """A formulation of the elements: it takes displacements [length], shape (c, v, d)."""

    @property
    def discretization(self) -> Discretization: ...

    def is_admissible(self, displacements: Floats) -> bool:
        """Whether the volume is positive at every Gauss point, and the law defined there."""
        ...

    def energies(self, displacements: Floats) -> Floats:
        """Strain energy of each cell [force length], shape (c,)."""
        ...

    def forces(self, displacements: Floats) -> Floats:
        """The derivatives of the energies [force], shape (c, v d)."""
        ...

    def tangents(self, displacements: Floats) -> Floats:
        """The derivatives of the forces [force / length], shape (c, v d, v d)."""
        ...


@dataclass(frozen=True, eq=False)
class StandardElements:
    """Elements whose strain is that of their displacements at each Gauss point.

    Nearly incompressible material locks them: they are far too stiff where Poisson's ratio is above about 0.49.
    """

    discretization: Discretization
    law: Law

    def is_admissible(self, displacements: Floats) -> bool:
        return bool(self.law.is_admissible(self._strains(displacements)).all())

    def energies(self, displacements: Floats) -> Floats:
        return np.sum(self.discretization.weights * self.law.energy(self._strains(displacements)), axis=1)

    def forces(self, displacements: Floats) -> Floats:
        stress = self.law.stress(self._strains(displacements)) * self.discretization.weights[..., None, None]
        shapes = self.discretization.gradients
        return np.einsum("cqij,cqvj->cvi", stress, shapes, optimize=True).reshape(len(shapes), -1)

    def tangents(self, displacements: Floats) -> Floats:
        strains, weights = self._strains(displacements), self.discretization.weights
        total = np.zeros((len(weights), displacements[0].size, displacements[0].size))
        for point in range(weights.shape[1]):  # one at a time for the sake of memory
            rows = strain_rows(self.discretization.gradients[:, point], strains.shape[-1])
            moduli = self.law.moduli(strains[:, point]) * weights[:, point, None, None, None, None]
            total += rows.swapaxes(1, 2) @ as_matrices(moduli) @ rows
        return total

    def _strains(self, displacements: Floats) -> Floats:
        return displacement_gradients(self.discretization, displacements)


def displacement_gradients(discretization: Discretization, displacements: Floats) -> Floats:
    """At each Gauss point, shape (c, q, d, d)."""
    return displacements.swapaxes(1, 2)[:, None] @ discretization.gradients


def strain_rows(gradients: Floats, axes: int) -> Floats:
    """What displacements (v d) make of a displacement gradient of so many axes, shape (c, axes axes, v d)."""
    count, v, d = gradients.shape
    rows = np.zeros((count, axes, axes, v, d))
    for axis in range(d):
        rows[:, axis, :d, :, axis] = gradients.swapaxes(1, 2)
    return rows.reshape(count, axes * axes, v * d)


def as_matrices(moduli: Floats) -> Floats:
    """Moduli (c, d, d, d, d) as matrices (c, d d, d d)."""
    size = moduli.shape[-1] ** 2
    return moduli.reshape(-1, size, size)
