"""A symmetric factorization that says whether the matrix is positive definite."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu

from springopt.checks import Floats


@dataclass(frozen=True, eq=False)
class Factor:
    """L U of a symmetric matrix, (f, f), with pivots on the diagonal as far as it has no zero there."""

    superlu: SuperLU

    @classmethod
    def of(cls, matrix: csc_matrix) -> Self:
        """Raises RuntimeError where the matrix is singular to the last digit."""
        return cls(splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}))

    def solve(self, right: Floats) -> Floats:
        """Shape (f,)."""
        return self.superlu.solve(right)

    @property
    def is_positive_definite(self) -> bool:
        """By Sylvester's law of inertia: with pivots on the diagonal U's is the D of L D L^T."""
        is_symmetric = np.array_equal(self.superlu.perm_r, self.superlu.perm_c)
        return is_symmetric and bool((self.superlu.U.diagonal() > 0).all())
