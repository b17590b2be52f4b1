"""How wrong positions are, on one scale for all axes: as a share of how far the body moves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springopt.checks import Floats
from springopt.forward.status import STATUSES, has_equilibrium
from springopt.load_case import LoadCase

Reals = NDArray[np.floating[Any]]


def relative_errors(positions: Reals, known: Reals, nodes: Floats) -> Floats:
    """Mean distance from the known positions over the mean displacement, shape (...,).

    Args:
        positions, known: [length], shape (..., n, d); the axes before the nodes are load cases, and perhaps candidates.
            In long double precision where displacements are small beside positions, which would round them.
            Of motions (..., t, n, d) give (..., t n, d), and nodes repeated as often.
        nodes: at rest [length], shape (n, d).
    """
    distances = np.linalg.norm(positions - known, axis=-1).mean(axis=-1)
    moved = np.linalg.norm(known - nodes, axis=-1).mean(axis=-1)
    # What does not move is measured by the size of the body.
    return np.asarray(distances / np.where(moved > 0.0, moved, np.ptp(nodes, axis=0).max()), dtype=float)


def errors_of_cases(positions: Reals, known: Reals, nodes: Floats) -> Floats:
    """The same of load cases, shape (c,): static ones (c, n, d), or motions (c, t, n, d), each over all its times."""
    cases, dimension = len(known), nodes.shape[1]
    times = known[0].size // nodes.size if cases else 1
    return relative_errors(
        positions.reshape(cases, -1, dimension), known.reshape(cases, -1, dimension), np.tile(nodes, (times, 1))
    )


def say_failures(cases: Sequence[LoadCase], codes: NDArray[np.int8]) -> str:
    """Which load cases have no answer, and what their solve says of itself, by statuses (c,); "" if none."""
    failed = np.flatnonzero(~has_equilibrium(codes)).tolist()
    return ", ".join(f"{cases[number].name}: {STATUSES[codes[number]]}" for number in failed)


def say_least(errors: Iterable[Floats], tolerance: float) -> list[str]:
    """A sentence where errors end at the tolerance of the forward solve."""
    if not any((each <= tolerance).any() for each in errors):
        return []
    return [
        f"Errors are not below {tolerance:.1g}, the tolerance of the forward solve, which can't tell less from zero."
    ]
