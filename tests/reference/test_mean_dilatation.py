"""Elements of mean dilatation: against Hughes's B-bar written out, and where standard ones lock."""

import numpy as np
import pytest

from springopt.errors import UserError
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.reference.fem import FemReference

CORNERS = np.array([[0.0, 0.0], [2.0, 0.3], [1.4, 1.9], [-0.3, 0.8]])


def b_bar_stiffness(corners, young, poisson):
    """One quadrilateral in plane strain, its volume strain the mean over the cell (Hughes, 1980)."""
    lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
    elasticity = np.diag([2 * shear, 2 * shear, 2 * shear, shear])
    elasticity[:3, :3] += lame
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    strains, volumes = [], []
    for point in signs / np.sqrt(3):
        gradients = signs * (1 + signs * point)[:, ::-1] / 4
        jacobian = gradients.T @ corners
        x, y = np.linalg.solve(jacobian, gradients.T)
        strain = np.zeros((4, 8))
        strain[0, ::2], strain[1, 1::2], strain[3, ::2], strain[3, 1::2] = x, y, y, x
        strains.append(strain)
        volumes.append(np.linalg.det(jacobian))
    dilatations = [strain[:3].sum(axis=0) for strain in strains]
    mean = np.average(dilatations, axis=0, weights=volumes)
    stiffness = np.zeros((8, 8))
    for strain, dilatation, volume in zip(strains, dilatations, volumes, strict=True):
        strain[:3] += (mean - dilatation) / 3
        stiffness += volume * strain.T @ elasticity @ strain
    return stiffness


def test_at_rest_a_quadrilateral_is_that_of_hughes():
    reference = FemReference(
        (CORNERS, [[0, 1, 2, 3]], "quad"), young=3.0, poisson=0.45, plane="strain", formulation="b-bar"
    )
    np.testing.assert_allclose(reference.stiffness_matrix.toarray(), b_bar_stiffness(CORNERS, 3.0, 0.45), atol=1e-13)


@pytest.mark.parametrize(("cell", "shape"), [("quad", (3, 3)), ("hexahedron", (3, 3, 3))])
@pytest.mark.parametrize("law", ["linear", "neo-hookean"])
def test_no_element_has_a_motion_without_energy_but_rigid_ones(cell, shape, law):
    lattice = SpringLattice.grid(shape, cell=cell)
    reference = FemReference(lattice, young=1.0, poisson=0.4999, plane="strain", formulation="b-bar", law=law)
    stiffness = np.linalg.eigvalsh(reference.stiffness_matrix.toarray())
    assert np.count_nonzero(stiffness < 1e-8) == {2: 3, 3: 6}[len(shape)]
    assert stiffness.min() > -1e-9


def cooks_membrane(count, law="linear", load=1.0, height=52.0, **options):
    """The rise of Cook's membrane at a height of its right edge, by default the middle, with so many cells a side."""
    grid = SpringLattice.grid((count + 1, count + 1), spacing=1 / count, neighbourhood="von-neumann")
    x, y = grid.nodes.T
    nodes = np.stack([48 * x, y * (44 * (1 - x) + 16 * x) + 44 * x], axis=1)
    forces = np.zeros(nodes.shape)
    forces[side(grid, "right"), 1] = load / count
    forces[(x == 1) & ((y == 0) | (y == 1)), 1] /= 2
    reference = FemReference((nodes, grid.cells, "quad"), young=1.0, plane="strain", law=law, **options)
    positions = reference.deform(LoadCase("shear", side(grid, "left"), forces))
    node = np.flatnonzero(np.all(np.isclose(nodes, [48.0, height]), axis=1))[0]
    return positions[node, 1] - nodes[node, 1]


def test_cooks_membrane_locks_with_standard_elements_and_not_with_mean_dilatation():
    """Plane strain, nu = 0.4999. Measured with 8, 16, 32, 64 a side: 17.65, 18.21, 18.40, 18.46 against 5.4 ... 10."""
    coarse, fine = (cooks_membrane(count, poisson=0.4999, formulation="b-bar") for count in (16, 32))
    assert coarse == pytest.approx(fine, rel=0.02)
    assert fine == pytest.approx(18.4, abs=0.02)
    assert cooks_membrane(16, poisson=0.4999) < 0.4 * coarse


def test_formulations_agree_on_compressible_material():
    standard, b_bar = (cooks_membrane(32, poisson=0.3, formulation=name) for name in ("standard", "b-bar"))
    assert standard == pytest.approx(b_bar, rel=0.01)


def test_a_nearly_incompressible_membrane_keeps_its_volume_at_large_strain():
    coarse, fine = (cooks_membrane(count, "neo-hookean", 0.1, poisson=0.4999, formulation="b-bar") for count in (8, 16))
    assert coarse == pytest.approx(fine, rel=0.04)
    assert cooks_membrane(8, "neo-hookean", 0.1, poisson=0.4999) < 0.4 * coarse


def test_a_nearly_incompressible_block_does_not_lock_in_space():
    """A bar bent by its end: the deflection hardly changes from nu = 0.45 to 0.4999, but falls with standard ones."""
    lattice = SpringLattice.grid((9, 3, 3))
    forces = np.where(side(lattice, "right")[:, None], [0.0, 0.0, 1e-3], 0.0)
    case = LoadCase("bent", side(lattice, "left"), forces)

    def deflection(poisson, formulation):
        reference = FemReference(lattice, young=1.0, poisson=poisson, formulation=formulation)
        return (reference.deform(case) - lattice.nodes)[:, 2].max()

    assert deflection(0.4999, "b-bar") == pytest.approx(deflection(0.45, "b-bar"), rel=0.05)
    assert deflection(0.4999, "standard") < 0.5 * deflection(0.4999, "b-bar")


def test_cooks_membrane_at_large_strain_moves_as_far_as_others_find():
    """The rubber of Simo and Armero (1992), shear modulus 80.194, load 100: its upper corner rises by about 6.9.

    Measured with 8, 16, 32 a side: 6.62, 6.81, 6.88.
    """
    shear = 80.1938
    options = {"poisson": 0.4999, "formulation": "b-bar", "height": 60.0}
    rise = cooks_membrane(16, "neo-hookean", 100.0 / (2 * 1.4999 * shear), **options)
    assert rise == pytest.approx(6.81, abs=0.01)


@pytest.mark.parametrize(("cell", "shape", "other"), [("triangle", (3, 3), "quad"), ("tetra", (3, 3, 3), "hexahedron")])
def test_simplices_are_refused_with_the_cells_to_use(cell, shape, other):
    with pytest.raises(UserError, match=f"does not help {cell} cells, .*; use {other} cells"):
        FemReference(SpringLattice.grid(shape, cell=cell), young=1.0, poisson=0.3, plane="strain", formulation="b-bar")


def test_plane_stress_is_refused():
    with pytest.raises(UserError, match="plane stress does not lock"):
        FemReference(SpringLattice.grid((3, 3)), young=1.0, poisson=0.3, formulation="b-bar")


def test_an_unknown_formulation_is_refused():
    with pytest.raises(
        UserError, match=r"formulation must be 'standard' or 'b-bar', not 'bbar'\. Did you mean 'b-bar'"
    ):
        FemReference(SpringLattice.grid((3, 3)), young=1.0, poisson=0.3, formulation="bbar")
