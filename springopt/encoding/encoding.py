"""What every encoding offers: an optimizer's vector becomes one stiffness per spring."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springopt.checks import Floats, floats, require_shape
from springopt.encoding.spring_classes import SpringClasses, summarize
from springopt.errors import UserError


class Encoding(ABC):
    """A map from points of a box to the stiffness and topology of a lattice.

    Attributes:
        name: what a scene calls it.
        kind: "real" for a box of numbers, "binary" for bits (0 or 1, kept as floats).
        differentiable: whether the stiffness has a derivative by the point; then `pull_back` applies it.
        lower, upper: corners of the box, shape (size,).
        classes: masks over the springs, shape (s,) each, that `describe` reports on.
    """

    name: ClassVar[str]
    kind: ClassVar[Literal["real", "binary"]] = "real"
    differentiable: ClassVar[bool] = True
    lower: Floats
    upper: Floats
    classes: SpringClasses

    @property
    def size(self) -> int:
        """How many numbers the optimizer sees."""
        return len(self.lower)

    @property
    def parameter_count(self) -> int:
        """How many columns of a decoded row are parameters of effects, behind the stiffness."""
        return 0

    def parameters(self, point: ArrayLike) -> dict[str, list[float]]:
        """The parameters of effects at a point, by name."""
        return {}

    def parameter_intervals(self) -> dict[str, list[float]]:
        """The lower and the upper bound of each of these parameters, by name."""
        return {}

    @abstractmethod
    def decode(self, points: ArrayLike) -> Floats:
        """Stiffness [force/length], shape (m, s), of points, shape (m, size); (s,) of a single point."""

    @abstractmethod
    def encode(self, stiffness: ArrayLike) -> Floats:
        """The point (size,) of the box whose stiffness is closest to this one (s,), by the sum of squares."""

    def present(self, point: ArrayLike) -> NDArray[np.bool_]:
        """Which springs (s,) a report of this point calls present."""
        return self.decode(point) > 0

    @abstractmethod
    def pull_back(self, point: ArrayLike, gradient: ArrayLike) -> Floats:
        """The chain rule: derivatives by stiffness, shape (..., s), become derivatives by point, shape (..., size)."""

    @abstractmethod
    def push_forward(self, point: ArrayLike, change: ArrayLike) -> Floats:
        """The derivative of the stiffness, shape (s,), along a change of the point, shape (size,)."""

    def sample(self, rng: np.random.Generator, count: int) -> Floats:
        """Points drawn uniformly from the box, shape (count, size)."""
        return rng.uniform(self.lower, self.upper, size=(count, self.size))

    def describe(self, point: ArrayLike) -> dict[str, dict[str, float]]:
        """For each class of springs: how many there are and are present, their mean stiffness and its spread."""
        return summarize(np.where(self.present(point), self.decode(point), 0.0), self.classes)

    def _points(self, points: ArrayLike) -> Floats:
        array = np.asarray(points, dtype=float)
        if array.ndim not in (1, 2) or array.shape[-1] != self.size:
            raise UserError(
                f"points of the {self.name} encoding have shape ({self.size},) or (m, {self.size}), "
                f"not {array.shape}; give {self.size} numbers a point."
            )
        return array


def require_springs(name: str, count: int) -> int:
    """Refuses to encode the stiffness of no springs."""
    if count == 0:
        raise UserError(f"the {name} encoding needs springs, but this lattice has none; give it springs to learn.")
    return count


def box(lower: ArrayLike, upper: ArrayLike, size: int) -> tuple[Floats, Floats]:
    """The corners of a box of stiffness, shape (size,) each, from numbers or arrays; refuses an empty box."""
    low, high = one_each("lower", lower, size), one_each("upper", upper, size)
    legal = (low >= 0) & (low < high) & np.isfinite(high)
    if not legal.all():
        i = int(np.argmin(legal))
        raise UserError(
            f"the bounds of unknown {i} are [{low[i]:g}, {high[i]:g}]; a stiffness needs finite 0 <= lower < upper."
        )
    return low, high


def one_each(name: str, values: ArrayLike, size: int) -> Floats:
    """Shape (size,), from one number for all or one for each."""
    array = floats(name, values)
    return np.repeat(array, size) if array.ndim == 0 else require_shape(name, array, (size,))
