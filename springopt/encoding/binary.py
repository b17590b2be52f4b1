"""Topology alone: one bit a spring."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from springopt.checks import Floats, require_positive
from springopt.encoding.encoding import Encoding, one_each, require_springs
from springopt.encoding.spring_classes import known_classes
from springopt.errors import UserError
from springopt.lattice import SpringLattice


class Binary(Encoding):
    """A spring is present with a given stiffness, or absent; section 3 of Bianchi et al. (2004).

    Args:
        lattice: the springs that may be present.
        stiffness: stiffness of a spring that is present [force/length], one number or shape (s,).
    """

    name: ClassVar[str] = "binary"
    kind: ClassVar[Literal["real", "binary"]] = "binary"
    differentiable: ClassVar[bool] = False

    def __init__(self, lattice: SpringLattice, *, stiffness: ArrayLike = 5.0) -> None:
        count = require_springs(self.name, lattice.spring_count)
        self.stiffness = require_positive("stiffness", one_each("stiffness", stiffness, count))
        self.lower, self.upper = np.zeros(count), np.ones(count)
        self.classes = known_classes(lattice)

    def decode(self, points: ArrayLike) -> Floats:
        bits = self._points(points)
        if not ((bits == 0) | (bits == 1)).all():
            raise UserError("points of the binary encoding hold zeros and ones alone; round them before asking.")
        return bits * self.stiffness

    def encode(self, stiffness: ArrayLike) -> Floats:
        """A spring is present above half of its stiffness."""
        return (np.asarray(stiffness, dtype=float) > 0.5 * self.stiffness).astype(float)

    def pull_back(self, point: ArrayLike, gradient: ArrayLike) -> Floats:
        """The derivative along the straight line from absent to present."""
        return np.asarray(gradient, dtype=float) * self.stiffness

    def push_forward(self, point: ArrayLike, change: ArrayLike) -> Floats:
        return np.asarray(change, dtype=float) * self.stiffness

    def sample(self, rng: np.random.Generator, count: int) -> Floats:
        """Fair bits, shape (count, size)."""
        return rng.integers(0, 2, size=(count, self.size)).astype(float)
