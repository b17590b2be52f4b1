"""What the search does in one large system: forces of eight load cases at once, products and matrices of the tangent.

The load cases of one candidate are the lanes. The tangent is not stored: `cache` (s, 2, 8) keeps two numbers a spring,
from which products with it and matrices of single lanes are made.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from springopt.effects.compile import compiled
from springopt.effects.lanes import absolute, fma, load, maximum, splat, store
from springopt.effects.springs import elongation, tension_per_length
from springopt.forward.courses import keep_accepted, move, set_courses, take_directions
from springopt.forward.evaluation import call_all, sum_up
from springopt.forward.judges import judge_lanes, settle
from springopt.forward.queue import refill
from springopt.forward.state import ENERGY


class Tangents(NamedTuple):
    """What is kept of the tangents of eight lanes at their trial states."""

    cache: NDArray[np.float64]  # (2 s, 8): tension per length, and what is to be added along the spring, over length^2
    coupled: NDArray[np.float64]  # (q d d, 8): what effects brought, in the blocks that `Plan.coupled` lists


@compiled
def arrive(
    plan: Any,
    jobs: Any,
    state: Any,
    tangents: Any,
    answers: Any,
    tolerance: float,
    iteration_limit: int,
) -> bool:
    """Lanes take up jobs, are evaluated at their trial states, and judged; False when all jobs are done."""
    if not refill(plan, jobs, state):
        return False
    evaluate_forces(plan, state, tangents)
    judge_lanes(plan, state, answers, tolerance, iteration_limit)
    keep_accepted(state)
    return True


@compiled
def aim(plan: Any, state: Any, tolerance: float) -> None:
    """The solutions in `unknowns` become directions; lanes that get no further are to be certified."""
    take_directions(state)
    settle(plan, state, tolerance)


@compiled
def depart(plan: Any, state: Any, answers: Any) -> None:
    """Lanes that were certified are put down, the others go to their next trial states."""
    set_courses(plan, state, answers)
    move(plan, state)


@compiled
def evaluate_forces(plan: Any, state: Any, tangents: Any) -> None:
    """Energy, residual and force scale at the trial states, and what the tangents are made of."""
    d, lane, internal, trial = plan.dimension, state.scalars, state.internal, state.trial
    ends, rest_vectors, cache, delta = plan.ends, plan.rest_vectors, tangents.cache, state.delta
    internal[:] = 0.0
    energy = splat(0.0)
    for spring in range(len(ends)):
        i, j = ends[spring, 0] * d, ends[spring, 1] * d
        natural, k = plan.natural_lengths[spring], load(state.stiffness, spring)
        length, longer = elongation(
            trial, i, j, rest_vectors, spring, plan.lengths[spring], natural, plan.prestrains[spring], delta
        )
        tension, length = tension_per_length(k, natural, length, longer)
        store(cache, 2 * spring, tension)
        store(cache, 2 * spring + 1, (k - tension) / (length * length))
        energy = fma(k * longer, longer * 0.5, energy)
        for a in range(d):
            force = tension * load(delta, a)
            store(internal, j + a, load(internal, j + a) + force)
            store(internal, i + a, load(internal, i + a) - force)
    store(lane, ENERGY, energy)
    if len(plan.potentials.table):
        tangents.coupled[:] = 0.0
        places, blocks = plan.potentials.coupled_places, (trial, trial, internal, tangents.coupled, lane)
        call_all(d, plan.nodes, plan.potentials, places, state.stiffness, state.values, blocks)
        _raise_scale(plan, state, tangents.coupled)
    sum_up(plan, state, energy)


@compiled
def multiply(plan: Any, state: Any, tangents: Any, spread: Any, p: Any, product: Any) -> None:
    """product = K p for eight lanes, both (B d, 8); `spread` (n d, 8) is scratch. Pinned unknowns stay 0."""
    d, ends, block_of, rest_vectors = plan.dimension, plan.ends, plan.block_of, plan.rest_vectors
    cache, trial = tangents.cache, state.trial
    zero = splat(0.0)
    product[:] = 0.0
    for node in range(len(block_of)):
        block = block_of[node]
        for a in range(d):
            store(spread, node * d + a, load(p, block * d + a) if block >= 0 else zero)
    for spring in range(len(ends)):
        i, j = ends[spring, 0], ends[spring, 1]
        block_i, block_j = block_of[i], block_of[j]
        if block_i < 0 and block_j < 0:
            continue
        along = zero
        for a in range(d):
            component = load(trial, j * d + a) - load(trial, i * d + a) + rest_vectors[spring, a]
            store(state.delta, a, component)
            along = fma(component, load(spread, j * d + a) - load(spread, i * d + a), along)
        tension, along = load(cache, 2 * spring), along * load(cache, 2 * spring + 1)
        for a in range(d):
            force = tension * (load(spread, j * d + a) - load(spread, i * d + a))
            force = fma(along, load(state.delta, a), force)
            if block_j >= 0:
                store(product, block_j * d + a, load(product, block_j * d + a) + force)
            if block_i >= 0:
                store(product, block_i * d + a, load(product, block_i * d + a) - force)
    if len(tangents.coupled):
        _multiply_coupled(plan, tangents.coupled, p, product)
    for at in plan.pinned:
        store(product, at, zero)


@njit(error_model="numpy")
def _multiply_coupled(plan: Any, coupled: Any, p: Any, product: Any) -> None:
    """Add the products with what effects brought; lower blocks count for the upper ones too."""
    d = plan.dimension
    for block in range(len(plan.coupled)):
        row, column = plan.coupled[block]
        at = block * d * d
        for a in range(d):
            for b in range(d):
                entry = load(coupled, at + a * d + b)
                here, there = row * d + a, column * d + b
                store(product, here, fma(entry, load(p, there), load(product, here)))
                if column < row:
                    store(product, there, fma(entry, load(p, here), load(product, there)))


@njit(error_model="numpy")
def _raise_scale(plan: Any, state: Any, coupled: Any) -> None:
    """As in `evaluation`: effects may be stiffer than springs."""
    d = plan.dimension
    for at in range(len(state.scale)):
        store(state.scale, at, load(state.meeting, at))
    for block in range(len(plan.coupled)):
        row, column = plan.coupled[block]
        if row == column:
            for a in range(d):
                at = row * d + a
                stands = load(state.meeting, at) + absolute(load(coupled, block * d * d + a * d + a))
                store(state.scale, at, maximum(stands, load(state.meeting, at)))


@compiled
def scatter(
    plan: Any,
    state: Any,
    tangents: Any,
    v: int,
    weight: float,
    places: Any,
    coupled_places: Any,
    pinned_places: Any,
    entries: Any,
) -> None:
    """Add the tangent of lane v, times `weight`, to the entries of a matrix; the places are those of a `Layout`."""
    d = plan.dimension
    delta = np.empty(d)
    block = np.empty((d, d))
    kind = entries.dtype.type
    for spring in range(len(plan.ends)):
        k = state.stiffness[spring, v]
        if k == 0.0:
            continue
        i, j = plan.ends[spring, 0] * d, plan.ends[spring, 1] * d
        for a in range(d):
            delta[a] = state.trial[j + a, v] - state.trial[i + a, v] + plan.rest_vectors[spring, a]
        tension, axial = weight * tangents.cache[2 * spring, v], weight * tangents.cache[2 * spring + 1, v]
        for a in range(d):
            for b in range(d):
                block[a, b] = axial * delta[a] * delta[b]
            block[a, a] += tension
        _scatter_block(places[spring], block, d, kind, entries)
    if len(tangents.coupled):
        for q in range(len(coupled_places)):
            at = coupled_places[q]
            if at >= 0:
                entries[at] += kind(weight * tangents.coupled[q, v])
    for q in range(len(plan.pinned)):
        entries[pinned_places[q]] = kind(weight * state.scale[plan.pinned[q], v])


@njit(error_model="numpy")
def _scatter_block(places: Any, block: Any, d: int, kind: Any, entries: Any) -> None:
    """`places` (3, d, d): where the blocks (i, i), (j, j) and (i, j) of one spring go, -1 for nowhere."""
    for a in range(d):
        for b in range(d):
            value = kind(block[a, b])
            if places[0, a, b] >= 0:
                entries[places[0, a, b]] += value
            if places[1, a, b] >= 0:
                entries[places[1, a, b]] += value
            if places[2, a, b] >= 0:
                entries[places[2, a, b]] -= value
