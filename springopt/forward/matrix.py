"""What the engines ask of a matrix that can be factorized."""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Matrix(Protocol):
    """A symmetric matrix, or its factor once it was factorized; filled again and again."""

    entries: NDArray[Any]  #: where a layout puts its entries
    scale: Floats  #: what pivots are judged by, shape (at least unknowns,)
    inertia: Floats  #: of the last factor: negative and zero pivots, place and depth of the most negative one

    def clear(self) -> None:
        """All entries zero."""

    def factorize(self, replacement: float) -> None:
        """The matrix becomes its factor; pivots that are not positive are replaced by this times their scale."""

    def solve(self, sides: Floats) -> Floats:
        """The solutions for right-hand sides, shape (unknowns, 8)."""

    def negative_direction(self) -> Floats:
        """A direction of negative curvature, shape (unknowns,), where the factor has a negative pivot."""
