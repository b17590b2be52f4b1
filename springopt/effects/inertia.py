"""Inertia: the masses of the nodes, which motion needs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from springopt.checks import Floats
from springopt.effects.effect import Effect
from springopt.effects.node_masses import mass_parameters, node_masses
from springopt.lattice import SpringLattice


@dataclass(frozen=True)
class Inertia(Effect):
    """The masses of the nodes: their own, or from the density of the cells. Without weight; see `Gravity`."""

    name = "inertia"
    mass: float | Sequence[float] | None = None  #: of each node, one number for all or one for each
    density: float | None = None  #: [mass / length^d] of the cells, in place of the mass; in 2D the thickness is 1

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        return mass_parameters(lattice, self.mass, self.density)

    def masses(self, lattice: SpringLattice, values: Mapping[str, Floats]) -> Floats | None:
        return node_masses(lattice, values)
