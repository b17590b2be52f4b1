"""Forces and tangent at the trial states of eight motions.

Unknown is where a stage ends. What is out of balance there is f - F - R - M a, with loads f, internal forces F,
dissipation R and masses M. The l-stable method takes F at the end of the stage. The energy-momentum method takes its
mean over the way there, so that its work is the change of energy: for a spring in closed form,

    k (elongation before + elongation after) / (length before + length after) x the mean of both vectors,

which is also along the mean vector and so does no work on a rotation (Simo and Tarnow 1992, Gonzalez 1996); effects
bring their own discrete gradient, or are taken at two Gauss points (the average vector field method, Quispel and
McLaren 2008), exact where energies are polynomials of the fourth degree. The tangent is made symmetric: what is lost
is of the order of the step, and costs Newton's method no more than an iteration.
"""

from typing import Any

import numpy as np
from numba import njit

from springopt.effects.lanes import absolute, fma, load, maximum, splat, store
from springopt.effects.springs import COLLAPSED, TINY, add_springs, elongation
from springopt.forward.evaluation import call_all
from springopt.forward.motion.state import ENERGY, FORCE_SCALE, POTENTIAL, RESIDUAL, TO_ACCELERATION, TO_SPEED

#: Two Gauss points on the way from before to after.
GAUSS = 0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)


@njit(error_model="numpy")
def follow_trial(motion: Any, is_midpoint: bool) -> None:
    """Speed and acceleration that belong to the trial states, and where dissipation is taken."""
    to_speed, to_acceleration = load(motion.scalars, TO_SPEED), load(motion.scalars, TO_ACCELERATION)
    for row in range(len(motion.trial)):
        base, trial = load(motion.base, row), load(motion.trial, row)
        speed = to_speed * (trial - base)
        store(motion.speed, row, speed)
        store(motion.acceleration, row, to_acceleration * (speed - load(motion.base_speed, row)))
        store(motion.at, row, (base + trial) * 0.5 if is_midpoint else trial)


@njit(error_model="numpy")
def evaluate_motion(plan: Any, motion: Any, ways: Any, is_midpoint: bool) -> None:
    """Residual, force scale and tangent by the end of the stage, in the envelope; `ways` as in `plan.ways_of`."""
    d, internal, tangent, zero = plan.dimension, motion.internal, motion.tangent, splat(0.0)
    follow_trial(motion, is_midpoint)
    for row in range(len(tangent)):
        store(tangent, row, zero)
    for row in range(len(internal)):
        store(internal, row, zero)
    store(motion.scalars, ENERGY, zero)
    add_effects(plan, motion, ways, tangent, (ways[0].places, ways[2].places), is_midpoint)
    if is_midpoint:
        _add_springs_between(plan, motion, tangent)
    else:
        before = load(motion.scalars, ENERGY)
        add_springs(plan, motion.stiffness, motion.trial, internal, tangent, motion.scalars, motion.delta)
        springs = load(motion.scalars, ENERGY) - before
        store(motion.scalars, POTENTIAL, load(motion.scalars, POTENTIAL) + springs)
    balance(plan, motion)
    for block in range(len(plan.first)):
        diagonal = (plan.start[block] + block - plan.first[block]) * d * d
        for a in range(d):
            row, at = diagonal + a * d + a, block * d + a
            stands = load(tangent, row) + load(motion.diagonal, at)
            store(tangent, row, stands)
            store(motion.scale, at, maximum(absolute(stands), load(motion.meeting, at)))
    for row in plan.pinned_rows:
        store(tangent, row, zero)
    for at in plan.pinned:
        block, a = at // d, at % d
        row = (plan.start[block] + block - plan.first[block]) * d * d + a * d + a
        store(tangent, row, load(motion.scale, at))


@njit(error_model="numpy")
def add_effects(plan: Any, motion: Any, ways: Any, tangent: Any, places: Any, is_midpoint: bool) -> None:
    """Forces and blocks of all effects; what kernels have by speed is brought to displacements."""
    store(motion.scalars, POTENTIAL, splat(0.0))
    (averaged, betweens, dissipations), (potential_places, dissipation_places) = ways, places
    if not len(averaged.table) + len(betweens.table) + len(dissipations.table):
        return
    to_speed = load(motion.scalars, TO_SPEED)
    at, speed, internal = motion.at, motion.speed, motion.internal
    if len(averaged.table):
        # The mean of two points, each with half of its block by the end of the way.
        share, by_end = (0.5, 0.25) if is_midpoint else (1.0, 1.0)
        for point in range(2 if is_midpoint else 1):
            where = motion.trial
            if is_midpoint:
                where = at
                for row in range(len(at)):
                    base = load(motion.base, row)
                    store(at, row, fma(splat(GAUSS[point]), load(motion.trial, row) - base, base))
            blocks = (where, speed, internal, tangent, motion.scalars)
            call_all(plan.dimension, plan.nodes, averaged, potential_places, motion.stiffness, motion.values, blocks)
        for row in range(len(internal)):
            store(internal, row, load(internal, row) * share)
        for row in range(len(tangent)):
            store(tangent, row, load(tangent, row) * by_end / to_speed)
        if is_midpoint:
            for row in range(len(at)):
                store(at, row, (load(motion.base, row) + load(motion.trial, row)) * 0.5)
    store(motion.scalars, POTENTIAL, load(motion.scalars, ENERGY))  # a dissipation adds its power behind it
    if len(dissipations.table):
        blocks = (at, speed, internal, tangent, motion.scalars)
        call_all(plan.dimension, plan.nodes, dissipations, dissipation_places, motion.stiffness, motion.values, blocks)
    for row in range(len(tangent)):
        store(tangent, row, load(tangent, row) * to_speed)
    if len(betweens.table):
        blocks = (motion.trial, motion.base, internal, tangent, motion.scalars)
        call_all(plan.dimension, plan.nodes, betweens, potential_places, motion.stiffness, motion.values, blocks)


