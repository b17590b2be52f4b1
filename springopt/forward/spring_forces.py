"""What springs pull with per stiffness, where all positions are known: forces are linear in the stiffness."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from springopt.effects.compile import compiled
from springopt.effects.springs import COLLAPSED, TINY, Springs
from springopt.forward.plan import Plan

Floats = NDArray[np.float64]


def forces_per_stiffness(springs: Plan | Springs, displacements: Floats, *, is_linear: bool) -> Floats:
    """The force of each spring on its first node over its stiffness [length], shape (c, s, d); on its second, less it.

    At `displacements` (c, n d). As the engines have it: (L - L0) along the spring, without cancellation, and all of
    its vector where L0 is 0; for small displacements the expansion at rest.
    """
    answers = np.empty((len(displacements), *springs.rest_vectors.shape))
    arrays = (springs.ends, springs.rest_vectors, springs.lengths, springs.natural_lengths, springs.prestrains)
    _pull(*arrays, np.ascontiguousarray(displacements), is_linear, answers)
    return answers


def forces_at_nodes(ends: NDArray[np.int64], pulls: Floats, stiffness: Floats, node_count: int) -> Floats:
    """The forces of springs (s,) on the nodes, shape (c, n d), for `pulls` (c, s, d)."""
    answers = np.zeros((len(pulls), node_count * pulls.shape[2]))
    _add_up(ends, pulls, np.ascontiguousarray(stiffness), answers)
    return answers


def work_per_stiffness(ends: NDArray[np.int64], pulls: Floats, ways: Floats) -> Floats:
    """What springs do on ways of the nodes over their stiffness, shape (c, k, s), for `ways` (c, k, n d)."""
    answers = np.empty((*ways.shape[:2], len(ends)))
    _work(ends, pulls, ways, answers)
    return answers


@compiled
def _pull(
    ends: Any,
    rest_vectors: Any,
    lengths: Any,
    natural_lengths: Any,
    prestrains: Any,
    displacements: Any,
    is_linear: bool,
    answers: Any,
) -> None:
    d = rest_vectors.shape[1]
    for case in range(len(displacements)):
        for spring in range(len(ends)):
            i, j = ends[spring, 0] * d, ends[spring, 1] * d
            rest, pull, u = rest_vectors[spring], answers[case, spring], displacements[case]
            length, natural, prestrain = lengths[spring], natural_lengths[spring], prestrains[spring]
            if is_linear:
                _pull_at_rest(rest, length, natural, prestrain, u, i, j, pull)
            else:
                _pull_along(rest, length, natural, prestrain, u, i, j, pull)


@njit(error_model="numpy")
def _pull_along(rest: Any, length: float, natural: float, prestrain: float, u: Any, i: int, j: int, pull: Any) -> None:
    growth, square = 0.0, 0.0
    for a in range(len(rest)):
        du = u[j + a] - u[i + a]
        pull[a] = rest[a] + du
        growth += (du + 2.0 * rest[a]) * du
        square += pull[a] * pull[a]
    if natural == 0.0:
        return
    now = np.sqrt(square)
    longer = growth / max(now + length, TINY) + prestrain
    for a in range(len(rest)):
        pull[a] *= longer / max(now, COLLAPSED * natural)


@njit(error_model="numpy")
def _pull_at_rest(
    rest: Any, length: float, natural: float, prestrain: float, u: Any, i: int, j: int, pull: Any
) -> None:
    """With e along the spring and prestrain q = |D| - L0: q e + (e . du) e + q / |D| (du - (e . du) e)."""
    length = max(length, TINY)
    transverse = 1.0 if natural == 0.0 else prestrain / length
    along = 0.0
    for a in range(len(rest)):
        along += rest[a] * (u[j + a] - u[i + a])
    axial = (1.0 - transverse) * along / (length * length)
    for a in range(len(rest)):
        pull[a] = transverse * (rest[a] + u[j + a] - u[i + a]) + axial * rest[a]


@compiled
def _add_up(ends: Any, pulls: Any, stiffness: Any, answers: Any) -> None:
    d = pulls.shape[2]
    for case in range(len(pulls)):
        for spring in range(len(ends)):
            for a in range(d):
                force = stiffness[spring] * pulls[case, spring, a]
                answers[case, ends[spring, 0] * d + a] += force
                answers[case, ends[spring, 1] * d + a] -= force


@compiled
def _work(ends: Any, pulls: Any, ways: Any, answers: Any) -> None:
    d = pulls.shape[2]
    for case in range(len(pulls)):
        for k in range(ways.shape[1]):
            for spring in range(len(ends)):
                i, j = ends[spring, 0] * d, ends[spring, 1] * d
                total = 0.0
                for a in range(d):
                    total += (ways[case, k, i + a] - ways[case, k, j + a]) * pulls[case, spring, a]
                answers[case, k, spring] = total
