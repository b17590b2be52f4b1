"""The classes of springs that a lattice knows, and what stiffness says about each."""

from __future__ import annotations

import numpy as np

from springopt.checks import Booleans, Floats
from springopt.lattice import SpringLattice

SpringClasses = dict[str, Booleans]


def all_springs(lattice: SpringLattice) -> SpringClasses:
    """One class."""
    return {"all springs": np.ones(lattice.spring_count, dtype=bool)}


def straight_diagonal(lattice: SpringLattice) -> SpringClasses:
    """Springs along an axis, and the others."""
    return {"straight": lattice.straight, "diagonal": ~lattice.straight}


def inner_boundary_diagonal(lattice: SpringLattice) -> SpringClasses:
    """Straight springs inside, straight springs on the boundary (which carry half a cell), and the others."""
    straight, boundary = lattice.straight, lattice.boundary
    return {
        "inner straight": straight & ~boundary,
        "boundary straight": straight & boundary,
        "diagonal": ~straight,
    }


def known_classes(lattice: SpringLattice) -> SpringClasses:
    """All springs, then the finest classes that this lattice has: only classes with springs in them."""
    finest = inner_boundary_diagonal(lattice) if lattice.cells is not None else straight_diagonal(lattice)
    occupied = {name: mask for name, mask in finest.items() if mask.any()}
    return all_springs(lattice) | (occupied if len(occupied) > 1 else {})


def summarize(stiffness: Floats, classes: SpringClasses) -> dict[str, dict[str, float]]:
    """For each class: springs, those present (stiffness above 0), and mean and spread of the stiffness of these."""
    return {name: _summary(stiffness[mask]) for name, mask in classes.items()}


def _summary(stiffness: Floats) -> dict[str, float]:
    present = stiffness[stiffness > 0]
    mean, spread = (float(present.mean()), float(present.std())) if present.size else (0.0, 0.0)
    return {"springs": len(stiffness), "present": len(present), "mean": mean, "spread": spread}
