"""A band matrix in memory, and its factor: how large systems are solved directly."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springopt.effects.lanes import LANE_COUNT
from springopt.forward.band_kernels import PANEL, SLACK, factorize_band, negative_direction_band, substitute_band
from springopt.forward.factor import ZERO_PIVOT
from springopt.forward.layout import Layout, lay_out
from springopt.forward.plan import Plan

# Of single precision; such factors only precondition.
ZERO_PIVOT_SINGLE = 1e-5


@dataclass(frozen=True, eq=False)
class Band:
    """A symmetric matrix of `unknowns` rows, its lower half within `width` below the diagonal, or its factor.

    One is made per thread and kind of number, and filled again and again.
    """

    unknowns: int
    width: int
    size: int  #: unknowns, and padding
    stride: int
    entries: NDArray[Any]  #: see `band_kernels`
    inverse: NDArray[Any]  #: (size,), inverse pivots
    scale: NDArray[np.float64]  #: (size,), what pivots are judged by
    factors: NDArray[Any]  #: scratch
    sums: NDArray[Any]  #: scratch
    sides: NDArray[Any]  #: (size, 8), right-hand sides
    inertia: NDArray[np.float64]  #: (4,), see `factor.factorize`

    @classmethod
    def empty(cls, unknowns: int, width: int, kind: Any) -> "Band":
        size, stride = _round_up(unknowns, PANEL), cls.stride_of(width)
        return cls(
            unknowns=unknowns,
            width=width,
            size=size,
            stride=stride,
            entries=_aligned((size + 8) * stride + size + stride, kind),
            inverse=np.ones(size, dtype=kind),
            scale=np.ones(size),
            factors=_aligned(PANEL * _round_up(width + SLACK, PANEL), kind).reshape(PANEL, -1),
            sums=np.zeros((8, LANE_COUNT), dtype=kind),
            sides=_aligned(size * LANE_COUNT, kind).reshape(size, LANE_COUNT),
            inertia=np.zeros(4),
        )

    @staticmethod
    def stride_of(width: int) -> int:
        """Entries from one column to the next."""
        return _round_up(width + SLACK, PANEL)

    def clear(self) -> None:
        """All zero, with ones on the padding's diagonal."""
        self.entries[:] = 0.0
        padding = np.arange(self.unknowns, self.size)
        self.entries[padding * self.stride + padding] = 1.0

    def factorize(self, replacement: float) -> None:
        """The matrix becomes its factor; what pivots were found is in `inertia`."""
        zero = ZERO_PIVOT if self.entries.itemsize == 8 else ZERO_PIVOT_SINGLE
        factorize_band(
            self.entries,
            self.size,
            self.width,
            self.stride,
            self.scale,
            zero,
            replacement,
            self.inverse,
            self.factors,
            self.inertia,
        )

    def solve(self, sides: NDArray[np.float64]) -> NDArray[np.float64]:
        """The solutions for up to eight right-hand sides, shape (unknowns, lanes)."""
        lanes = sides.shape[1]
        self.sides[:] = 0.0
        self.sides[: self.unknowns, :lanes] = sides
        substitute_band(self.entries, self.size, self.width, self.stride, self.inverse, self.sides, self.sums)
        return self.sides[: self.unknowns, :lanes].astype(np.float64)

    def negative_direction(self) -> NDArray[np.float64]:
        """A direction of negative curvature, from the most negative pivot, shape (unknowns,)."""
        direction = np.zeros(self.size)
        pivot = int(self.inertia[2])
        negative_direction_band(self.entries, self.width, self.stride, self.inverse, pivot, direction)
        return direction[: self.unknowns]


def half_bandwidth(plan: Plan) -> int:
    """How far below the diagonal the tangent reaches, in the plan's order."""
    widest = int((np.arange(len(plan.first)) - plan.first).max(initial=0))
    return widest * plan.dimension + plan.dimension - 1


@dataclass(frozen=True, eq=False)
class BandSolver:
    """Band factors in the plan's order, in single precision to precondition; see `solver`."""

    plan: Plan
    is_direct = True
    # A product with its preconditioning costs about an eighth of a factor, and serves up to eight load cases.
    product_limit = 25

    @cached_property
    def layout(self) -> Layout:
        stride = Band.stride_of(half_bandwidth(self.plan))
        return lay_out(self.plan, lambda row, column: column * stride + row)

    def matrices(self) -> tuple[Band, Band]:
        size, width = len(self.plan.first) * self.plan.dimension, half_bandwidth(self.plan)
        return Band.empty(size, width, np.float64), Band.empty(size, width, np.float32)


def _round_up(count: int, multiple: int) -> int:
    return -(-count // multiple) * multiple


def _aligned(count: int, kind: Any) -> NDArray[Any]:
    """Zeros that begin at a multiple of 64 bytes, where vectors load fastest."""
    numbers = np.zeros(count + 64, dtype=kind)
    first = (-numbers.ctypes.data % 64) // numbers.itemsize
    return numbers[first : first + count]
