"""Loads that move the body by ten of its spacings and more."""

import numpy as np

import springopt as so
from ladder.rung import Rung
from ladder.shapes import pull

FAMILY = "large loads"


def rungs():
    for shape, seed in (((4, 4), 1), ((3, 3, 3), 2)):
        lattice = so.SpringLattice.grid(shape)
        stiffness = np.random.default_rng(seed).uniform(0.5, 10, lattice.spring_count)
        for size in (1.0, 100.0, 1000.0):
            for name, direction in (
                ("pull", (1, 0, 0)),
                ("press", (-1, 0, 0)),
                ("lift", (0, 1, 0)),
                ("askew", (-1, 1, 0.5)),
            ):
                force = size * np.array(direction[: len(shape)], dtype=float)
                case = pull(lattice, force)
                yield Rung(FAMILY, f"{len(shape)}D, {name} {size:g}", lattice, stiffness, case, check=moves_far(size))
    yield from scattered()


def moves_far(size):
    def check(solution):
        far = np.abs(solution.displacements).max()
        return "" if size < 100 or far > 10 else f"moved by {far:.2g} only"

    return check


def scattered():
    """Every node pulled its own way."""
    lattice = so.SpringLattice.grid((5, 5))
    for seed in range(6):
        rng = np.random.default_rng(seed)
        stiffness = rng.uniform(0.5, 10, lattice.spring_count)
        case = so.LoadCase("random", so.side(lattice, "left"), rng.normal(0, 20, lattice.nodes.shape))
        yield Rung(FAMILY, f"every node its own way, seed {seed}", lattice, stiffness, case)
