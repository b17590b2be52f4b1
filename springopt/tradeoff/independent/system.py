"""A model with all its numbers known: its forces, tangents and masses, without any engine.

Springs are those of `independent.springs`. What effects bring is called through `effects.probe`: their kernels are
their only definition, and so what is independent of them is how they are summed, solved and followed in time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from springopt.checks import Floats, Integers
from springopt.effects.effect import Kernel
from springopt.effects.probe import probe, times_blocks
from springopt.lattice import SpringLattice
from springopt.model import Model
from springopt.tradeoff.independent.springs import Reals, Springs

Bound = Sequence[tuple[Kernel, Floats]]  # kernels, and the parameters (k,) of each


@dataclass(frozen=True, eq=False)
class System:
    """One candidate; displacements and velocities have the shape (n, d)."""

    lattice: SpringLattice  #: with the rest lengths that the effects leave it
    springs: Springs
    stiffness: Floats  #: of the springs, as kernels of effects read it, shape (s,)
    potentials: Bound
    dissipations: Bound
    masses: Floats  #: of the nodes, shape (n,)
    loads: Floats  #: what effects bring as constant nodal forces [force], shape (n, d)

    @classmethod
    def of(cls, model: Model, candidate: Floats, precision: Any = np.longdouble) -> System:
        """A model at one candidate (s + f,), see `forward.terms`; `precision` is that of the springs."""
        terms = model.terms
        row = terms.rows(candidate[None])[0]
        stiffness, values = np.split(row, [terms.lattice.spring_count])
        return cls(
            lattice=terms.lattice,
            springs=Springs.of(terms.lattice, stiffness, precision),
            stiffness=stiffness,
            potentials=[(kernel, values[term.columns]) for term, kernel in terms.potentials],
            dissipations=[(kernel, values[term.columns]) for term, kernel in terms.dissipations],
            masses=terms.masses(values),
            loads=terms.constant_forces,
        )

    def forces(self, displacements: Reals) -> Reals:
        """Internal forces [force], of springs and potentials.

        Kernels compute in double precision. What a displacement has beyond that enters by their tangent, so that
        forces change as smoothly as the displacements.
        """
        forces, near = self.springs.forces(displacements), displacements.astype(np.float64)
        beyond = (displacements - near).astype(np.float64)
        for kernel, values in self.potentials:
            found = probe(kernel, self.lattice, near.reshape(1, -1), stiffness=self.stiffness, values=values)
            forces = forces + found.forces.reshape(near.shape)
            if beyond.any():
                more = times_blocks(kernel, found.blocks, beyond.reshape(1, -1), self.lattice.dimension)
                forces = forces + more.reshape(near.shape)
        return forces

    def drag(self, displacements: Floats, velocities: Floats) -> Floats:
        """What dissipations pull against the motion with [force], shape (n, d)."""
        total = np.zeros(displacements.shape)
        for kernel, values in self.dissipations:
            total += self._of_dissipation(kernel, values, displacements, velocities).forces.reshape(total.shape)
        return total

    def energy(self, displacements: Reals) -> float:
        """Of springs and potentials."""
        near = displacements.astype(np.float64).reshape(1, -1)
        return self.springs.energy(displacements) + sum(
            float(probe(kernel, self.lattice, near, stiffness=self.stiffness, values=values).energy[0])
            for kernel, values in self.potentials
        )

    def tangent(self, displacements: Reals) -> Any:
        """The derivative of the internal forces, a sparse matrix of shape (n d, n d)."""
        near = displacements.astype(np.float64)
        blocks = self.springs.blocks(displacements).astype(np.float64)
        i, j = self.springs.ends.T
        rows, columns = np.concatenate([i, j, i, j]), np.concatenate([i, j, j, i])
        total = self._matrix(rows, columns, np.concatenate([blocks, blocks, -blocks, -blocks]))
        for kernel, values in self.potentials:
            found = probe(kernel, self.lattice, near.reshape(1, -1), stiffness=self.stiffness, values=values)
            total = total + self._of_pairs(kernel, found.blocks[0])
        return total

    def damping(self, displacements: Floats) -> Any:
        """The derivative of the drag by the velocity, at rest, a sparse matrix of shape (n d, n d)."""
        total = sparse.csr_array((displacements.size, displacements.size))
        for kernel, values in self.dissipations:
            found = self._of_dissipation(kernel, values, displacements, np.zeros_like(displacements))
            total = total + self._of_pairs(kernel, found.blocks[0])
        return total

    def _of_dissipation(self, kernel: Kernel, values: Floats, displacements: Floats, velocities: Floats) -> Any:
        return probe(
            kernel,
            self.lattice,
            displacements.reshape(1, -1),
            stiffness=self.stiffness,
            values=values,
            velocities=velocities.reshape(1, -1),
        )

    def _of_pairs(self, kernel: Kernel, blocks: Floats) -> Any:
        """The symmetric matrix of which kernels give the block of each pair of nodes once."""
        i, j = kernel.pairs.T
        off = i != j
        rows, columns = np.concatenate([i, j[off]]), np.concatenate([j, i[off]])
        return self._matrix(rows, columns, np.concatenate([blocks, blocks[off].swapaxes(1, 2)]))

    def _matrix(self, rows: Integers, columns: Integers, blocks: Floats) -> Any:
        """Blocks (q, d, d) at these nodes, summed, of shape (n d, n d)."""
        d, size = self.lattice.dimension, self.lattice.nodes.size
        a, b = np.indices((d, d))
        at = (d * rows[:, None, None] + a).ravel(), (d * columns[:, None, None] + b).ravel()
        return sparse.coo_array((blocks.ravel(), at), shape=(size, size)).tocsr()
