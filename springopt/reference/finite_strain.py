"""Equilibria at large strain: Newton's method with a line search, along load steps as small as it takes."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix

from springopt.checks import Booleans, Floats
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.reference.body_among_effects import BodyAmongEffects
from springopt.reference.factor import Factor

#: The share of the load in the first step; steps double when Newton's method converges, and halve when it fails.
FIRST_STEP = 0.25
SMALLEST_STEP = 2.0**-10
MOST_ITERATIONS = 20
#: The residual that counts as none, as a share of the forces.
TOLERANCE = 1e-10
#: Rounding of the forces, as a share of the stiffness times the size of the body.
ROUNDING = 1e-14
MOST_HALVINGS = 10


class _StepFails(Exception):
    """A load step that can't be made, with the reason as the end of a sentence."""


@dataclass(frozen=True, eq=False)
class _Equilibrium:
    share: float  #: of the load
    displacements: Floats  #: [length], shape (n, d)
    factor: Factor | None  #: of the tangent of the free degrees of freedom; None where all are held


@dataclass(frozen=True, eq=False)
class FiniteStrain:
    """The equilibria of a body under one load case, which grows from nothing in proportion.

    Each is stable: the tangent of its free degrees of freedom is positive definite. A body that snaps through within
    a step may be found behind the snap, as it would be after a fall.
    """

    body: BodyAmongEffects
    case: LoadCase
    loads: Floats  #: of the load case and the effects [force], zero where something is held, shape (n, d)
    stiffness: csc_matrix  #: the tangent at rest [force / length], shape (n d, n d)
    size: float  #: of the body [length]

    def displacements(self) -> Floats:
        """At the whole load [length], shape (n, d); refuses a load without a stable equilibrium on the way to it."""
        found = self._at_rest()
        step = FIRST_STEP
        while found.share < 1.0:
            try:
                found = self._step(found, min(1.0, found.share + step))
                step *= 2
            except _StepFails as reason:
                step /= 2
                if step < SMALLEST_STEP:
                    raise UserError(
                        f"The reference finds no stable equilibrium in load case {self.case.name!r} beyond "
                        f"{found.share:.3g} of its load, where {reason}; reduce the load or change the mesh."
                    ) from None
        return found.displacements

    def _at_rest(self) -> _Equilibrium:
        rest = np.zeros(self.loads.shape)
        return _Equilibrium(0.0, rest, self._factor(self.stiffness))

    def _step(self, last: _Equilibrium, share: float) -> _Equilibrium:
        body = self.body.under(share)
        u = self._predicted(last, share)
        rounding = ROUNDING * self.stiffness.diagonal().max() * self.size
        for _ in range(MOST_ITERATIONS):
            factor = self._factor(body.tangent(u))
            if factor is not None and not factor.is_positive_definite:
                raise _StepFails("it becomes unstable")
            forces = body.internal_forces(u)
            residual = share * self.loads - forces
            scale = max(np.linalg.norm(share * self.loads), np.linalg.norm(forces))
            if np.linalg.norm(residual[self.free]) <= TOLERANCE * scale + rounding:
                return _Equilibrium(share, u, factor)
            u = self._searched(u, share, residual, self._solved(factor, residual))
        raise _StepFails("Newton's method does not converge")

    def _predicted(self, last: _Equilibrium, share: float) -> Floats:
        """Along the tangent of the last equilibrium, the supports moved to where they are to be."""
        moved = (share - last.share) * self.case.prescribed
        body = self.body.under(share)
        residual = share * self.loads - body.internal_forces(last.displacements)
        if moved.any():
            residual = residual - (body.tangent(last.displacements) @ moved.ravel()).reshape(moved.shape)
        u = last.displacements + moved + self._solved(last.factor, residual)
        if not self.body.is_admissible(u):
            raise _StepFails("an element turns inside out")
        return u

    def _searched(self, u: Floats, share: float, residual: Floats, direction: Floats) -> Floats:
        """As far along the direction as the force along it shrinks, halving from the whole of it."""
        slope, length = np.sum(residual * direction), 1.0
        for _ in range(MOST_HALVINGS):
            there = u + length * direction
            if self.body.is_admissible(there):
                left = np.sum((share * self.loads - self.body.under(share).internal_forces(there)) * direction)
                if abs(left) <= (1.0 - length / 10) * slope:
                    return there
            length /= 2
        raise _StepFails("an element turns inside out or Newton's method does not converge")

    def _solved(self, factor: Factor | None, residual: Floats) -> Floats:
        """Displacements of the free degrees of freedom, zero elsewhere, shape (n, d)."""
        solution = np.zeros(residual.shape)
        if factor is not None:
            solution[self.free] = factor.solve(residual[self.free])
        return solution

    def _factor(self, tangent: csc_matrix) -> Factor | None:
        free = np.flatnonzero(self.free)
        if not len(free):
            return None
        try:
            return Factor.of(tangent[free][:, free])
        except RuntimeError:  # singular to the last digit
            raise _StepFails("it becomes unstable") from None

    @property
    def free(self) -> Booleans:
        """The degrees of freedom that are not held, shape (n, d)."""
        return self.case.free
