"""Parameters of effects beside the springs' stiffness, as unknowns of their own behind those of another encoding."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springopt.checks import Floats
from springopt.encoding.encoding import Encoding
from springopt.errors import UserError


@dataclass(frozen=True)
class Fitted:
    """Parameters of effects that have one and the same value, and its interval."""

    names: tuple[str, ...]  #: as "volume.modulus"
    count: int  #: how many numbers the value has
    lower: float
    upper: float

    def __post_init__(self) -> None:
        if not (np.isfinite([self.lower, self.upper]).all() and self.lower < self.upper):
            raise UserError(
                f"{' and '.join(self.names)} should lie between a lower and a higher finite bound, but the bounds are "
                f"[{self.lower:g}, {self.upper:g}]."
            )


class WithParameters(Encoding):
    """The stiffness as another encoding has it, then the parameters of effects as they are.

    Points decode to rows (m, s + f): the stiffness, and behind it the value of each name in the order of `names`.

    Args:
        springs: the encoding of the stiffness, of real numbers.
        fitted: what is found beside it.
    """

    name: ClassVar[str] = "parameters"

    def __init__(self, springs: Encoding, fitted: Sequence[Fitted]) -> None:
        if springs.kind != "real":
            raise UserError(
                f"parameters of effects are found beside a stiffness of real numbers, and the {springs.name} encoding "
                "has bits; choose the encoding 'real', or a homogeneous one."
            )
        self.springs, self.fitted = springs, tuple(fitted)
        self.classes = springs.classes
        counts = [each.count for each in fitted]
        self.lower = np.concatenate([springs.lower, np.repeat([each.lower for each in fitted], counts)])
        self.upper = np.concatenate([springs.upper, np.repeat([each.upper for each in fitted], counts)])
        # Of each column behind the stiffness, which unknown of those behind the springs' it is.
        first = np.cumsum([0, *counts])
        self._unknowns = np.concatenate(
            [np.arange(first[i], first[i + 1]) for i, each in enumerate(fitted) for _ in each.names]
        )

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters in the order of their columns."""
        return tuple(name for each in self.fitted for name in each.names)

    @property
    def parameter_count(self) -> int:
        return len(self._unknowns)

    def decode(self, points: ArrayLike) -> Floats:
        springs, rest = self._split(self._points(points))
        return np.concatenate([self.springs.decode(springs), rest[..., self._unknowns]], axis=-1)

    def encode(self, stiffness: ArrayLike) -> Floats:
        """The closest point to a row (s + f,), or to a stiffness (s,) alone: then parameters are in their middle."""
        row = np.asarray(stiffness, dtype=float)
        middle = self._split((self.lower + self.upper) / 2)[1]
        count = self.springs.decode(self.springs.lower).shape[-1]
        if len(row) > count:
            sums = np.bincount(self._unknowns, row[count:], len(middle))
            middle = sums / np.bincount(self._unknowns, minlength=len(middle))
        point = np.concatenate([self.springs.encode(row[:count]), middle])
        return np.clip(point, self.lower, self.upper)

    def present(self, point: ArrayLike) -> NDArray[np.bool_]:
        return self.springs.present(self._split(self._points(point))[0])

    def pull_back(self, point: ArrayLike, gradient: ArrayLike) -> Floats:
        point, gradient = np.asarray(point, dtype=float), np.asarray(gradient, dtype=float)
        count = gradient.shape[-1] - self.parameter_count
        springs = self.springs.pull_back(self._split(point)[0], gradient[..., :count])
        is_of = self._unknowns[:, None] == np.arange(self.size - self.springs.size)
        return np.concatenate([springs, gradient[..., count:] @ is_of], axis=-1)

    def push_forward(self, point: ArrayLike, change: ArrayLike) -> Floats:
        springs, rest = self._split(np.asarray(change, dtype=float))
        moved = self.springs.push_forward(self._split(np.asarray(point, dtype=float))[0], springs)
        return np.concatenate([moved, rest[self._unknowns]])

    def describe(self, point: ArrayLike) -> dict[str, dict[str, float]]:
        return self.springs.describe(self._split(self._points(point))[0])

    def parameters(self, point: ArrayLike) -> dict[str, list[float]]:
        rest = self._split(self._points(point))[1]
        ends = np.cumsum([each.count for each in self.fitted])[:-1]
        values = np.split(rest, ends)
        return {name: value.tolist() for each, value in zip(self.fitted, values, strict=True) for name in each.names}

    def parameter_intervals(self) -> dict[str, list[float]]:
        return {name: [each.lower, each.upper] for each in self.fitted for name in each.names}

    def _split(self, points: Floats) -> tuple[Floats, Floats]:
        return points[..., : self.springs.size], points[..., self.springs.size :]
