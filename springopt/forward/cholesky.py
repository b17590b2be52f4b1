"""Cholesky factors of eight tangents at once, in envelope storage by node blocks.

Block row I holds the d x d blocks from its first neighbour `first[I]` to the diagonal, contiguous from block
`start[I]`; block entries are rows of an array (rows, 8), see `effects.lanes`. A pivot that is not safely positive is
counted and replaced by a positive one, so that the step that follows still goes downhill (Gill and Murray 1974).
"""

from typing import Any

from numba import njit

from springopt.effects.lanes import (
    absolute,
    load,
    maximum,
    splat,
    sqrt,
    store,
    subtract_block_products,
    where_greater,
)

# Pivots within this share of the stiffness that meets at their node count as zero: rounding leaves up to some 1e-15,
# and stiffness contrasts of 1e12 must pass.
ZERO_PIVOT = 1e-13


@njit(error_model="numpy")
def _eliminate(d: int, first: Any, start: Any, tangent: Any, target: int, row: int, column: int) -> None:
    """Subtract from block (row, column) the products of the blocks left of it."""
    begin = max(first[row], first[column])
    if begin >= column:
        return
    left = (start[row] + begin - first[row]) * d * d
    right = (start[column] + begin - first[column]) * d * d
    if d == 2:
        subtract_block_products(2, tangent, target, left, right, column - begin)
    else:
        subtract_block_products(3, tangent, target, left, right, column - begin)


@njit(error_model="numpy")
def _divide_by_diagonal(d: int, tangent: Any, target: int, diagonal: int, inverse: Any, column: int) -> None:
    """Block at row `target` = block times the inverse transposed of the diagonal factor at row `diagonal`."""
    for a in range(d):
        row = target + a * d
        for b in range(d):
            entry = load(tangent, row + b)
            for c in range(b):
                entry = entry - load(tangent, row + c) * load(tangent, diagonal + b * d + c)
            store(tangent, row + b, entry * load(inverse, column * d + b))


@njit(error_model="numpy")
def factorize(plan: Any, tangent: Any, inverse: Any, scale: Any, replacement: float, inertia: Any) -> None:
    """Overwrite the tangents by their factors, `inverse` (B d, 8) by the inverse diagonal.

    `scale` (B d, 8) is the stiffness that meets at each degree of freedom; a pivot that is not safely positive becomes
    max(|pivot|, replacement * scale). `inertia` (4, 8) receives the number of negative pivots, of zero pivots, the
    unknown with the most negative pivot in relation to its scale (-1: none), and that relation.
    """
    d, first, start = plan.dimension, plan.first, plan.start
    zero, one = splat(0.0), splat(1.0)
    negative_count, zero_count, lowest_at, lowest = zero, zero, splat(-1.0), splat(-ZERO_PIVOT)
    for row in range(len(first)):
        for column in range(first[row], row):
            target = (start[row] + column - first[row]) * d * d
            diagonal = (start[column] + column - first[column]) * d * d
            _eliminate(d, first, start, tangent, target, row, column)
            _divide_by_diagonal(d, tangent, target, diagonal, inverse, column)
        target = (start[row] + row - first[row]) * d * d
        _eliminate(d, first, start, tangent, target, row, row)
        for b in range(d):
            at = row * d + b
            pivot = load(tangent, target + b * d + b)
            for c in range(b):
                left = load(tangent, target + b * d + c)
                pivot = pivot - left * left
            threshold = load(scale, at) * ZERO_PIVOT
            is_negative = where_greater(zero - threshold, pivot, one, zero)
            is_positive = where_greater(pivot, threshold, one, zero)
            relative = pivot / load(scale, at)
            lowest_at = where_greater(lowest, relative, splat(float(at)), lowest_at)
            lowest = where_greater(lowest, relative, relative, lowest)
            negative_count = negative_count + is_negative
            zero_count = zero_count + (one - is_negative - is_positive)
            replaced = maximum(absolute(pivot), load(scale, at) * replacement)
            root = sqrt(where_greater(pivot, threshold, pivot, replaced))
            inverse_root = one / root
            store(tangent, target + b * d + b, root)
            store(inverse, at, inverse_root)
            for a in range(b + 1, d):
                entry = load(tangent, target + a * d + b)
                for c in range(b):
                    entry = entry - load(tangent, target + a * d + c) * load(tangent, target + b * d + c)
                store(tangent, target + a * d + b, entry * inverse_root)
    store(inertia, 0, negative_count)
    store(inertia, 1, zero_count)
    store(inertia, 2, lowest_at)
    store(inertia, 3, lowest)


@njit(error_model="numpy")
def substitute(plan: Any, factor: Any, inverse: Any, x: Any) -> None:
    """Overwrite the right-hand sides x (B d, 8) by the solutions of the factorized systems."""
    d, first, start = plan.dimension, plan.first, plan.start
    for row in range(len(first)):
        begin = first[row]
        for a in range(d):
            total = load(x, row * d + a)
            entry = start[row] * d * d + a * d
            for column in range(begin, row):
                for b in range(d):
                    total = total - load(factor, entry + b) * load(x, column * d + b)
                entry += d * d
            for b in range(a):
                total = total - load(factor, entry + b) * load(x, row * d + b)
            store(x, row * d + a, total * load(inverse, row * d + a))
    for row in range(len(first) - 1, -1, -1):
        begin = first[row]
        diagonal = (start[row] + row - begin) * d * d
        for a in range(d - 1, -1, -1):
            total = load(x, row * d + a)
            for b in range(a + 1, d):
                total = total - load(factor, diagonal + b * d + a) * load(x, row * d + b)
            total = total * load(inverse, row * d + a)
            store(x, row * d + a, total)
            entry = start[row] * d * d + a * d
            for column in range(begin, row):
                for b in range(d):
                    at = column * d + b
                    store(x, at, load(x, at) - load(factor, entry + b) * total)
                entry += d * d


@njit(error_model="numpy")
def negative_direction(plan: Any, factor: Any, inverse: Any, lane: int, pivot: int, direction: Any) -> None:
    """Into one lane of `direction` (B d, 8): y with L^T y = e_pivot scaled to 1 there; the energy curves down along it.

    y^T K y is the negative pivot, less what the replacement of earlier pivots added: at least as negative.
    """
    d = plan.dimension
    for at in range(len(direction)):
        direction[at, lane] = 0.0
    direction[pivot, lane] = 1.0
    for at in range(pivot, -1, -1):
        row, a = at // d, at % d
        if at < pivot:
            direction[at, lane] *= inverse[at, lane]
        value = direction[at, lane]
        entry = plan.start[row] * d * d + a * d
        for column in range(plan.first[row], row):
            for b in range(d):
                direction[column * d + b, lane] -= factor[entry + b, lane] * value
            entry += d * d
        for b in range(a):
            direction[row * d + b, lane] -= factor[entry + b, lane] * value
