"""What angles push their three nodes with: arms p = x_b - x_a and q = x_c - x_b, with the turn between them.

Sines of the turn are told by displacements, which keeps the digits of small ones. `integers`: the number of angles, the
step in `values` from one angle's stiffness to the next, the nodes (a, b, c) of each. `numbers`: in 2D cosine and sine
of each turn at rest, in 3D the turn. Blocks: (a, a), (b, b), (c, c), (a, b), (b, c), (a, c).
"""

import math
from typing import Any

import numpy as np
from numba import njit

from springopt.effects.blocks import add, add_to_block, rows
from springopt.effects.compile import kernel
from springopt.effects.lanes import LANE_COUNT, fma, load, maximum, splat, sqrt, store, where_greater

# An arm below this share of its length at rest has no direction, as in `springs`.
COLLAPSED = 1e-9
# Nearer to a full fold, or in 3D to the line where that is not the state at rest, a turn has no direction.
FOLDED = 1e-9
# Below this turn the power series keeps more digits than the closed forms, with an error of its fourth term.
SMALL = 0.02


@njit(error_model="numpy")
def _take(d: int, nodes: Any, i: int, j: int, displacements: Any, now: Any, moved: Any, rest: Any) -> Any:
    """The vector from row i to row j, what it changed by, (d, 8), and at rest (d,); its length squared, not 0."""
    square, at_rest = splat(0.0), 0.0
    for a in range(d):
        rest[a] = nodes[j + a] - nodes[i + a]
        change = load(displacements, j + a) - load(displacements, i + a)
        vector = change + rest[a]
        store(moved, a, change)
        store(now, a, vector)
        square, at_rest = fma(vector, vector, square), at_rest + rest[a] * rest[a]
    return maximum(square, splat(COLLAPSED * COLLAPSED * at_rest))


@njit(error_model="numpy")
def _angle(scratch: Any, sine: Any, cosine: Any) -> Any:
    """atan2, lane by lane."""
    store(scratch, 0, sine)
    store(scratch, 1, cosine)
    for lane in range(LANE_COUNT):
        scratch[0, lane] = math.atan2(scratch[0, lane], scratch[1, lane])
    return load(scratch, 0)


@njit(error_model="numpy")
def _add_arms(
    d: int, integers: Any, at: int, places: Any, place: int, slopes: Any, blocks: Any, f: Any, k: Any
) -> None:
    """Forces and blocks of three nodes from the derivatives by p and q: slopes (2 d, 8), blocks pp, qq, pq."""
    node_a, node_b, node_c = integers[at] * d, integers[at + 1] * d, integers[at + 2] * d
    for a in range(d):
        by_p, by_q = load(slopes, a), load(slopes, d + a)
        add(f, node_a + a, by_p * -1.0)
        add(f, node_b + a, by_p - by_q)
        add(f, node_c + a, by_q)
        for b in range(d):
            pp, qq = load(blocks, a * d + b), load(blocks, (d + a) * d + b)
            pq, qp = load(blocks, (2 * d + a) * d + b), load(blocks, (2 * d + b) * d + a)
            add_to_block(k, places[place], d, a, b, pp)
            add_to_block(k, places[place + 1], d, a, b, pp - pq - qp + qq)
            add_to_block(k, places[place + 2], d, a, b, qq)
            add_to_block(k, places[place + 3], d, a, b, pq - pp)
            add_to_block(k, places[place + 4], d, a, b, pq - qq)
            add_to_block(k, places[place + 5], d, a, b, pq * -1.0)


@njit(error_model="numpy")
def _by_cosine(turn: Any, turned: Any, sine: Any, cosine: Any, is_straight: bool) -> Any:
    """First and second derivative of turned^2 / 2 by the cosine."""
    sine = maximum(sine, splat(FOLDED))
    ratio = turned / sine
    slope, bend = ratio * -1.0, (splat(1.0) - ratio * cosine) / (sine * sine)
    if not is_straight:
        return slope, bend
    # Turn / sine, and (1 - turn cosine / sine) / sine^2.
    square, small = turn * turn, splat(SMALL)
    series = fma(square, fma(square, splat(7.0 / 360.0), splat(1.0 / 6.0)), splat(1.0))
    bent = fma(square, fma(square, splat(2.0 / 63.0), splat(2.0 / 15.0)), splat(1.0 / 3.0))
    return where_greater(small, turn, series * -1.0, slope), where_greater(small, turn, bent, bend)


