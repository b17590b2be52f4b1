"""Which nodes and axes a load case speaks of."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import ValidationInfo

from springopt.checks import Booleans
from springopt.errors import SceneError
from springopt.lattice import SpringLattice, side
from springopt.scene.table import fault, faults_of_users, lattice_of

AXES = "xyz"


def parse_selection(value: Any, info: ValidationInfo) -> list[str | int]:
    """A side, a node number or a list of these, as a list; its names and numbers are checked against the lattice."""
    names = value if isinstance(value, list) else [value]
    if not names or not all(isinstance(name, str | int) and not isinstance(name, bool) for name in names):
        raise fault(f"should be a side, a node number or a list of these, but is {value!r}")
    lattice = lattice_of(info)
    if lattice is not None:
        with faults_of_users():
            select_nodes(lattice, names)
    return names


def parse_axes(value: Any, info: ValidationInfo) -> list[str]:
    """Axes of the lattice, in any order, none twice."""
    lattice = lattice_of(info)
    known = AXES[: lattice.dimension] if lattice is not None else AXES
    names = value if isinstance(value, list) else [value]
    legal = all(isinstance(name, str) and name in tuple(known) for name in names)
    if not names or not legal or len(set(names)) < len(names):
        raise fault(f"should be a list of axes out of {', '.join(known)}, but is {value!r}")
    return names


def select_nodes(lattice: SpringLattice, names: list[str | int]) -> Booleans:
    """Mask over the nodes, shape (n,): all sides and numbers together."""
    selected = np.zeros(lattice.node_count, dtype=bool)
    for name in names:
        if isinstance(name, str):
            selected |= side(lattice, name)
        else:
            selected[_checked(name, lattice.node_count)] = True
    return selected


def axis_numbers(lattice: SpringLattice, names: list[str] | None) -> list[int]:
    """Columns of the named axes, in the order of the names; all axes where nothing is named."""
    return [AXES.index(name) for name in names] if names is not None else list(range(lattice.dimension))


def _checked(node: int, node_count: int) -> int:
    if not 0 <= node < node_count:
        raise SceneError(f"should name nodes 0 to {node_count - 1}, but names {node}")
    return node
