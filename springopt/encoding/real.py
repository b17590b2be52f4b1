"""Stiffness and topology at once: one number a spring."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springopt.checks import Floats
from springopt.encoding.encoding import Encoding, box, require_springs
from springopt.encoding.spring_classes import known_classes
from springopt.errors import UserError
from springopt.lattice import SpringLattice


class Real(Encoding):
    """A spring is present where its number exceeds the threshold; section 4 of Bianchi et al. (2004).

    The threshold acts when a result is reported: during the search a number is a stiffness, so that the objective has
    derivatives everywhere and all optimizers minimize the same function.

    Args:
        lattice: the springs that may be present.
        lower, upper: interval of the stiffness [force/length], numbers or shape (s,).
        threshold: a spring whose number is at most this one is reported as absent.
    """

    name: ClassVar[str] = "real"

    def __init__(
        self, lattice: SpringLattice, *, lower: ArrayLike = 0.0, upper: ArrayLike = 10.0, threshold: float = 0.0
    ) -> None:
        self.lower, self.upper = box(lower, upper, require_springs(self.name, lattice.spring_count))
        if not 0 <= threshold < self.upper.min():
            raise UserError(
                f"the threshold of the real encoding lies in [0, {self.upper.min():g}), below every upper bound, "
                f"not at {threshold:g}; lower it."
            )
        self.threshold = float(threshold)
        self.classes = known_classes(lattice)

    def decode(self, points: ArrayLike) -> Floats:
        return self._points(points).copy()

    def encode(self, stiffness: ArrayLike) -> Floats:
        return np.clip(np.asarray(stiffness, dtype=float), self.lower, self.upper)

    def present(self, point: ArrayLike) -> NDArray[np.bool_]:
        """The springs (s,) above the threshold."""
        return self._points(point) > self.threshold

    def pull_back(self, point: ArrayLike, gradient: ArrayLike) -> Floats:
        return np.asarray(gradient, dtype=float)

    def push_forward(self, point: ArrayLike, change: ArrayLike) -> Floats:
        return np.asarray(change, dtype=float)
