"""What the lanes need to know of their trial states: energy, residual, force scale and tangent."""

from typing import Any

from numba import njit

from springopt.effects.effect import call_kernel
from springopt.effects.lanes import absolute, fma, load, maximum, splat, store, where_greater
from springopt.effects.springs import add_springs
from springopt.forward.plan import ADDRESS, INTEGERS, NUMBERS, PLACES, VALUES
from springopt.forward.state import CONTRAST, ENERGY, FORCE_SCALE, MAGNITUDE, RESIDUAL


@njit(error_model="numpy")
def evaluate(plan: Any, state: Any) -> None:
    """Energy, residual, force scale and tangent at the trial states of all lanes."""
    d, lane, internal, zero = plan.dimension, state.scalars, state.internal, splat(0.0)
    for row in range(len(state.tangent)):
        store(state.tangent, row, zero)
    for row in range(len(internal)):
        store(internal, row, zero)
    store(lane, ENERGY, zero)
    add_springs(plan, state.stiffness, state.trial, internal, state.tangent, lane, state.delta)
    springs = load(lane, ENERGY)
    if len(plan.potentials.table):
        places, blocks = plan.potentials.places, (state.trial, state.trial, internal, state.tangent, lane)
        call_all(d, plan.nodes, plan.potentials, places, state.stiffness, state.values, blocks)
        _raise_scale(plan, state)
    sum_up(plan, state, springs)
    _pin(plan, state)


@njit(error_model="numpy")
def call_all(d: int, nodes: Any, calls: Any, places: Any, stiffness: Any, values: Any, blocks: Any) -> None:
    """Call the kernels of all effects; `blocks` are displacements, velocities, forces, tangent and energy."""
    for number in range(len(calls.table)):
        call = calls.table[number]
        integers, numbers, value, place = call[INTEGERS], call[NUMBERS], call[VALUES], call[PLACES]
        body = (nodes, calls.integers[integers:], calls.numbers[numbers:])
        lanes = (stiffness, values[value:], places[place:])
        call_kernel(call[ADDRESS], d, len(nodes), body + lanes + blocks)


@njit(error_model="numpy")
def _raise_scale(plan: Any, state: Any) -> None:
    """Effects may be stiffer than springs: what pivots are judged by is at least what stands on the diagonal."""
    d, scale = plan.dimension, state.scale
    softest, hardest = load(scale, 0) if len(scale) else splat(1.0), splat(0.0)
    for block in range(len(plan.first)):
        diagonal = (plan.start[block] + block - plan.first[block]) * d * d
        for a in range(d):
            at = block * d + a
            # In this order a diagonal that is nan, at a trial state beyond all bounds, counts for nothing.
            raised = maximum(absolute(load(state.tangent, diagonal + a * d + a)), load(state.meeting, at))
            store(scale, at, raised)
            softest = where_greater(softest, raised, raised, softest)
            hardest = maximum(hardest, raised)
    store(state.scalars, CONTRAST, hardest / softest)


@njit(error_model="numpy")
def sum_up(plan: Any, state: Any, springs: Any) -> None:
    """Energy less work, out-of-balance forces and force scale, from strain energy and internal forces.

    `springs` is the energy of the springs alone, which that of effects may cancel, but not its rounding.
    """
    d, lane, unknowns, internal, forces = plan.dimension, state.scalars, state.unknowns, state.internal, state.forces
    work, force_scale, largest = splat(0.0), splat(0.0), splat(0.0)
    for row in range(len(forces)):
        force = load(forces, row)
        work = fma(force, load(state.trial, row), work)
        force_scale = maximum(force_scale, absolute(force))
    for row in plan.supported:
        force_scale = maximum(force_scale, absolute(load(internal, row) - load(forces, row)))
    for node in range(len(plan.block_of)):
        block = plan.block_of[node]
        if block >= 0:
            for a in range(d):
                row = node * d + a
                store(unknowns, block * d + a, load(forces, row) - load(internal, row))
    for at in plan.pinned:
        store(unknowns, at, splat(0.0))
    for at in range(len(unknowns)):
        largest = maximum(largest, absolute(load(unknowns, at)))
    strain = load(lane, ENERGY)
    store(lane, MAGNITUDE, springs + absolute(strain - springs) + absolute(work))
    store(lane, ENERGY, strain - work)
    store(lane, FORCE_SCALE, force_scale)
    store(lane, RESIDUAL, largest)


@njit(error_model="numpy")
def _pin(plan: Any, state: Any) -> None:
    """Take the pinned unknowns out of the tangent."""
    d = plan.dimension
    for row in plan.pinned_rows:
        store(state.tangent, row, splat(0.0))
    for at in plan.pinned:
        block, a = at // d, at % d
        diagonal = (plan.start[block] + block - plan.first[block]) * d * d + a * d + a
        store(state.tangent, diagonal, load(state.scale, at))
