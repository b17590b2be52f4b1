"""[encoding]: what the optimizer's numbers mean."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, ValidationInfo, model_validator

from springopt.encoding import ENCODINGS, Encoding
from springopt.lattice import SpringLattice
from springopt.scene.table import Numbers, Table, faults_of_users, lattice_of


class _EncodingTable(Table):
    kind: str

    @model_validator(mode="after")
    def _builds(self, info: ValidationInfo) -> _EncodingTable:
        lattice = lattice_of(info)
        if lattice is not None:
            with faults_of_users():
                self.build(lattice)
        return self

    def build(self, lattice: SpringLattice) -> Encoding:
        return ENCODINGS[self.kind](lattice, **self.model_dump(exclude={"kind"}))


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


EncodingTable = Annotated[BinaryTable | RealTable | GroupedTable, Discriminator("kind")]
