"""Systems beyond direct solution: multigrid (smoothed aggregation) in place of factors, and what it can certify.

A V-cycle on the tangent at rest preconditions the conjugate gradients. No factor tells the inertia of an answer's
tangent; LOBPCG seeks its smallest eigenvalues, in relation to the stiffness that meets at each unknown. A negative one
is proof of a saddle, and its vector the way down. A positive one is strong evidence of a minimum and no proof: a
smaller eigenvalue may have hidden from the search.
"""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, csr_matrix, diags_array
from scipy.sparse.linalg import LinearOperator, lobpcg

from springopt.forward.layout import Layout, lay_out
from springopt.forward.pattern import Pattern, PatternMatrix
from springopt.forward.plan import Plan

Floats = NDArray[np.float64]

# Eigenvalues within this share of the stiffness count as zero.
ZERO_EIGENVALUE = 1e-10
SOUGHT = 4  # eigenvalues at once, so that near ones do not hide behind each other
SEARCH_LIMIT = 200
# Makes a tangent at rest that is singular solvable; a preconditioner may be off by that much.
REST_SHIFT = 1e-8
# Of which warnings show, and of NumPy's global random numbers, all threads together have one.
_SETTINGS = Lock()


@dataclass(eq=False)
class Multigrid(PatternMatrix):
    """A V-cycle in the place of a factor; changes itself when it is made."""

    modes: Floats  #: rigid motions, shape (unknowns, 3 or 6)
    _cycle: Any = field(init=False, default=None)

    def factorize(self, replacement: float) -> None:
        """Set up the V-cycle of the matrix; nothing is replaced."""
        from pyamg import smoothed_aggregation_solver

        matrix = whole_matrix(self.pattern, self.entries, self.scale, REST_SHIFT)
        with _SETTINGS, _same_random_numbers():
            hierarchy = smoothed_aggregation_solver(csr_matrix(matrix), B=self.modes, symmetry="symmetric")
        self._cycle = hierarchy.aspreconditioner(cycle="V")

    def solve(self, sides: Floats) -> Floats:
        """One V-cycle for each right-hand side that is not zero."""
        solution = np.zeros_like(sides)
        for k in np.flatnonzero(sides.any(axis=0)).tolist():
            solution[:, k] = self._cycle.matvec(np.ascontiguousarray(sides[:, k]))
        return solution

    def negative_direction(self) -> Floats:
        raise AssertionError("a preconditioner tells nothing of curvature")


@dataclass(eq=False)
class Eigenpairs(PatternMatrix):
    """The smallest eigenvalues of a matrix in the place of its inertia."""

    preconditioner: Multigrid
    _lowest: Floats = field(init=False)

    def factorize(self, replacement: float) -> None:
        """Seek the smallest eigenvalues; the inertia counts the negative and the zero ones among them."""
        matrix = whole_matrix(self.pattern, self.entries, self.scale, 0.0)
        size = len(self.scale)
        start = np.random.default_rng(0).normal(size=(size, min(SOUGHT, size)))
        preconditioner = LinearOperator((size, size), matvec=self._precondition, matmat=self._precondition)
        with _SETTINGS, warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # what it found is judged below
            scale = diags_array(self.scale)
            values, vectors = lobpcg(
                matrix, start, B=scale, M=preconditioner, largest=False, tol=1e-7, maxiter=SEARCH_LIMIT
            )
        lowest = int(np.argmin(values))
        self._lowest = np.asarray(vectors[:, lowest], dtype=np.float64)
        empty_count = np.count_nonzero(self.entries[self.pattern.diagonal] == 0.0)
        self.inertia[:] = (
            np.count_nonzero(values < -ZERO_EIGENVALUE),
            np.count_nonzero(np.abs(values) <= ZERO_EIGENVALUE) + empty_count,
            -1.0,
            values[lowest],
        )

    def _precondition(self, sides: Floats) -> Floats:
        return self.preconditioner.solve(sides.reshape(len(self.scale), -1)).reshape(sides.shape)

    def solve(self, sides: Floats) -> Floats:
        """Where conjugate gradients fail: the preconditioned residual, which is a way down."""
        return self.preconditioner.solve(sides)

    def negative_direction(self) -> Floats:
        return self._lowest


@dataclass(frozen=True, eq=False)
class MultigridSolver:
    """No factors; see `solver`."""

    plan: Plan
    is_direct = False
    product_limit = 1000

    @cached_property
    def pattern(self) -> Pattern:
        return Pattern.of(self.plan, is_dissected=False)

    @cached_property
    def layout(self) -> Layout:
        return lay_out(self.plan, self.pattern.position)

    def matrices(self) -> tuple[Eigenpairs, Multigrid]:
        preconditioner = Multigrid(self.pattern, rigid_motions(self.plan))
        return Eigenpairs(self.pattern, preconditioner), preconditioner


def whole_matrix(pattern: Pattern, entries: Floats, scale: Floats, shift: float) -> csr_array:
    """Both halves; nodes without springs and pinned unknowns get their scale on the diagonal."""
    matrix = csr_array(
        (entries[pattern.whole.data - 1], pattern.whole.indices, pattern.whole.indptr), shape=pattern.whole.shape
    )
    diagonal = matrix.diagonal()
    matrix.setdiag(np.where(diagonal == 0.0, scale, diagonal + shift * scale))
    return matrix


def rigid_motions(plan: Plan) -> Floats:
    """Translations and small rotations of the free nodes, shape (unknowns, 3 or 6): what smooth errors look like."""
    d = plan.dimension
    nodes = np.empty((len(plan.first), d))
    is_free = plan.block_of >= 0
    nodes[plan.block_of[is_free]] = plan.nodes[is_free] - plan.nodes[is_free].mean(axis=0)
    nodes /= np.abs(nodes).max(initial=1e-300)
    motions = [np.tile(np.eye(d)[a], (len(nodes), 1)) for a in range(d)]
    for a in range(d):
        for b in range(a + 1, d):
            turn = np.zeros_like(nodes)
            turn[:, a], turn[:, b] = -nodes[:, b], nodes[:, a]
            motions.append(turn)
    modes = np.stack([motion.ravel() for motion in motions], axis=1)
    modes[plan.pinned] = 0.0
    return modes


@contextmanager
def _same_random_numbers() -> Iterator[None]:
    """pyamg estimates spectral radii from NumPy's global random numbers; answers must not depend on them."""
    before = np.random.get_state()  # noqa: NPY002
    np.random.seed(0)  # noqa: NPY002
    try:
        yield
    finally:
        np.random.set_state(before)  # noqa: NPY002
