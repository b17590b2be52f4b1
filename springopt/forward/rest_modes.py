"""How far a candidate without an equilibrium is from having one: the modes that nothing resists at rest."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from springopt.forward.batch import Group
from springopt.forward.plan import Plan
from springopt.forward.sensitivity import RIGID
from springopt.forward.sparse import Search, SparseEngine
from springopt.forward.status import has_equilibrium

# Singular values of unit-length spring directions; the smallest nonzero ones of a lattice of n nodes are about 1 / n.
ZERO = 1e-8


def zero_mode_share(groups: Sequence[Group], stiffness: NDArray[np.float64], codes: NDArray[np.int8]) -> float:
    """The mean over all load cases of zero modes at rest, per free degree of freedom.

    `stiffness` (s,) of one candidate; `codes` (c,) its statuses: a load case with an equilibrium counts as 0. All modes
    count, loaded or not: then no spring that is added can raise the share, also where it ties a loaded part to a loose
    one.
    """
    total = 0.0
    for group in groups:
        failed = np.count_nonzero(~has_equilibrium(codes[group.cases]))
        if failed:
            unknown_count = group.plan.nodes.size - len(group.plan.supported)
            total += failed * _zero_mode_count(group, stiffness > 0) / max(unknown_count, 1)
    return total / len(codes)


def _zero_mode_count(group: Group, exists: NDArray[np.bool_]) -> int:
    """By eigenvalues where they are cheap, else by the zero pivots of a factor."""
    plan = group.plan
    if not isinstance(group.engine, SparseEngine) or not group.engine.solver.is_direct:
        return len(rest_zero_modes(plan, exists)[1])
    # All springs at their rest lengths and equally stiff; one that is a point, but wants a length, has no direction.
    has_direction = (plan.lengths > 0.0) | (plan.natural_lengths == 0.0)
    at_rest = {"natural_lengths": plan.lengths, "prestrains": np.zeros_like(plan.prestrains)}
    search = Search.of(plan._replace(kernels=plan.kernels[:0], **at_rest), group.engine.solver)
    search.work.evaluate((exists & has_direction).astype(np.float64), np.zeros((1, plan.nodes.size)))
    search.factorize(0, RIGID)
    return int(search.exact.inertia[:2].sum())


def rest_zero_modes(plan: Plan, exists: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(free degrees of freedom (f,), orthonormal modes (z, f)) that change no existing spring's length to first order.

    A spring with rest vector 0 and L0 = 0 resists every direction. How stiff the springs are plays no part.
    """
    d = plan.dimension
    free = np.setdiff1d(np.arange(plan.nodes.size), plan.supported)
    springs = np.flatnonzero(exists)
    is_point = plan.lengths[springs] == 0.0
    lines, points = springs[~is_point], springs[is_point & (plan.natural_lengths[springs] == 0.0)]
    directions = plan.rest_vectors[lines] / plan.lengths[lines, None]
    rows = [_row_block(plan, lines, directions)]
    rows += [_row_block(plan, points, np.tile(np.eye(d)[a], (len(points), 1))) for a in range(d)]
    compatibility = np.vstack(rows)[:, free]
    values, vectors = np.linalg.eigh(compatibility.T @ compatibility)
    return free, vectors[:, values <= ZERO].T


def _row_block(plan: Plan, springs: NDArray[np.int64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Elongation of the springs by displacements, shape (len(springs), n d)."""
    block = np.zeros((len(springs), *plan.nodes.shape))
    rows = np.arange(len(springs))
    block[rows, plan.ends[springs, 1]] += directions
    block[rows, plan.ends[springs, 0]] -= directions
    return block.reshape(len(springs), plan.nodes.size)
