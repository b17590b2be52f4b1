"""Contact without friction: nodes that are kept on one side of a plane or a sphere by a penalty.

A node at the gap g from the surface costs stiffness / 2 * g^2 where g < 0, and nothing else: on the surface there is
neither force nor stiffness. A node all of whose degrees of freedom are held is not in contact.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.cells import require_nodes
from springopt.checks import (
    Floats,
    Integers,
    floats,
    integers,
    require_finite,
    require_nonnegative,
    require_positive,
    require_shape,
)
from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.errors import UserError
from springopt.lattice import SpringLattice

#: A gap at rest below this share of the lengths that it is the difference of is rounding, and meant as 0.
ROUNDING = 1e-15


@dataclass(frozen=True)
class PlaneContact(Effect):
    """Nodes are kept on the side of a plane that its normal points to."""

    name = "plane"
    has_expansion_at_rest = False
    acts_from_outside = True
    is_translation_invariant = False
    is_rotation_invariant = False
    stiffness: float  #: of each node [force / length]
    point: Sequence[float]  #: one of the plane [length]
    normal: Sequence[float]  #: to the free side, of any length but 0
    nodes: Sequence[int] | None = None  #: those that may touch it; by default all

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        return _stiffness(self.stiffness)

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        nodes = _nodes(lattice, self.nodes)
        point, normal = _vector("point", self.point, lattice), _vector("normal", self.normal, lattice)
        length = np.linalg.norm(normal)
        if length == 0:
            raise UserError("normal must point to the free side of the plane, but it is 0; give it a direction.")
        parts = (lattice.nodes[nodes] - point) * (normal / length)
        gaps = _meant(parts.sum(axis=1), np.abs(parts).sum(axis=1))
        return _contact(_plane_kernels(), nodes, np.concatenate([normal / length, gaps]))


@dataclass(frozen=True)
class SphereContact(Effect):
    """Nodes are kept outside a sphere, in 2D a circle, or inside it.

    A node at its center has no direction out: no force, and a maximum of the energy there.
    """

    name = "sphere"
    has_expansion_at_rest = False
    acts_from_outside = True
    is_translation_invariant = False
    is_rotation_invariant = False
    stiffness: float  #: of each node [force / length]
    center: Sequence[float]  #: [length]
    radius: float  #: [length]
    inside: bool = False  #: whether nodes are kept inside
    nodes: Sequence[int] | None = None  #: those that may touch it; by default all

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        return _stiffness(self.stiffness)

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        nodes = _nodes(lattice, self.nodes)
        center = _vector("center", self.center, lattice)
        radius = float(require_positive("radius", require_shape("radius", floats("radius", self.radius), ())))
        if not isinstance(self.inside, bool):
            raise UserError(f"inside must be true or false, not {self.inside!r}.")
        arms = lattice.nodes[nodes] - center
        lengths = np.linalg.norm(arms, axis=1)
        gaps = _meant(lengths - radius, lengths + radius)
        table = np.column_stack([arms, lengths, gaps]).ravel()
        return _contact(_sphere_kernels(), nodes, np.concatenate([[radius, -1.0 if self.inside else 1.0], table]))


def _stiffness(stiffness: float) -> dict[str, Floats]:
    checked = require_shape("stiffness", floats("stiffness", stiffness), ())
    return {"stiffness": require_nonnegative("stiffness", checked)[None]}


def _nodes(lattice: SpringLattice, nodes: Sequence[int] | None) -> Integers:
    if nodes is None:
        return np.arange(lattice.node_count)
    checked = require_nodes("nodes", require_shape("nodes", integers("nodes", nodes), ("k",)), lattice.node_count)
    if len(np.unique(checked)) < len(checked):
        raise UserError("nodes in contact must each be named once, or they would be twice as stiff.")
    return checked


def _vector(name: str, values: Sequence[float], lattice: SpringLattice) -> Floats:
    return require_shape(name, require_finite(name, floats(name, values)), (lattice.dimension,))


def _meant(gaps: Floats, sizes: Floats) -> Floats:
    return np.where(np.abs(gaps) <= ROUNDING * sizes, 0.0, gaps)


def _contact(functions: tuple[Any, Any], nodes: Integers, numbers: Floats) -> Kernel:
    at_state, between = functions
    pairs, integers = nodes[:, None].repeat(2, axis=1), np.concatenate([[len(nodes)], nodes])
    return Kernel(at_state, pairs, integers, numbers, between=between)


def _plane_kernels() -> tuple[Any, Any]:
    from springopt.effects.contact_kernel import add_plane, add_plane_between

    return add_plane, add_plane_between


def _sphere_kernels() -> tuple[Any, Any]:
    from springopt.effects.contact_kernel import add_sphere, add_sphere_between

    return add_sphere, add_sphere_between
