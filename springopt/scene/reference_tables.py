"""[reference]: whose deformation is to be matched."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Discriminator, Field, ValidationInfo, field_validator

from springopt.checks import Booleans, Floats, require_nonnegative
from springopt.errors import SceneError
from springopt.lattice import SpringLattice
from springopt.scene.table import FittingTable, Numbers, Table, fault, lattice_of

if TYPE_CHECKING:
    from springopt.effects.effect import Effect
    from springopt.model import Model
    from springopt.reference import Reference

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Seed = Annotated[int, Field(ge=0)]


class NoiseTable(Table):
    """Normal noise in what the training load cases show of the reference."""

    deviation: Positive
    seed: Seed = 0


class _ReferenceTable(FittingTable):
    noise: NoiseTable | None = None


class FemTable(_ReferenceTable):
    """Elasticity on the cells of the lattice, at small or large strain; what acts from outside acts on it too."""

    kind: Literal["fem"]
    young: Positive
    poisson: float
    plane: Literal["stress", "strain"] = "stress"
    thickness: Positive = 1.0
    law: Literal["linear", "saint-venant-kirchhoff", "neo-hookean"] = "linear"
    formulation: Literal["standard", "b-bar"] = "standard"
    order: Literal[1, 2] = 1
    refinements: Annotated[int, Field(ge=0)] = 0
    density: Positive | None = None
    mass_damping: NotNegative = 0.0
    stiffness_damping: NotNegative = 0.0
    lumped: bool = False

    def build(self, model: Model) -> Reference:
        return self._reference(model.lattice, [effect for effect in model.effects if effect.acts_from_outside])

    def try_on(self, lattice: SpringLattice) -> Reference:
        return self._reference(lattice, [])

    def _reference(self, lattice: SpringLattice, effects: list[Effect]) -> Reference:
        from springopt.reference.fem import FemReference

        return FemReference(lattice, effects=effects, **self.model_dump(exclude={"kind", "noise"}))


class _SpringsTable(_ReferenceTable):
    """A mass-spring model, by the stiffness of its springs."""

    def try_on(self, lattice: SpringLattice) -> object:
        return self.spring_stiffness(lattice)

    @abstractmethod
    def spring_stiffness(self, lattice: SpringLattice) -> Floats:
        """Stiffness [force/length], shape (s,), zero for springs that are not there."""

    def build(self, model: Model) -> Reference:
        from springopt.reference.spring import SpringReference

        return SpringReference(model, self.spring_stiffness(model.lattice))


class SpringTable(_SpringsTable):
    """A mass-spring model of known stiffness, on the springs of the lattice less those that are absent."""

    kind: Literal["spring"]
    stiffness: Numbers
    absent: list[int] = Field(default_factory=list)
    absent_directions: list[list[float]] = Field(default_factory=list)

    @field_validator("absent_directions")
    @classmethod
    def _fit_dimension(cls, directions: list[list[float]], info: ValidationInfo) -> list[list[float]]:
        lattice = lattice_of(info)
        for direction in directions:
            if not any(direction) or (lattice is not None and len(direction) != lattice.dimension):
                raise fault(f"should be directions with one number an axis and not all zero, but has {direction}")
        return directions

    def spring_stiffness(self, lattice: SpringLattice) -> Floats:
        count = lattice.spring_count
        if isinstance(self.stiffness, list) and len(self.stiffness) != count:
            raise SceneError(f"stiffness is one number or one for each of {count} springs, not {len(self.stiffness)}")
        wrong = [spring for spring in self.absent if not 0 <= spring < count]
        if wrong:
            raise SceneError(f"absent names springs 0 to {count - 1}, not {wrong[0]}")
        given = require_nonnegative("stiffness", np.array(self.stiffness, dtype=float))
        stiffness = np.array(np.broadcast_to(given, (count,)))
        stiffness[self.absent] = 0.0
        for direction in self.absent_directions:
            stiffness[_parallel(lattice, np.array(direction))] = 0.0
        return stiffness


class RandomSpringsTable(_SpringsTable):
    """A mass-spring model drawn at random from the springs of the lattice."""

    kind: Literal["random-springs"]
    seed: Seed
    stiffness: list[float]
    kept: Annotated[float, Field(gt=0, le=1)] = 1.0
    anisotropy: list[float] | None = None

    def spring_stiffness(self, lattice: SpringLattice) -> Floats:
        from springopt.reference.random_springs import random_stiffness

        return random_stiffness(lattice, **self.model_dump(exclude={"kind", "noise"}))


def _parallel(lattice: SpringLattice, direction: Floats) -> Booleans:
    spans = lattice.nodes[lattice.springs[:, 1]] - lattice.nodes[lattice.springs[:, 0]]
    lengths = np.linalg.norm(spans, axis=1) * np.linalg.norm(direction)
    return np.abs(spans @ direction) >= lengths * (1 - 1e-9)


ReferenceTable = Annotated[FemTable | SpringTable | RandomSpringsTable, Discriminator("kind")]
