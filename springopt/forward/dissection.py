"""Nested dissection: an elimination order that keeps the factors of large grids and meshes sparse (George 1973).

A body is cut in two at the middle of its longest axis; the nodes along the cut come last, each half before them is cut
again.
"""

import numpy as np
from numpy.typing import NDArray

# Parts of so many nodes are not cut any more.
SMALLEST_PART = 60


def dissect(places: NDArray[np.float64], pairs: NDArray[np.int64]) -> NDArray[np.int64]:
    """The order (nodes,) in which to eliminate nodes at `places` (nodes, d), coupled by `pairs` (p, 2)."""
    pieces: list[NDArray[np.int64]] = []
    waiting = [(np.arange(len(places)), pairs[pairs[:, 0] != pairs[:, 1]])]
    # Written from the last node to be eliminated to the first: cuts before what they separate.
    while waiting:
        nodes, inside = waiting.pop()
        if len(nodes) <= SMALLEST_PART:
            pieces.append(nodes)
            continue
        spans = np.ptp(places[nodes], axis=0)
        along = places[nodes, int(spans.argmax())]
        part_of = np.zeros(len(places), dtype=np.int8)
        part_of[nodes[np.argsort(along, kind="stable")[len(nodes) // 2 :]]] = 1
        cut = inside[part_of[inside[:, 0]] != part_of[inside[:, 1]]]
        separator = np.unique(cut[part_of[cut] == 1])
        part_of[separator] = 2
        pieces.append(separator)
        sides = part_of[inside]
        for part in (0, 1):
            waiting.append((nodes[part_of[nodes] == part], inside[(sides == part).all(axis=1)]))
    return np.concatenate(pieces)[::-1]
