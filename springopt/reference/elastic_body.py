"""The elastic body: the elements of a mesh together."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix

from springopt.checks import Floats, Integers
from springopt.reference.elements import Elements


@dataclass(frozen=True, eq=False)
class ElasticBody:
    """Energy, forces and tangent of displacements [length], shape (n, d); n d numbers are the axes side by side."""

    elements: Elements
    node_count: int
    thickness: float = 1.0  #: [length], 1 in 3D

    def is_admissible(self, displacements: Floats) -> bool:
        """Whether no element is turned inside out."""
        return self.elements.is_admissible(displacements[self._cells])

    def energy(self, displacements: Floats) -> float:
        """Strain energy [force length]."""
        return self.thickness * float(self.elements.energies(displacements[self._cells]).sum())

    def internal_forces(self, displacements: Floats) -> Floats:
        """The forces that hold the nodes there [force], shape (n, d)."""
        forces = self.elements.forces(displacements[self._cells])
        total = np.zeros(displacements.size)
        np.add.at(total, self._numbers, forces)
        return self.thickness * total.reshape(displacements.shape)

    def tangent(self, displacements: Floats) -> csc_matrix:
        """The derivative of the internal forces [force / length], shape (n d, n d)."""
        tangents = self.elements.tangents(displacements[self._cells])
        numbers = self._numbers
        rows = np.broadcast_to(numbers[:, :, None], tangents.shape).ravel()
        columns = np.broadcast_to(numbers[:, None, :], tangents.shape).ravel()
        size = displacements.size
        return self.thickness * csc_matrix(coo_matrix((tangents.ravel(), (rows, columns)), shape=(size, size)))

    @property
    def stiffness_matrix(self) -> csc_matrix:
        """The tangent at rest [force / length], shape (n d, n d)."""
        return self.tangent(np.zeros((self.node_count, self.elements.discretization.dimension)))

    @property
    def _cells(self) -> Integers:
        return self.elements.discretization.cells

    @property
    def _numbers(self) -> Integers:
        """The degrees of freedom of each cell, shape (c, v d)."""
        d = self.elements.discretization.dimension
        return (self._cells[:, :, None] * d + np.arange(d)).reshape(len(self._cells), -1)
