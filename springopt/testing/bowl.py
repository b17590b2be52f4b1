"""An objective and an encoding without physics: they cost nothing, and the answer is known."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springopt.checks import Floats

if TYPE_CHECKING:
    from scipy.sparse.linalg import LinearOperator


@dataclass(frozen=True, eq=False)
class Bowl:
    """Half the squared distance from a centre."""

    center: Floats  #: where the value is zero, shape (s,)
    tolerance: float = 1e-8
    cases: tuple[Any, ...] = field(default=(SimpleNamespace(role="train"),))

    def evaluate(self, stiffness: Floats) -> Any:
        """Values and codes of stiffnesses, shape (m, s); all of them have an equilibrium."""
        values = 0.5 * np.square(stiffness - self.center).sum(axis=1)
        return SimpleNamespace(values=values, codes=np.zeros(len(values), dtype=np.int8))

    def gradient(self, stiffness: Floats) -> tuple[float, Floats]:
        residuals = self.residuals(stiffness)
        return self.value_of(residuals), residuals

    def residuals(self, stiffness: Floats) -> Floats:
        return stiffness - self.center

    def value_of(self, residuals: Floats) -> float:
        return 0.5 * float(np.square(residuals).sum())

    def jacobian(self, stiffness: Floats) -> tuple[Floats, Floats]:
        return self.residuals(stiffness), np.eye(len(stiffness))

    def linearize(self, stiffness: Floats) -> tuple[Floats, LinearOperator]:
        from scipy.sparse.linalg import aslinearoperator

        residuals, jacobian = self.jacobian(stiffness)
        return residuals, aslinearoperator(jacobian)


@dataclass(frozen=True, eq=False)
class Box:
    """An encoding that takes a point for the stiffness."""

    lower: Floats
    upper: Floats
    kind: Literal["real", "binary"] = "real"

    @property
    def size(self) -> int:
        return len(self.lower)

    @property
    def differentiable(self) -> bool:
        return self.kind == "real"

    @property
    def parameter_count(self) -> int:
        return 0

    def decode(self, points: ArrayLike) -> Floats:
        return np.asarray(points, dtype=float)

    def encode(self, stiffness: ArrayLike) -> Floats:
        point = np.clip(np.asarray(stiffness, dtype=float), self.lower, self.upper)
        return point.round() if self.kind == "binary" else point

    def pull_back(self, point: ArrayLike, gradient: ArrayLike) -> Floats:
        return np.asarray(gradient, dtype=float)

    def push_forward(self, point: ArrayLike, change: ArrayLike) -> Floats:
        return np.asarray(change, dtype=float)

    def sample(self, rng: np.random.Generator, count: int) -> NDArray[np.float64]:
        if self.kind == "binary":
            return rng.integers(0, 2, size=(count, self.size)).astype(float)
        return rng.uniform(self.lower, self.upper, size=(count, self.size))
