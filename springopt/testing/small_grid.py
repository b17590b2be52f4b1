"""A lattice of three by three nodes that learns from another one: the smallest scene with physics."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from springopt.checks import Floats
from springopt.encoding import Binary, Encoding, Real
from springopt.forward.batch import Equilibria, Group
from springopt.forward.motion.follow import Motions
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.model import Model
from springopt.objective import Objective
from springopt.reference.spring import SpringReference

#: Name, the side that is held, the side that is loaded, and the force on each of its nodes [force].
LOADS = (
    ("pull right", "left", "right", [0.3, 0.0]),
    ("shear right", "left", "right", [0.0, 0.2]),
    ("pull top", "bottom", "top", [0.0, 0.3]),
    ("shear top", "bottom", "top", [0.2, 0.0]),
)
STIFFNESS = 3.0  # of a spring of the reference [force/length]; of one inside along an axis the double


@dataclass(frozen=True, eq=False)
class CountedModel(Model):
    """A model that counts the equilibria that it was asked for, by whatever way."""

    sought: list[int] = field(default_factory=list)  #: of each call

    def find(self, groups: tuple[Group, ...], candidates: Floats, tolerance: float) -> Equilibria | Motions:  # type: ignore[override]
        equilibria = super().find(groups, candidates, tolerance)
        self.sought.append(equilibria.codes.size)
        return equilibria


def real_grid() -> tuple[Objective, Encoding]:
    """Twenty springs, one number each; the reference is the lattice of an isotropic body."""
    lattice = SpringLattice.grid((3, 3))
    inside_along_an_axis = lattice.straight & ~lattice.boundary
    return _objective(lattice, np.where(inside_along_an_axis, 2.0 * STIFFNESS, STIFFNESS)), Real(lattice)


def binary_grid() -> tuple[Objective, Encoding]:
    """Twenty springs, one bit each; the reference lacks four diagonals. Most candidates are mechanisms."""
    lattice = SpringLattice.grid((3, 3))
    absent = np.flatnonzero(~lattice.straight)[::2]
    stiffness = np.full(lattice.spring_count, STIFFNESS)
    stiffness[absent] = 0.0
    return _objective(lattice, stiffness), Binary(lattice, stiffness=STIFFNESS)


def _objective(lattice: SpringLattice, stiffness: Floats) -> Objective:
    cases = [_load_case(lattice, *load) for load in LOADS]
    reference = SpringReference(Model(lattice), stiffness)
    positions = np.array([reference.deform(case) for case in cases])
    return Objective(CountedModel(lattice), cases, positions, reference=reference)


def _load_case(lattice: SpringLattice, name: str, held: str, loaded: str, force: list[float]) -> LoadCase:
    forces = np.where(side(lattice, loaded)[:, None], force, 0.0)
    return LoadCase(name, supports=side(lattice, held), forces=forces)
