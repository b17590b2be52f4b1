"""L D L^T of one band matrix, and its solution for eight right-hand sides at once.

Column j begins at its diagonal, entry (i, j) at j * stride + i of one array: columns overlap, so that one row of
neighbouring columns lies equally in memory. The stride leaves room for what the vectors write beyond a column's end and
above its diagonal. Overwritten by C = L D, whose columns need no scaling; 1 / D apart. Pivots that are not safely
positive are counted and replaced as in `factor`. In single precision the same code makes a preconditioner.
"""

from typing import Any

from springopt.effects.compile import compiled
from springopt.forward.band_lanes import VECTOR_BYTES, add_scaled, dot_columns, eliminate, subtract_columns

PANEL = 16  # columns eliminated together
SOLVED = 8  # unknowns substituted together
SLACK = 64  # beyond the width, for vectors and panels


@compiled
def factorize_band(
    band: Any,
    size: int,
    width: int,
    stride: int,
    scale: Any,
    zero_pivot: float,
    replacement: float,
    inverse: Any,
    factors: Any,
    inertia: Any,
) -> None:
    """Overwrite the matrix by C, `inverse` (size,) by 1 / D; `size` a multiple of PANEL, identity where it is padded.

    `scale` (size,) is what pivots are judged by; `factors` (PANEL, width + SLACK) is scratch; `inertia` (4,) receives
    what `factor.factorize` writes for a lane.
    """
    step = VECTOR_BYTES // band.itemsize
    kind = band.dtype.type
    negative_count, zero_count, lowest_at, lowest = 0, 0, -1, -zero_pivot
    for begin in range(0, size, PANEL):
        end = begin + PANEL + width
        factors[:] = 0.0
        flat = factors.reshape(factors.size)
        for group in range(begin, begin + PANEL, 4):
            for j in range(group, group + 4):
                pivot, judge = float(band[j * stride + j]), scale[j]
                if not pivot > zero_pivot * judge:
                    if pivot < -zero_pivot * judge:
                        negative_count += 1
                        if pivot < lowest * judge:
                            lowest_at, lowest = j, pivot / judge
                    else:
                        zero_count += 1
                    pivot = max(abs(pivot), replacement * judge)
                inverse[j] = 1.0 / pivot
                row = (j - begin) * factors.shape[1]
                for i in range(begin, end, step):
                    add_scaled(flat, row + i - begin, band, j * stride + i, kind(-inverse[j]))
                for c in range(j + 1, group + 4):
                    factor = factors[j - begin, c - begin]
                    for i in range(begin, end, step):
                        add_scaled(band, c * stride + i, band, j * stride + i, factor)
            for c in range(group + 4, begin + PANEL, 4):
                for i in range(begin, end, step):
                    eliminate(4, band, c * stride + i, group * stride + i, stride, factors[group - begin :], c - begin)
        for c in range(begin + PANEL, min(size, end), 4):
            for i in range(c // step * step, end, step):
                eliminate(16, band, c * stride + i, begin * stride + i, stride, factors, c - begin)
    inertia[0], inertia[1], inertia[2], inertia[3] = negative_count, zero_count, lowest_at, lowest


@compiled
def substitute_band(band: Any, size: int, width: int, stride: int, inverse: Any, x: Any, sums: Any) -> None:
    """Overwrite the right-hand sides x (size, 8), numbers as in the band, by solutions; `sums` (8, 8) is scratch."""
    for begin in range(0, size, SOLVED):
        for j in range(begin, begin + SOLVED):
            for v in range(8):
                x[j, v] *= inverse[j]
            for i in range(j + 1, begin + SOLVED):
                entry = band[j * stride + i]
                for v in range(8):
                    x[i, v] -= entry * x[j, v]
        row = begin + SOLVED
        count = min(size, row + width) - row
        subtract_columns(8, x, row, count, band, begin * stride + row, stride, begin)
    for begin in range(size - SOLVED, -1, -SOLVED):
        row = begin + SOLVED
        count = min(size, row + width) - row
        dot_columns(8, sums, x, row, count, band, begin * stride + row, stride)
        for j in range(begin + SOLVED - 1, begin - 1, -1):
            for i in range(j + 1, begin + SOLVED):
                entry = band[j * stride + i]
                for v in range(8):
                    sums[j - begin, v] += entry * x[i, v]
            for v in range(8):
                x[j, v] -= inverse[j] * sums[j - begin, v]


@compiled
def negative_direction_band(band: Any, width: int, stride: int, inverse: Any, pivot: int, direction: Any) -> None:
    """Into `direction` (size,): y with L^T y = e_pivot, along which the energy curves down."""
    direction[:] = 0.0
    direction[pivot] = 1.0
    for j in range(pivot - 1, -1, -1):
        total = 0.0
        for i in range(j + 1, min(pivot, j + width) + 1):
            total += band[j * stride + i] * direction[i]
        direction[j] = -total * inverse[j]
