"""What a solver is: how the matrices of large systems are stored, factorized and preconditioned.

A solver is made once for a set of supports and keeps the symbolic analysis; the matrices it hands out are filled again
and again, by one search at a time.
"""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from springopt.forward.layout import Layout

Floats = NDArray[np.float64]


class Matrix(Protocol):
    """A symmetric matrix, or its factor once it was factorized."""

    entries: NDArray[Any]  #: where a layout puts its entries
    scale: Floats  #: what pivots are judged by, shape (at least unknowns,)
    inertia: Floats  #: of the last factor: negative and zero pivots, place and depth of the most negative one

    def clear(self) -> None:
        """All entries zero."""

    def factorize(self, replacement: float) -> None:
        """The matrix becomes its factor; pivots that are not positive are replaced by this times their scale."""

    def solve(self, sides: Floats) -> Floats:
        """The solutions for up to eight right-hand sides, shape (unknowns, lanes)."""

    def negative_direction(self) -> Floats:
        """A direction of negative curvature, shape (unknowns,), where the factor has a negative pivot."""


class Solver(Protocol):
    """The linear algebra of an engine."""

    is_direct: bool  #: whether exact factors solve systems, or conjugate gradients must
    product_limit: int  #: after so many products a Newton system is better served by a factor of its own

    @property
    def layout(self) -> Layout:
        """Where entries go in its matrices."""

    def matrices(self) -> tuple[Any, Any]:
        """(a `Matrix` for exact factors, one for preconditioners)."""
