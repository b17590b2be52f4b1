"""Effects on a finite element body: it weighs what its mesh weighs, at small strain and at large."""

import numpy as np
import pytest

from springopt.effects.effect import Effect
from springopt.effects.gravity import Gravity
from springopt.effects.tension_only import TensionOnly
from springopt.effects.volume import Volume
from springopt.errors import UserError
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.nodal_volumes import nodal_volumes
from springopt.reference.fem import FemReference

CELLS = {"triangle": (3, 6), "quad": (3, 6), "tetra": (2, 2, 6), "hexahedron": (2, 2, 6)}
every_cell = pytest.mark.parametrize(("cell", "shape"), CELLS.items())
LAWS = ["linear", "saint-venant-kirchhoff", "neo-hookean"]


def hanging(lattice):
    """Held at the top, nothing else."""
    return LoadCase("hanging", side(lattice, "top"), np.zeros(lattice.nodes.shape))


def weight(lattice, density, acceleration):
    masses = density * nodal_volumes(lattice.nodes, lattice.cells, lattice.cell_type)
    return Gravity([0.0] * (lattice.dimension - 1) + [-acceleration], mass=masses)


@pytest.mark.parametrize(("cell", "shape"), [("quad", (3, 6)), ("hexahedron", (2, 2, 6))])
def test_a_bar_hangs_under_its_own_weight_as_its_formula_says(cell, shape):
    """u = rho g (L y - y^2 / 2) / E at the distance y from the top, at every node, without Poisson's effect."""
    lattice = SpringLattice.grid(shape, cell=cell)
    reference = FemReference(lattice, young=50.0, poisson=0.0, effects=[weight(lattice, 0.3, 9.81)])
    y = 5.0 - lattice.nodes[:, -1]
    expected = np.zeros(lattice.nodes.shape)
    expected[:, -1] = -0.3 * 9.81 * (5.0 * y - y**2 / 2) / 50.0
    np.testing.assert_allclose(reference.deform(hanging(lattice)) - lattice.nodes, expected, atol=1e-12)


@pytest.mark.parametrize("law", LAWS)
@every_cell
def test_supports_bear_the_whole_weight(law, cell, shape):
    lattice = SpringLattice.grid(shape, cell=cell)
    reference = FemReference(lattice, young=50.0, poisson=0.3, law=law, effects=[weight(lattice, 0.3, 9.81)])
    displacements = reference.deform(hanging(lattice)) - lattice.nodes
    if law == "linear":
        forces = (reference.stiffness_matrix @ displacements.ravel()).reshape(displacements.shape)
    else:
        forces = reference.body.internal_forces(displacements)
    own = reference.effects[0].constant_forces(lattice)
    reactions = (forces - own)[side(lattice, "top")].sum(axis=0)
    np.testing.assert_allclose(reactions, -own.sum(axis=0), atol=1e-8)


@pytest.mark.parametrize("law", LAWS)
@every_cell
def test_gravity_is_the_same_as_its_forces_in_the_load_case(law, cell, shape):
    lattice = SpringLattice.grid(shape, cell=cell)
    gravity, case = weight(lattice, 0.3, 9.81), hanging(lattice)
    pulled = LoadCase("pulled", case.supports, gravity.constant_forces(lattice))
    with_effect = FemReference(lattice, young=50.0, poisson=0.3, law=law, effects=[gravity]).deform(case)
    with_forces = FemReference(lattice, young=50.0, poisson=0.3, law=law).deform(pulled)
    np.testing.assert_array_equal(with_effect, with_forces)
    assert with_effect[:, -1].min() < -0.3


def test_a_mesh_without_springs_weighs_the_same():
    lattice = SpringLattice.grid((3, 6))
    mesh = (lattice.nodes, lattice.cells, "quad")
    options = {"young": 50.0, "poisson": 0.3, "effects": [Gravity((0.0, -0.5), mass=0.2)]}
    np.testing.assert_array_equal(
        FemReference(mesh, **options).deform(hanging(lattice)),
        FemReference(lattice, **options).deform(hanging(lattice)),
    )


def test_effects_add_up_and_one_without_forces_changes_nothing():
    lattice = SpringLattice.grid((3, 6))
    once = FemReference(lattice, young=50.0, poisson=0.3, effects=Gravity((0.0, -0.5)))
    parts = FemReference(
        lattice, young=50.0, poisson=0.3, effects=[Gravity((0.0, -0.2)), Effect(), Gravity((0.0, -0.3))]
    )
    np.testing.assert_allclose(once.deform(hanging(lattice)), parts.deform(hanging(lattice)), rtol=1e-14)


def test_what_is_no_effect_is_refused():
    with pytest.raises(UserError, match="effects must be a list of Effect, not str"):
        FemReference(SpringLattice.grid((3, 3)), young=1.0, poisson=0.3, effects=["gravity"])


@pytest.mark.parametrize("law", ["linear", "neo-hookean"])
def test_what_is_part_of_a_lattice_is_refused_and_laws_of_its_springs_are_left_out(law):
    lattice = SpringLattice.grid((3, 3))
    case = LoadCase("pull", side(lattice, "left"), np.where(side(lattice, "right")[:, None], [0.01, 0.0], 0.0))

    def deformed(*effects):
        return FemReference(lattice, young=1.0, poisson=0.3, law=law, effects=effects).deform(case)

    with pytest.raises(UserError, match="volume is a part of a lattice"):
        deformed(Volume(1.0))
    np.testing.assert_array_equal(deformed(TensionOnly()), deformed())
