"""A Winkler foundation (E. Winkler, Die Lehre von der Elasticitaet und Festigkeit, 1867), as somebody else's effect."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.checks import Floats, floats, require_nonnegative, require_shape
from springopt.effects.blocks import add, add_to_block, rows
from springopt.effects.compile import kernel
from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.effects.lanes import load
from springopt.errors import UserError
from springopt.lattice import SpringLattice, side


@kernel
def add_foundation(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """Energy m u^2 / 2 of each node that lies on it; `integers`: how many there are, then which."""
    displacements, forces, tangent, energy = rows(u), rows(f), rows(k), rows(e)
    modulus = load(rows(values), 0)
    for number in range(integers[0]):
        for a in range(d):
            row = integers[1 + number] * d + a
            moved = load(displacements, row)
            add(energy, 0, modulus * moved * moved * 0.5)
            add(forces, row, modulus * moved)
            add_to_block(tangent, places[number], d, a, a, modulus)


@dataclass(frozen=True)
class Foundation(Effect):
    """Soft ground: a force against the displacement of every node on some sides, in proportion to it."""

    name = "foundation"
    is_translation_invariant = False
    is_rotation_invariant = False
    modulus: float = 1.0  #: of each node [force / length]
    sides: Sequence[str] = ("bottom",)  #: whose nodes lie on the ground

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        modulus = require_shape("modulus", require_nonnegative("modulus", floats("modulus", self.modulus)), ())
        return {"modulus": modulus[None]}

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel:
        if not self.sides:
            raise UserError("a foundation needs a side of the lattice that lies on it; name one in sides.")
        touching = np.flatnonzero(np.any([side(lattice, name) for name in self.sides], axis=0))
        return Kernel(add_foundation, touching[:, None].repeat(2, axis=1), np.append(len(touching), touching))
