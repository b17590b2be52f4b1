"""L D L^T factors of eight tangents at once, in envelope storage by node blocks.

Block row I holds the d x d blocks from its first neighbour `first[I]` to the diagonal, contiguous from block
`start[I]`; block entries are rows of an array (rows, 8), see `effects.lanes`. A pivot that is not safely positive is
counted and replaced by a positive one, so that the step that follows still goes downhill (Gill and Murray 1974). There
are no square roots, so that factors scale with powers of two to the bit.
"""

from typing import Any

from numba import njit

from springopt.effects.lanes import absolute, load, maximum, splat, store, subtract_block_products, where_greater

# Pivots within this share of the stiffness that meets at their node count as zero: rounding leaves up to some 1e-15,
# and stiffness contrasts of 1e12 must pass.
ZERO_PIVOT = 1e-13
HUGE = 1e300


@njit(error_model="numpy")
def _subtract(d: int, sums: Any, target: int, lefts: Any, left: int, rights: Any, right: int, count: int) -> None:
    if d == 2:
        subtract_block_products(2, sums, target, lefts, left, rights, right, count)
    else:
        subtract_block_products(3, sums, target, lefts, left, rights, right, count)


@njit(error_model="numpy")
def _reduce_row(d: int, first: Any, start: Any, tangent: Any, row: int, scaled: Any) -> None:
    """The blocks L D left of the diagonal of one block row, into `scaled` (blocks d d, 8)."""
    begin, block = first[row], d * d
    for k in range((row - begin) * block):
        store(scaled, k, load(tangent, start[row] * block + k))
    for column in range(begin, row):
        at, common = (column - begin) * block, max(begin, first[column])
        right = (start[column] + common - first[column]) * block
        _subtract(d, scaled, at, scaled, (common - begin) * block, tangent, right, column - common)
        diagonal = (start[column] + column - first[column]) * block
        for a in range(0, block, d):
            for b in range(1, d):
                entry = load(scaled, at + a + b)
                for c in range(b):
                    entry = entry - load(scaled, at + a + c) * load(tangent, diagonal + b * d + c)
                store(scaled, at + a + b, entry)


@njit(error_model="numpy")
def factorize(plan: Any, tangent: Any, inverse: Any, scaled: Any, scale: Any, replacement: Any, inertia: Any) -> None:
    """Overwrite the tangents by L (its unit diagonal not stored), `inverse` (B d, 8) by the inverse pivots.

    `scale` (B d, 8) is the stiffness that meets at each degree of freedom; a pivot that is not safely positive becomes
    max(|pivot|, replacement * scale). `inertia` (3, 8) receives the number of negative pivots, of zero pivots, and the
    lowest pivot in relation to its scale. `scaled` is scratch. The pivots themselves stay on the diagonals.
    """
    d, first, start = plan.dimension, plan.first, plan.start
    block, zero, one = d * d, splat(0.0), splat(1.0)
    negative_count, zero_count = zero, zero
    lowest, lowest_scale = splat(HUGE), one
    for row in range(len(first)):
        begin = first[row]
        _reduce_row(d, first, start, tangent, row, scaled)
        k, left = 0, start[row] * block
        for column in range(begin, row):
            for _ in range(d):
                for b in range(d):
                    store(tangent, left + k, load(scaled, k) * load(inverse, column * d + b))
                    k += 1
        diagonal = (start[row] + row - begin) * block
        _subtract(d, tangent, diagonal, scaled, 0, tangent, left, row - begin)
        for b in range(d):
            at = row * d + b
            pivot, stiffness = load(tangent, diagonal + b * d + b), load(scale, at)
            threshold = stiffness * ZERO_PIVOT
            is_negative = where_greater(zero - threshold, pivot, one, zero)
            is_positive = where_greater(pivot, threshold, one, zero)
            negative_count = negative_count + is_negative
            zero_count = zero_count + (one - is_negative - is_positive)
            # pivot / stiffness < lowest / lowest_scale, without dividing
            theirs, ours = lowest * stiffness, pivot * lowest_scale
            lowest = where_greater(theirs, ours, pivot, lowest)
            lowest_scale = where_greater(theirs, ours, stiffness, lowest_scale)
            replaced = maximum(absolute(pivot), stiffness * replacement)
            inverse_pivot = one / where_greater(pivot, threshold, pivot, replaced)
            store(inverse, at, inverse_pivot)
            for a in range(b + 1, d):
                entry = load(tangent, diagonal + a * d + b)
                unscaled = entry * inverse_pivot
                for c in range(b + 1, a + 1):
                    k = diagonal + a * d + c
                    # Column b of row c is scaled already where c < a; for c = a it is `unscaled`.
                    other = unscaled if c == a else load(tangent, diagonal + c * d + b)
                    store(tangent, k, load(tangent, k) - entry * other)
                store(tangent, diagonal + a * d + b, unscaled)
    store(inertia, 0, negative_count)
    store(inertia, 1, zero_count)
    store(inertia, 2, lowest / lowest_scale)


@njit(error_model="numpy")
def substitute(plan: Any, factor: Any, inverse: Any, x: Any) -> None:
    """Overwrite the right-hand sides x (B d, 8) by the solutions of the factorized systems."""
    d, first, start = plan.dimension, plan.first, plan.start
    for row in range(len(first)):
        for a in range(d):
            total = load(x, row * d + a)
            entry = start[row] * d * d + a * d
            for column in range(first[row], row):
                for b in range(d):
                    total = total - load(factor, entry + b) * load(x, column * d + b)
                entry += d * d
            for b in range(a):
                total = total - load(factor, entry + b) * load(x, row * d + b)
            store(x, row * d + a, total)
    for at in range(len(inverse)):
        store(x, at, load(x, at) * load(inverse, at))
    for row in range(len(first) - 1, -1, -1):
        for a in range(d - 1, -1, -1):
            value = load(x, row * d + a)
            entry = start[row] * d * d + a * d
            for column in range(first[row], row):
                for b in range(d):
                    at = column * d + b
                    store(x, at, load(x, at) - load(factor, entry + b) * value)
                entry += d * d
            for b in range(a):
                at = row * d + b
                store(x, at, load(x, at) - load(factor, entry + b) * value)


@njit(error_model="numpy")
def pivot_of(plan: Any, factor: Any, lane: int, at: int) -> float:
    """The pivot of one unknown of one lane, as the factorization found it."""
    d, row = plan.dimension, at // plan.dimension
    return factor[(plan.start[row] + row - plan.first[row]) * d * d + (at % d) * (d + 1), lane]


@njit(error_model="numpy")
def pivot_direction(plan: Any, factor: Any, lane: int, pivot: int, direction: Any) -> None:
    """Into one lane of `direction` (B d, 8): y with L^T y = e_pivot, so that y^T K y is the pivot.

    Less what the replacement of earlier pivots added: along y of a negative pivot the energy curves at least as much
    down. y is zero behind the pivot.
    """
    d = plan.dimension
    for at in range(len(direction)):
        direction[at, lane] = 0.0
    direction[pivot, lane] = 1.0
    for at in range(pivot, -1, -1):
        row, a = at // d, at % d
        value = direction[at, lane]
        if value == 0.0:
            continue
        entry = plan.start[row] * d * d + a * d
        for column in range(plan.first[row], row):
            for b in range(d):
                direction[column * d + b, lane] -= factor[entry + b, lane] * value
            entry += d * d
        for b in range(a):
            direction[row * d + b, lane] -= factor[entry + b, lane] * value