@kernel
def add_plane_angles(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """The turn is the direction of q less that of p; the derivative of one is q / |q|^2, turned by a right angle."""
    displacements, forces, tangent, energy, own = rows(u), rows(f), rows(k), rows(e), rows(values)
    arms, scratch = np.empty((4, 2, LANE_COUNT)), np.empty((2, LANE_COUNT))
    p, dp, q, dq = arms[0], arms[1], arms[2], arms[3]
    rest_p, rest_q = np.empty(2), np.empty(2)
    slopes, blocks = np.empty((4, LANE_COUNT)), np.empty((12, LANE_COUNT))
    for angle in range(integers[0]):
        at = 2 + 3 * angle
        node_a, node_b, node_c = integers[at] * 2, integers[at + 1] * 2, integers[at + 2] * 2
        p_square = _take(2, nodes, node_a, node_b, displacements, p, dp, rest_p)
        q_square = _take(2, nodes, node_b, node_c, displacements, q, dq, rest_q)
        sine_growth = (
            load(dq, 1) * rest_p[0] - load(dq, 0) * rest_p[1] + load(dp, 0) * load(q, 1) - load(dp, 1) * load(q, 0)
        )
        cosine_growth = (
            load(dq, 0) * rest_p[0] + load(dq, 1) * rest_p[1] + load(dp, 0) * load(q, 0) + load(dp, 1) * load(q, 1)
        )
        sine = load(p, 0) * load(q, 1) - load(p, 1) * load(q, 0)
        cosine = load(p, 0) * load(q, 0) + load(p, 1) * load(q, 1)
        rest_cosine, rest_sine = numbers[2 * angle], numbers[2 * angle + 1]
        turned = _angle(
            scratch,
            sine_growth * rest_cosine - cosine_growth * rest_sine,
            cosine * rest_cosine + sine * rest_sine,
        )
        kappa = load(own, angle * integers[1])
        moment = kappa * turned
        add(energy, 0, moment * turned * 0.5)
        for a in range(2):
            sign = -1.0 if a == 0 else 1.0
            store(slopes, a, load(p, 1 - a) * (-sign) / p_square)  # of the turn, first
            store(slopes, 2 + a, load(q, 1 - a) * sign / q_square)
        for a in range(2):
            for b in range(2):
                p_a, p_b, q_a, q_b = load(slopes, a), load(slopes, b), load(slopes, 2 + a), load(slopes, 2 + b)
                p_bent = (load(p, a) * p_b + p_a * load(p, b)) * -1.0 / p_square
                q_bent = (load(q, a) * q_b + q_a * load(q, b)) * -1.0 / q_square
                store(blocks, a * 2 + b, kappa * p_a * p_b + moment * p_bent)
                store(blocks, 4 + a * 2 + b, kappa * q_a * q_b + moment * q_bent)
                store(blocks, 8 + a * 2 + b, kappa * p_a * q_b)
        for a in range(4):
            store(slopes, a, moment * load(slopes, a))
        _add_arms(2, integers, at, places, 6 * angle, slopes, blocks, forces, tangent)


@kernel
def add_space_angles(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """A function H of the cosine c = t . s of the arms' directions t and s: regular where they are in line at rest."""
    displacements, forces, tangent, energy, own = rows(u), rows(f), rows(k), rows(e), rows(values)
    arms, scratch = np.empty((5, 3, LANE_COUNT)), np.empty((2, LANE_COUNT))
    p, dp, q, dq, cross = arms[0], arms[1], arms[2], arms[3], arms[4]
    rest_p, rest_q = np.empty(3), np.empty(3)
    slopes, blocks = np.empty((6, LANE_COUNT)), np.empty((27, LANE_COUNT))
    for angle in range(integers[0]):
        at, rest = 2 + 3 * angle, numbers[angle]
        node_a, node_b, node_c = integers[at] * 3, integers[at + 1] * 3, integers[at + 2] * 3
        p_length = sqrt(_take(3, nodes, node_a, node_b, displacements, p, dp, rest_p))
        q_length = sqrt(_take(3, nodes, node_b, node_c, displacements, q, dq, rest_q))
        square, cosine = splat(0.0), splat(0.0)
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            component = load(dq, c) * rest_p[b] - load(dq, b) * rest_p[c]
            component = component + load(dp, b) * load(q, c) - load(dp, c) * load(q, b)
            if rest != 0.0:  # in line it is 0, but for rounding
                component = component + (rest_p[b] * rest_q[c] - rest_p[c] * rest_q[b])
            store(cross, a, component)
            square = fma(component, component, square)
            cosine = fma(load(p, a), load(q, a), cosine)
        turn = _angle(scratch, sqrt(square), cosine)
        cosine, sine = cosine / (p_length * q_length), sqrt(square) / (p_length * q_length)
        turned = turn - rest
        kappa = load(own, angle * integers[1])
        add(energy, 0, kappa * turned * turned * 0.5)
        slope, bend = _by_cosine(turn, turned, sine, cosine, rest == 0.0)
        slope, bend = kappa * slope, kappa * bend
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            # s - c t and t - c s, free of cancellation, over the lengths: the derivatives of the cosine.
            of_p = (load(cross, b) * load(p, c) - load(cross, c) * load(p, b)) / (p_length * p_length * q_length)
            of_q = (load(q, b) * load(cross, c) - load(q, c) * load(cross, b)) / (q_length * q_length * p_length)
            store(slopes, a, of_p / p_length)
            store(slopes, 3 + a, of_q / q_length)
        for a in range(3):
            t_a, s_a = load(p, a) / p_length, load(q, a) / q_length
            p_a, q_a = load(slopes, a), load(slopes, 3 + a)
            for b in range(3):
                t_b, s_b = load(p, b) / p_length, load(q, b) / q_length
                p_b, q_b = load(slopes, b), load(slopes, 3 + b)
                unit = 1.0 if a == b else 0.0
                pp = (t_a * p_b + p_a * t_b) / p_length + cosine * (splat(unit) - t_a * t_b) / (p_length * p_length)
                qq = (s_a * q_b + q_a * s_b) / q_length + cosine * (splat(unit) - s_a * s_b) / (q_length * q_length)
                pq = (splat(unit) - s_a * s_b) / (p_length * q_length) - t_a * q_b / p_length
                store(blocks, a * 3 + b, bend * p_a * p_b - slope * pp)
                store(blocks, 9 + a * 3 + b, bend * q_a * q_b - slope * qq)
                store(blocks, 18 + a * 3 + b, bend * p_a * q_b + slope * pq)
        for a in range(6):
            store(slopes, a, slope * load(slopes, a))
        _add_arms(3, integers, at, places, 6 * angle, slopes, blocks, forces, tangent)
