"""Random topologies of density 0.3 to 0.9: in the middle nearly all are singular at rest."""

import numpy as np

import springopt as so
from ladder.rung import Rung
from ladder.shapes import pull

FAMILY = "random topologies"
DENSITIES = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
FORCES = {
    2: ((0.3, 0.0), (0.0, 0.2), (-0.3, 0.0), (-0.2, 0.4)),
    3: ((0.2, 0.0, 0.0), (0.1, -0.2, 0.1), (-0.2, 0.0, 0.05)),
}


def rungs():
    yield from (random_topology((5, 5), density, seed) for density in DENSITIES for seed in range(6))
    yield from (random_topology((3, 3, 3), density, seed) for density in DENSITIES for seed in range(3))


def random_topology(shape, density, seed):
    rng = np.random.default_rng([seed, round(10 * density), len(shape)])
    lattice = so.SpringLattice.grid(shape)
    stiffness = rng.uniform(0.5, 10, lattice.spring_count) * (rng.random(lattice.spring_count) < density)
    forces = FORCES[len(shape)]
    case = pull(lattice, forces[seed % len(forces)])
    return Rung(FAMILY, f"{len(shape)}D, density {density}, seed {seed}", lattice, stiffness, case)
