"""Bodies that hang on nothing: pushed by a net force they have no equilibrium, and no solver should look for one.

The energy of a part that its springs tie to a support grows without bound as its nodes move away, so that a minimum
exists whatever the load. A part without a support along an axis has one only if its forces balance along that axis.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from springopt.effects.compile import compiled


@njit(error_model="numpy")
def _root(parents: Any, node: int) -> int:
    while parents[node] != node:
        parents[node] = parents[parents[node]]
        node = parents[node]
    return node


@compiled
def net_forces_on_floating_parts(
    ends: Any, stiffness: Any, is_supported: Any, forces: Any, d: int
) -> NDArray[np.float64]:
    """The largest net force [force] on a part along an axis where nothing holds it, shape (m, cases).

    `stiffness` (m, s), where 0 is no spring; `is_supported` (n d) bool; `forces` (cases, n d).
    """
    candidate_count, case_count = len(stiffness), len(forces)
    node_count = is_supported.size // d
    largest = np.zeros((candidate_count, case_count))
    parents = np.empty(node_count, dtype=np.int64)
    is_held = np.empty((node_count, d), dtype=np.bool_)
    net = np.empty((node_count, d))
    for m in range(candidate_count):
        for node in range(node_count):
            parents[node] = node
        part_count = node_count
        for spring in range(len(ends)):
            if stiffness[m, spring] > 0.0:
                a, b = _root(parents, ends[spring, 0]), _root(parents, ends[spring, 1])
                if a != b:
                    parents[a] = b
                    part_count -= 1
        is_held[:] = False
        for node in range(node_count):
            for a in range(d):
                if is_supported[node * d + a]:
                    is_held[_root(parents, node), a] = True
        if part_count == 1 and is_held[_root(parents, 0)].all():
            continue
        for case in range(case_count):
            net[:] = 0.0
            for node in range(node_count):
                part = _root(parents, node)
                for a in range(d):
                    net[part, a] += forces[case, node * d + a]
            for part in range(node_count):
                for a in range(d):
                    if not is_held[part, a] and parents[part] == part:
                        largest[m, case] = max(largest[m, case], abs(net[part, a]))
    return largest
