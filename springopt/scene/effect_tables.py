"""[[effects]]: what acts on the body beside its springs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from springopt.lattice import SpringLattice
from springopt.scene.table import FittingTable, Numbers

if TYPE_CHECKING:
    from springopt.effects.gravity import Gravity


class GravityTable(FittingTable):
    """A constant acceleration of every node."""

    kind: Literal["gravity"]
    acceleration: Numbers
    mass: Numbers = 1.0

    def try_on(self, lattice: SpringLattice) -> object:
        return self.build().constant_forces(lattice)

    def build(self) -> Gravity:
        from springopt.effects.gravity import Gravity

        return Gravity(**self.model_dump(exclude={"kind"}))
