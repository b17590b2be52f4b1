"""Contact of the nodes of a mesh, spread over the boundary between them, for finer elements.

Each node's potential is taken for the share of the boundary around it: as much by area in all its nodes, and less by
area where they are far apart. Finer nodes have the same by area, interpolated, and each its own area; so that on the
mesh itself nothing changes. Nodes inside touch nothing, unless they are named.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from springopt.checks import Booleans
from springopt.effects.effect import Effect, Kernel
from springopt.errors import UserError
from springopt.lattice import SpringLattice
from springopt.reference.body_among_effects import Potential, outside_potentials
from springopt.reference.refinement import Refinement


def spread_potentials(
    refinement: Refinement, lattice: SpringLattice, effects: Sequence[Effect]
) -> tuple[SpringLattice, list[Potential]]:
    """All nodes of the elements, and the potentials on them; refuses those that are more than a node's own."""
    finer = SpringLattice(refinement.interpolation @ lattice.nodes, np.zeros((0, 2), np.int64))
    spread = []
    for effect, kernel, values in outside_potentials(lattice, effects):
        named: Any = getattr(effect, "nodes", None)
        touching = np.zeros(lattice.node_count, dtype=bool)
        touching[kernel.pairs] = True
        finer_touching = np.ones(finer.node_count, dtype=bool)
        changes: dict[str, Any] = {}
        if named is not None:
            finer_touching = refinement.nodes_between(touching)
            changes["nodes"] = np.flatnonzero(finer_touching).tolist()
        _alone(effect, kernel, touching)
        finer_kernel = _alone(effect, replace(effect, **changes).potential(finer), finer_touching)
        shares = refinement.boundary_shares(touching, alone=0.0 if named is None else 1.0)
        spread.append(Potential(finer_kernel, values, shares))
    return finer, spread


def _alone(effect: Effect, kernel: Kernel | None, touching: Booleans) -> Kernel:
    """The potential; refused where it is not one of each of these nodes by itself."""
    pairs = np.zeros((0, 2), np.int64) if kernel is None else kernel.pairs
    if kernel is None or not np.array_equal(
        np.sort(pairs, axis=0), np.flatnonzero(touching)[:, None].repeat(2, axis=1)
    ):
        raise UserError(
            f"{effect.name or type(effect).__name__} is no potential of each node by itself, as contact is, so that "
            "finer elements can't be told what it does between the nodes; leave it out, or take the order 1 and no "
            "refinements."
        )
    return kernel
