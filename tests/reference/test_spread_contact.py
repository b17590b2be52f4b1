"""Contact of the nodes of a mesh on finer elements: as much of it, and where the mesh has it."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from springopt.effects.contact import PlaneContact
from springopt.effects.volume import Volume
from springopt.errors import UserError
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.reference.fem import FemReference
from springopt.reference.refinement import Refinement

SHAPES = {"triangle": (4, 3), "quad": (4, 3), "tetra": (3, 3, 3), "hexahedron": (3, 3, 3)}
every_cell = pytest.mark.parametrize("cell", SHAPES)
finer = pytest.mark.parametrize("changes", [{"refinements": 1}, {"order": 2}, {"refinements": 1, "order": 2}])


def floor(lattice, **changes):
    """Under a body that stands on it, with even stiffness by area: nodes at its rim have less."""
    normal = [0.0] * (lattice.dimension - 1) + [1.0]
    return PlaneContact(**({"stiffness": 50.0, "point": [0.0] * lattice.dimension, "normal": normal} | changes))


@every_cell
@pytest.mark.parametrize(("divisions", "order"), [(0, 1), (1, 1), (0, 2), (1, 2)])
def test_shares_are_positive_and_sum_to_the_nodes_on_the_boundary(cell, divisions, order):
    lattice = SpringLattice.grid(SHAPES[cell], cell=cell)
    refinement = Refinement((lattice.nodes, lattice.cells, cell), divisions, order)
    shares = refinement.boundary_shares(np.ones(lattice.node_count, dtype=bool), alone=0.0)
    low, high = lattice.nodes.min(axis=0), lattice.nodes.max(axis=0)
    outside = np.any((lattice.nodes == low) | (lattice.nodes == high), axis=1)
    assert (shares >= 0).all()
    assert shares.sum() == pytest.approx(outside.sum())
    if (divisions, order) == (0, 1):
        np.testing.assert_allclose(shares, outside, atol=1e-14)


@every_cell
@finer
def test_the_floor_bears_the_body_at_all_nodes_by_their_shares(cell, changes):
    lattice = SpringLattice.grid(SHAPES[cell], cell=cell)
    forces = np.zeros(lattice.nodes.shape)
    forces[side(lattice, "top"), -1] = -0.3
    case = LoadCase("pressed", side(lattice, "left"), forces)
    body = FemReference(lattice, young=10.0, poisson=0.3, effects=[floor(lattice)], **changes)
    displacements, (nodes, (potential,)) = body._displacements(case), body._spread_potentials
    heights = (nodes.nodes + displacements)[:, -1]
    borne = potential.shares * 50.0 * np.maximum(-heights, 0.0)
    loads = body._refinement.loads(forces)[:, -1] + borne
    forces = (body.stiffness_matrix @ displacements.ravel()).reshape(displacements.shape)[:, -1]
    is_free = nodes.nodes[:, 0] > 0.0
    assert borne.sum() > 0.1
    np.testing.assert_allclose(forces[is_free], loads[is_free], atol=1e-8)


@finer
def test_named_nodes_alone_touch_and_what_lies_between_them(changes):
    lattice = SpringLattice.grid((5, 3))
    contact = floor(lattice, nodes=[0, 1, 2, 4])
    body = FemReference(lattice, young=10.0, poisson=0.3, effects=[contact], **changes)
    nodes, (potential,) = body._spread_potentials
    touching = nodes.nodes[potential.kernel.pairs[:, 0]]
    assert (touching[:, 1] == 0).all()
    assert sorted(set(touching[:, 0].tolist()) & {0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0}) == [
        0,
        0.5,
        1,
        1.5,
        2,
        4,
    ]
    assert potential.shares.sum() == pytest.approx(4.0)
    assert potential.shares[4] == 1.0  # on no facet with another one: a point


def test_finer_contact_converges():
    """A soft block pressed on a step: its left half touches."""
    lattice = SpringLattice.grid((5, 4))
    contact = floor(lattice, nodes=[0, 1, 2], stiffness=200.0)
    forces = np.zeros(lattice.nodes.shape)
    forces[side(lattice, "top"), 1] = -0.2
    supports = np.zeros(lattice.nodes.shape, dtype=bool)
    supports[side(lattice, "right")] = True
    case = LoadCase("pressed", supports, forces)
    answers = [
        FemReference(lattice, young=10.0, poisson=0.3, effects=[contact], refinements=level).deform(case)
        for level in range(5)
    ]
    steps = [np.linalg.norm(after - before) for before, after in pairwise(answers)]
    assert all(before > 1.6 * after for before, after in pairwise(steps))


def test_a_part_of_a_lattice_is_refused_as_ever():
    with pytest.raises(UserError, match="volume is a part of a lattice"):
        FemReference(SpringLattice.grid((3, 3)), young=1.0, poisson=0.3, effects=[Volume(3.0)], order=2)


@dataclass(frozen=True)
class Glue(PlaneContact):
    """Something that acts on the first nodes of whatever it is given."""

    def potential(self, lattice, fitted=frozenset()):
        return PlaneContact(self.stiffness, self.point, self.normal, [0, 1]).potential(lattice)


def test_what_can_t_be_told_between_the_nodes_is_refused():
    lattice = SpringLattice.grid((3, 3))
    with pytest.raises(UserError, match="plane is no potential of each node by itself"):
        FemReference(lattice, young=1.0, poisson=0.3, effects=[Glue(1.0, [0.0, 0.0], [0.0, 1.0])], order=2)
