"""One number for a whole class of springs."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from springopt.checks import Floats
from springopt.encoding.encoding import Encoding, box, require_springs
from springopt.encoding.spring_classes import (
    SpringClasses,
    all_springs,
    inner_boundary_diagonal,
    straight_diagonal,
)
from springopt.errors import UserError
from springopt.lattice import SpringLattice


class Grouped(Encoding):
    """Springs of one class share their stiffness.

    Args:
        classes: name and mask over the springs, shape (s,), of each class; every spring is in exactly one.
        lower, upper: interval of the stiffness [force/length], numbers or one for each class.
    """

    name: ClassVar[str] = "grouped"

    def __init__(self, classes: SpringClasses, *, lower: ArrayLike = 0.0, upper: ArrayLike = 10.0) -> None:
        self.classes = classes
        self.membership = np.array(list(classes.values()), dtype=float)
        require_springs(self.name, self.membership.size)
        self._require_partition()
        self.lower, self.upper = box(lower, upper, len(classes))

    def decode(self, points: ArrayLike) -> Floats:
        return self._points(points) @ self.membership

    def encode(self, stiffness: ArrayLike) -> Floats:
        """The mean of each class, clipped: classes share no spring, so that each has its own least squares."""
        means = self.membership @ np.asarray(stiffness, dtype=float) / self.membership.sum(axis=1)
        return np.clip(means, self.lower, self.upper)

    def pull_back(self, point: ArrayLike, gradient: ArrayLike) -> Floats:
        return np.asarray(gradient, dtype=float) @ self.membership.T

    def push_forward(self, point: ArrayLike, change: ArrayLike) -> Floats:
        return np.asarray(change, dtype=float) @ self.membership

    def _require_partition(self) -> None:
        for name, mask in self.classes.items():
            if not np.any(mask):
                raise UserError(
                    f"the {self.name} encoding needs springs in each of its classes, but this lattice has no "
                    f"{name} springs; choose another encoding or neighbourhood."
                )
        if (self.membership.sum(axis=0) != 1).any():
            i = int(np.argmax(self.membership.sum(axis=0) != 1))
            raise UserError(f"the {self.name} encoding needs every spring in exactly one class; look at spring {i}.")


class Homogeneous(Grouped):
    """One stiffness for all springs; Table 1 of Bianchi et al. (2004)."""

    name: ClassVar[str] = "homogeneous"

    def __init__(self, lattice: SpringLattice, *, lower: ArrayLike = 0.0, upper: ArrayLike = 10.0) -> None:
        super().__init__(all_springs(lattice), lower=lower, upper=upper)


class TwoClass(Grouped):
    """One stiffness for straight springs, one for diagonal ones; Table 1 of Bianchi et al. (2004)."""

    name: ClassVar[str] = "two-class"

    def __init__(self, lattice: SpringLattice, *, lower: ArrayLike = 0.0, upper: ArrayLike = 10.0) -> None:
        super().__init__(straight_diagonal(lattice), lower=lower, upper=upper)


class ThreeClass(Grouped):
    """Inner straight, boundary straight and diagonal springs: the boundary carries half a cell.

    Not in the paper: it explains the two peaks of the paper's Figure 4.
    """

    name: ClassVar[str] = "three-class"

    def __init__(self, lattice: SpringLattice, *, lower: ArrayLike = 0.0, upper: ArrayLike = 10.0) -> None:
        super().__init__(inner_boundary_diagonal(lattice), lower=lower, upper=upper)
