"""What a candidate is beside bare stiffness: the parameters of effects by name."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from springopt.checks import Floats, floats, require_finite, require_shape
from springopt.errors import UserError


@dataclass(frozen=True, eq=False)
class Parameters:
    """Stiffness and named parameters of effects, of one candidate or of many."""

    stiffness: Floats  #: [force/length], shape (s,), or (m, s) of m candidates
    #: "effect.parameter" to its value: one number or (k,), of m candidates (m,) or (m, k).
    values: Mapping[str, ArrayLike] = field(default_factory=dict)

    def __post_init__(self) -> None:
        stiffness = floats("stiffness", self.stiffness)
        if stiffness.ndim not in (1, 2):
            raise UserError(f"stiffness must have the shape (s,) or (m, s), not {stiffness.shape}.")
        if not isinstance(self.values, Mapping):
            raise UserError(f"values must be a dictionary from names of parameters, not {type(self.values).__name__}.")
        object.__setattr__(self, "stiffness", stiffness)
        object.__setattr__(self, "values", {name: self._checked(name, value) for name, value in self.values.items()})

    def _checked(self, name: str, value: ArrayLike) -> Floats:
        """Shape (k,), or (m, k) of m candidates."""
        array = require_finite(name, floats(name, value))
        leading = self.stiffness.shape[:-1]
        if array.ndim == len(leading):
            array = array[..., None]
        return require_shape(name, array, (*leading, "k"))

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.values)

    def rows(self) -> Floats:
        """Stiffness, then the values in their order, shape (m, s + f); of one candidate (1, s + f)."""
        columns = [self.stiffness, *(np.asarray(value) for value in self.values.values())]
        return np.atleast_2d(np.concatenate(columns, axis=-1))

    def like(self, row: Floats) -> "Parameters":
        """The numbers (..., s + f) of a row, as those of one candidate here."""
        stiffness, rest = np.split(row, [self.stiffness.shape[-1]], axis=-1)
        ends = np.cumsum([np.shape(value)[-1] for value in self.values.values()])[:-1]
        parts = np.split(rest, ends, axis=-1) if self.values else []
        return Parameters(stiffness, dict(zip(self.values, parts, strict=True)))
