"""What effects do to a body that has no springs: their constant nodal forces."""

from collections.abc import Sequence

import numpy as np

from springopt.checks import Floats, require_finite, require_shape
from springopt.effects.effect import Effect
from springopt.errors import UserError
from springopt.lattice import SpringLattice


def body_forces(lattice: SpringLattice, effects: Sequence[Effect], thickness: float = 1.0) -> Floats:
    """The sum of the forces that depend on nothing [force], shape (n, d)."""
    total = np.zeros(lattice.nodes.shape)
    if lattice.dimension == 2 and thickness != 1.0 and any(_is_by_area(effect) for effect in effects):
        raise UserError(
            f"a density of gravity is of the area in 2D, and this body is {thickness:g} thick; give gravity the mass "
            "of the nodes, or the body a thickness of 1."
        )
    for effect in effects:
        forces = effect.constant_forces(lattice)
        if forces is not None:
            name = f"the forces of {type(effect).__name__}"
            total += require_finite(name, require_shape(name, forces, lattice.nodes.shape))
    return total


def _is_by_area(effect: Effect) -> bool:
    return getattr(effect, "density", None) is not None
