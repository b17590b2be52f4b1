"""What all tables of a scene share: strict types, no unknown keys, and the lattice at hand while they are checked."""

from __future__ import annotations

import sys
from abc import abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, PlainValidator, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from springopt.errors import UserError
from springopt.lattice import SpringLattice


class Table(BaseModel):
    """One table of a scene."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def fault(sentence: str) -> PydanticCustomError:
    """A fault of the table or key that is being checked."""
    return PydanticCustomError("fault", "{sentence}", {"sentence": sentence})


@contextmanager
def faults_of_users() -> Iterator[None]:
    """What the library refuses in the body becomes a fault of the table that is being checked."""
    try:
        yield
    except UserError as error:
        raise fault(str(error)) from error


def parse_numbers(value: Any) -> float | list[float]:
    """One number, or a list with one for each of something."""
    numbers = value if isinstance(value, list) else [value]
    if not all(isinstance(number, int | float) and not isinstance(number, bool) for number in numbers) or not all(
        abs(number) <= sys.float_info.max for number in numbers
    ):
        raise fault(f"should be a finite number or a list of such, but is {value!r}")
    return [float(number) for number in numbers] if isinstance(value, list) else float(value)


Numbers = Annotated[float | list[float], PlainValidator(parse_numbers)]


def lattice_of(info: ValidationInfo) -> SpringLattice | None:
    """The lattice of the scene; None while only types are checked, or where the lattice itself has faults."""
    context: dict[str, SpringLattice] = info.context or {}
    return context.get("lattice")


class FittingTable(Table):
    """A table that must fit the lattice of its scene."""

    @model_validator(mode="after")
    def _fits_lattice(self, info: ValidationInfo) -> Self:
        lattice = lattice_of(info)
        if lattice is not None:
            with faults_of_users():
                self.try_on(lattice)
        return self

    @abstractmethod
    def try_on(self, lattice: SpringLattice) -> object:
        """Raises UserError where it does not fit."""
