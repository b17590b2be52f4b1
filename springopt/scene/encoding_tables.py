"""[encoding]: what the optimizer's numbers mean."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field

from springopt.encoding import ENCODINGS, Encoding, Fitted, WithParameters
from springopt.errors import SceneError, UserError
from springopt.lattice import SpringLattice
from springopt.scene.table import FittingTable, Numbers, Table

if TYPE_CHECKING:
    from springopt.model import Model


class ParameterTable(Table):
    """Parameters of effects that are found beside the stiffness, in an interval; several names share one value."""

    name: Annotated[
        list[str], Field(min_length=1), BeforeValidator(lambda name: [name] if isinstance(name, str) else name)
    ]
    lower: float
    upper: float


class _EncodingTable(FittingTable):
    kind: str
    parameters: list[ParameterTable] = Field(default_factory=list)

    @property
    def fitted(self) -> tuple[str, ...]:
        """The parameters of effects that are found, in their order."""
        return tuple(name for table in self.parameters for name in table.name)

    def build_for(self, model: Model) -> Encoding:
        """The encoding of the stiffness, and of the parameters of the model's effects."""
        springs = self.build(model.lattice)
        return (
            WithParameters(springs, [_fitted(table, model) for table in self.parameters])
            if self.parameters
            else springs
        )

    def try_on(self, lattice: SpringLattice) -> object:
        springs = self.build(lattice)
        # How many numbers a parameter has only the effects know; bits and bounds are wrong whatever their number.
        fitted = [Fitted(tuple(table.name), 1, table.lower, table.upper) for table in self.parameters]
        return WithParameters(springs, fitted) if fitted else springs

    def build(self, lattice: SpringLattice) -> Encoding:
        return ENCODINGS[self.kind](lattice, **self.model_dump(exclude={"kind", "parameters"}))


class BinaryTable(_EncodingTable):
    """A spring is present with this stiffness, or absent."""

    kind: Literal["binary"]
    stiffness: Numbers


class RealTable(_EncodingTable):
    """A stiffness for every spring; the report keeps those above the threshold."""

    kind: Literal["real"]
    lower: float = 0.0
    upper: float
    threshold: float = 0.0


class GroupedTable(_EncodingTable):
    """A stiffness for every class of springs."""

    kind: Literal["homogeneous", "two-class", "three-class"]
    lower: float = 0.0
    upper: float


def _fitted(table: ParameterTable, model: Model) -> Fitted:
    counts = {name: model.terms.count(name) for name in table.name}
    if len(set(counts.values())) > 1:
        said = ", ".join(f"{name} has {count}" for name, count in counts.items())
        raise SceneError(f"parameters with one value should have as many numbers each, but {said}; name them apart.")
    for name in table.name:
        try:
            model.terms.require_allowed(name, np.array([table.lower, table.upper]))
        except UserError as error:
            raise SceneError(f"the bounds of {name} are [{table.lower:g}, {table.upper:g}], but {error}") from None
    return Fitted(tuple(table.name), counts[table.name[0]], table.lower, table.upper)


EncodingTable = Annotated[BinaryTable | RealTable | GroupedTable, Discriminator("kind")]