@njit(error_model="numpy")
def between(plan: Any, motion: Any, spring: int) -> Any:
    """(force per length of the mean vector, what the tangent has along it per length squared) of one spring.

    The mean vector is left in `delta`; both numbers as the tangent by the end of the way has them, twice.
    """
    d, delta = plan.dimension, motion.delta
    i, j = plan.ends[spring, 0] * d, plan.ends[spring, 1] * d
    natural, k = plan.natural_lengths[spring], load(motion.stiffness, spring)
    length, prestrain = plan.lengths[spring], plan.prestrains[spring]
    before, longer_before = elongation(motion.base, i, j, plan.rest_vectors, spring, length, natural, prestrain, delta)
    after, longer_after = elongation(motion.trial, i, j, plan.rest_vectors, spring, length, natural, prestrain, delta)
    for a in range(d):
        mean = (
            load(motion.base, j + a) - load(motion.base, i + a) + load(delta, a) + plan.rest_vectors[spring, a]
        ) * 0.5
        store(delta, a, mean)
    if natural == 0.0:
        return k, k * 0.0
    lengths = maximum(before + after, splat(2.0 * COLLAPSED * natural))
    tension = k * (longer_before + longer_after) / lengths
    return tension, 4.0 * natural * k / (lengths * lengths * maximum(after, splat(TINY)))


@njit(error_model="numpy")
def _add_springs_between(plan: Any, motion: Any, tangent: Any) -> None:
    d, ends, block_rows, internal, delta = plan.dimension, plan.ends, plan.block_rows, motion.internal, motion.delta
    for spring in range(len(ends)):
        tension, axial = between(plan, motion, spring)
        i, j = ends[spring, 0] * d, ends[spring, 1] * d
        at_i, at_j, at_ij = block_rows[spring, 0], block_rows[spring, 1], block_rows[spring, 2]
        for a in range(d):
            component = load(delta, a)
            force = tension * component
            store(internal, j + a, load(internal, j + a) + force)
            store(internal, i + a, load(internal, i + a) - force)
            axial_component = axial * component
            for b in range(d):
                entry = axial_component * load(delta, b)
                if a == b:
                    entry = entry + tension
                entry, k_ab = entry * 0.5, a * d + b
                if at_i >= 0:
                    store(tangent, at_i + k_ab, load(tangent, at_i + k_ab) + entry)
                if at_j >= 0:
                    store(tangent, at_j + k_ab, load(tangent, at_j + k_ab) + entry)
                if at_ij >= 0:
                    store(tangent, at_ij + k_ab, load(tangent, at_ij + k_ab) - entry)


@njit(error_model="numpy")
def balance(plan: Any, motion: Any) -> None:
    """What is out of balance, the largest force, and what inertia adds to the tangent's diagonal."""
    d, unknowns, zero = plan.dimension, motion.unknowns, splat(0.0)
    stiff = load(motion.scalars, TO_SPEED) * load(motion.scalars, TO_ACCELERATION)
    largest, force_scale, work = zero, zero, zero
    for node in range(len(plan.block_of)):
        block, mass = plan.block_of[node], load(motion.masses, node)
        for a in range(d):
            row = node * d + a
            force, internal = load(motion.forces, row), load(motion.internal, row)
            inertia = mass * load(motion.acceleration, row)
            work = fma(force, load(motion.trial, row), work)
            force_scale = maximum(maximum(absolute(force), absolute(internal)), maximum(absolute(inertia), force_scale))
            if block >= 0:
                store(unknowns, block * d + a, force - internal - inertia)
                store(motion.diagonal, block * d + a, stiff * mass)
    for at in plan.pinned:
        store(unknowns, at, zero)
    lost = zero  # nan where any residual is, which no comparison shows
    for at in range(len(unknowns)):
        largest, lost = maximum(largest, absolute(load(unknowns, at))), lost + zero * load(unknowns, at)
    store(motion.scalars, RESIDUAL, largest + lost)
    store(motion.scalars, POTENTIAL, load(motion.scalars, POTENTIAL) - work)
    store(motion.scalars, FORCE_SCALE, force_scale)
