"""What cells push their corners with when their volume changes.

Positions are taken from the first corner of a cell. Volumes are homogeneous polynomials of them, so the change V - V0
is told by gradients G: w . (G(at rest) + G(now)) / 2 in 2D, less w . G(w) / 6 in 3D, with the displacements w. That
keeps the digits of small ones.

`integers`: the number of cells, of corners v, the step in `values` from one cell's modulus to the next; in 3D the table
of `volume._listed`; the corners of all cells. `numbers`: in 3D the weights of that table; of each cell its volume at
rest and its gradient there. Blocks of a cell: of each corner, then of each pair of corners p < q.
"""

from typing import Any

import numpy as np
from numba import njit

from springopt.effects.blocks import add, add_to_block, rows
from springopt.effects.compile import kernel
from springopt.effects.lanes import LANE_COUNT, fma, load, splat, store


@njit(error_model="numpy")
def _take(
    d: int, corners: int, nodes: Any, integers: Any, first: int, displacements: Any, moved: Any, now: Any
) -> None:
    """Displacements and positions (v d, 8) of the corners of one cell, from its first corner."""
    origin = integers[first] * d
    for p in range(corners):
        row = integers[first + p] * d
        for a in range(d):
            w = load(displacements, row + a) - load(displacements, origin + a)
            store(moved, p * d + a, w)
            store(now, p * d + a, w + (nodes[row + a] - nodes[origin + a]))


@njit(error_model="numpy")
def _add_push(
    d: int, corners: int, integers: Any, first: int, places: Any, place: int, state: Any, f: Any, k: Any
) -> None:
    """Forces pressure * G on the corners, and of the tangent what comes from the change of the pressure."""
    gradient, pressure, modulus = state
    for p in range(corners):
        for a in range(d):
            add(f, integers[first + p] * d + a, pressure * load(gradient, p * d + a))
    pair = corners
    for p in range(corners):
        for q in range(p, corners):
            at = places[place + p] if p == q else places[place + pair]
            for a in range(d):
                along = modulus * load(gradient, p * d + a)
                for b in range(d):
                    add_to_block(k, at, d, a, b, along * load(gradient, q * d + b))
            if p != q:
                pair += 1


@kernel
def add_areas(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """Polygons: the area's gradient at a corner is half the way from the one before to the one behind, turned."""
    displacements, forces, tangent, energy, moduli = rows(u), rows(f), rows(k), rows(e), rows(values)
    cells, corners, stride = integers[0], integers[1], integers[2]
    per_cell = corners * (corners + 1) // 2
    scratch = np.empty((3, corners * 2, LANE_COUNT))
    moved, now, gradient = scratch[0], scratch[1], scratch[2]
    for cell in range(cells):
        first, rest, place = 3 + cell * corners, cell * (1 + 2 * corners), cell * per_cell
        _take(2, corners, nodes, integers, first, displacements, moved, now)
        growth = splat(0.0)
        for p in range(corners):
            behind, before = (p + 1) % corners * 2, (p + corners - 1) % corners * 2
            for a in range(2):
                across = (load(now, behind + 1 - a) - load(now, before + 1 - a)) * (0.5 if a == 0 else -0.5)
                store(gradient, p * 2 + a, across)
                growth = fma(load(moved, p * 2 + a), (across + numbers[rest + 1 + p * 2 + a]) * 0.5, growth)
        modulus = load(moduli, cell * stride) / numbers[rest]
        pressure = modulus * growth
        add(energy, 0, pressure * growth * 0.5)
        _add_push(2, corners, integers, first, places, place, (gradient, pressure, modulus), forces, tangent)
        pair = place + corners
        for p in range(corners):
            for q in range(p + 1, corners):
                if q == p + 1 or q == p + corners - 1:
                    turned = pressure * (0.5 if q == p + 1 else -0.5)
                    add_to_block(tangent, places[pair], 2, 0, 1, turned)
                    add_to_block(tangent, places[pair], 2, 1, 0, turned * -1.0)
                pair += 1


@njit(error_model="numpy")
def _find_gradients(corners: int, integers: Any, numbers: Any, x: Any, partners: Any, gradient: Any) -> None:
    """For positions x (3 v, 8): s_pq = sum of C_pqr x_r of each pair p < q, and G_p = sum of x_q x s_pq / 2."""
    for row in range(corners * 3):
        store(gradient, row, splat(0.0))
    pair, term, terms = 0, 0, 4 + corners * (corners - 1) // 2
    for p in range(corners):
        for q in range(p + 1, corners):
            s0, s1, s2 = splat(0.0), splat(0.0), splat(0.0)
            while term < integers[4 + pair]:
                r, weight = integers[terms + term] * 3, splat(numbers[term])
                s0 = fma(weight, load(x, r), s0)
                s1 = fma(weight, load(x, r + 1), s1)
                s2 = fma(weight, load(x, r + 2), s2)
                term += 1
            store(partners, pair * 3, s0)
            store(partners, pair * 3 + 1, s1)
            store(partners, pair * 3 + 2, s2)
            _add_cross(gradient, p, x, q, 0.5, s0, s1, s2)
            _add_cross(gradient, q, x, p, -0.5, s0, s1, s2)
            pair += 1


@njit(error_model="numpy")
def _add_cross(target: Any, p: int, x: Any, q: int, weight: float, s0: Any, s1: Any, s2: Any) -> None:
    """target_p += weight x_q x s."""
    x0, x1, x2 = load(x, q * 3), load(x, q * 3 + 1), load(x, q * 3 + 2)
    add(target, p * 3, (x1 * s2 - x2 * s1) * weight)
    add(target, p * 3 + 1, (x2 * s0 - x0 * s2) * weight)
    add(target, p * 3 + 2, (x0 * s1 - x1 * s0) * weight)


@kernel
def add_volumes(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """Bodies of triples of corners: dG_p / dx_q is v -> v x s_pq."""
    displacements, forces, tangent, energy, moduli = rows(u), rows(f), rows(k), rows(e), rows(values)
    cells, corners, stride, terms = integers[0], integers[1], integers[2], integers[3]
    pairs = corners * (corners - 1) // 2
    scratch = np.empty((4, corners * 3, LANE_COUNT))
    moved, now, gradient, of_moved = scratch[0], scratch[1], scratch[2], scratch[3]
    partners = np.empty((pairs * 3, LANE_COUNT))
    for cell in range(cells):
        first, place = 4 + pairs + terms + cell * corners, cell * (corners + pairs)
        rest = terms + cell * (1 + 3 * corners)
        _take(3, corners, nodes, integers, first, displacements, moved, now)
        _find_gradients(corners, integers, numbers, moved, partners, of_moved)
        _find_gradients(corners, integers, numbers, now, partners, gradient)
        growth = splat(0.0)
        for row in range(corners * 3):
            mean = (load(gradient, row) + numbers[rest + 1 + row]) * 0.5 - load(of_moved, row) * (1.0 / 6.0)
            growth = fma(load(moved, row), mean, growth)
        modulus = load(moduli, cell * stride) / numbers[rest]
        pressure = modulus * growth
        add(energy, 0, pressure * growth * 0.5)
        _add_push(3, corners, integers, first, places, place, (gradient, pressure, modulus), forces, tangent)
        for pair in range(pairs):
            at = places[place + corners + pair]
            for a in range(3):
                b, c = (a + 1) % 3, (a + 2) % 3
                turned = pressure * load(partners, pair * 3 + c)
                add_to_block(tangent, at, 3, a, b, turned)
                add_to_block(tangent, at, 3, b, a, turned * -1.0)
