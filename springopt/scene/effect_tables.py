"""[[effects]]: what acts on the body beside its springs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import ValidationInfo, model_validator

from springopt.scene.table import Numbers, Table, faults_of_users, lattice_of

if TYPE_CHECKING:
    from springopt.effects.gravity import Gravity


class GravityTable(Table):
    """A constant acceleration of every node."""

    kind: Literal["gravity"]
    acceleration: Numbers
    mass: Numbers = 1.0

    @model_validator(mode="after")
    def _fits_lattice(self, info: ValidationInfo) -> GravityTable:
        lattice = lattice_of(info)
        if lattice is not None:
            with faults_of_users():
                self.build().constant_forces(lattice)
        return self

    def build(self) -> Gravity:
        from springopt.effects.gravity import Gravity

        return Gravity(**self.model_dump(exclude={"kind"}))
