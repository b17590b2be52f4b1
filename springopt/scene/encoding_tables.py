"""[encoding]: what the optimizer's numbers mean."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator

from springopt.encoding import ENCODINGS, Encoding
from springopt.lattice import SpringLattice
from springopt.scene.table import FittingTable, Numbers


class _EncodingTable(FittingTable):
    kind: str

    def try_on(self, lattice: SpringLattice) -> object:
        return self.build(lattice)

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
