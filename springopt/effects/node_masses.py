"""The masses of nodes: given, or from a density and the cells."""

from collections.abc import Mapping, Sequence

import numpy as np

from springopt.checks import Floats, floats, require_nonnegative, require_shape
from springopt.errors import UserError
from springopt.lattice import SpringLattice
from springopt.nodal_volumes import nodal_volumes


def mass_parameters(
    lattice: SpringLattice, mass: float | Sequence[float] | None, density: float | None
) -> dict[str, Floats]:
    """What masses are made of, under its name: mass, one number or shape (n,), or density, one number."""
    if (mass is None) == (density is None):
        raise UserError("masses are given by one of mass and density; name one of them, and not both.")
    if density is not None:
        if lattice.cells is None:
            raise UserError("a density needs a lattice with cells, but this one has none; give the mass of the nodes.")
        return {
            "density": require_nonnegative("density", require_shape("density", floats("density", density), ()))[None]
        }
    assert mass is not None
    masses = require_nonnegative("mass", floats("mass", mass))
    return {"mass": require_shape("mass", masses, (lattice.node_count,)) if masses.ndim else masses[None]}


def node_masses(lattice: SpringLattice, values: Mapping[str, Floats]) -> Floats:
    """Mass of each node, shape (..., n), for values (..., k) of `mass_parameters`; in 2D the thickness is 1."""
    if "mass" in values:
        return np.broadcast_to(values["mass"], (*values["mass"].shape[:-1], lattice.node_count))
    assert lattice.cells is not None, "or there would be no density"
    assert lattice.cell_type is not None
    return values["density"] * nodal_volumes(lattice.nodes, lattice.cells, lattice.cell_type)
