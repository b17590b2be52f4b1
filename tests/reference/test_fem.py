import json
from pathlib import Path

import meshio
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from springopt.errors import UserError
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.reference.fem import FemReference

DATA = Path(__file__).parents[1] / "data" / "fem"
MATERIALS = [
    (path.stem, material)
    for path in sorted(DATA.glob("*.npz"))
    for material in json.loads(str(np.load(path)["materials"]))
]
CELLS = {"triangle": (4, 3), "quad": (4, 3), "tetra": (3, 4, 2), "hexahedron": (3, 4, 2)}


def held_at(lattice, name="left", forces=None, **changes):
    forces = np.zeros(lattice.nodes.shape) if forces is None else forces
    return LoadCase(**({"name": "case", "supports": side(lattice, name), "forces": forces} | changes))


def moved_everywhere_outside(lattice, displacements):
    """A load case that prescribes the displacements of all nodes on the bounding box."""
    low, high = lattice.nodes.min(axis=0), lattice.nodes.max(axis=0)
    outside = np.any((lattice.nodes == low) | (lattice.nodes == high), axis=1)
    return LoadCase("moved", outside, np.zeros(lattice.nodes.shape), np.where(outside[:, None], displacements, np.nan))


def uneven(lattice, rng, share=0.25):
    """The same lattice with its nodes moved at random by a share of the spacing."""
    nodes = lattice.nodes + rng.uniform(-share, share, lattice.nodes.shape)
    return SpringLattice(nodes, lattice.springs, cells=lattice.cells, cell_type=lattice.cell_type)


@pytest.mark.parametrize(
    ("mesh", "material"), MATERIALS, ids=[f"{mesh}-{material['name']}" for mesh, material in MATERIALS]
)
def test_deformations_agree_with_another_code(mesh, material):
    data = np.load(DATA / f"{mesh}.npz")
    plane = "strain" if material["hyp"] == "plane_strain" else "stress"
    reference = FemReference(
        (data["points"], data["cells"], str(data["cell_type"])),
        young=material["E"],
        poisson=material["nu"],
        plane=plane,
    )
    for name, load, expected in zip(data["load_names"], data["loads"], data[f"u|{material['name']}"], strict=True):
        case = LoadCase(str(name), data["fixed"], load * material["E"] / data["E_ref"])
        displacements = reference.deform(case) - data["points"]
        # The other codes agree among themselves to 1e-12.
        assert np.linalg.norm(displacements - expected) <= 1e-11 * np.linalg.norm(expected)


def test_a_mesh_file_a_meshio_mesh_and_a_lattice_give_the_same_reference():
    path = DATA / "ellipse_hole.msh"
    lattice = SpringLattice.from_mesh(path)
    x = lattice.nodes[:, 0]
    case = LoadCase("pull", x < x.min() + 0.1 * np.ptp(x), np.full(lattice.nodes.shape, 1e-3))
    answers = [FemReference(mesh, young=1.0, poisson=0.3).deform(case) for mesh in (path, meshio.read(path), lattice)]
    np.testing.assert_array_equal(answers[0], answers[1])
    np.testing.assert_array_equal(answers[0], answers[2])


@pytest.mark.parametrize(("cell", "shape"), CELLS.items())
@pytest.mark.parametrize("plane", ["stress", "strain"])
def test_an_affine_motion_of_the_outside_moves_the_inside_alike(cell, shape, plane):
    rng = np.random.default_rng(0)
    lattice = SpringLattice.grid([count + 1 for count in shape], cell=cell)
    displacements = lattice.nodes @ rng.normal(size=(len(shape), len(shape))) + rng.normal(size=len(shape))
    positions = FemReference(lattice, young=7.0, poisson=0.3, plane=plane).deform(
        moved_everywhere_outside(lattice, displacements)
    )
    np.testing.assert_allclose(positions, lattice.nodes + displacements, atol=1e-12)


@pytest.mark.parametrize(("cell", "shape"), CELLS.items())
@pytest.mark.parametrize(("plane", "poisson"), [("stress", 0.3), ("strain", 0.3), ("stress", 0.0), ("stress", -0.5)])
def test_a_bar_under_tension_stretches_and_narrows_as_its_material_says(cell, shape, plane, poisson):
    lattice, young, strain = SpringLattice.grid(shape, cell=cell), 7.0, 0.01
    lateral = poisson / (1 - poisson) if plane == "strain" and len(shape) == 2 else poisson
    expected = lattice.nodes * [strain, *[-lateral * strain] * (len(shape) - 1)]
    supports = np.stack(
        [side(lattice, name) for name in (["left", "bottom"] if len(shape) == 2 else ["left", "front", "bottom"])], 1
    )
    prescribed = np.where(supports, 0.0, np.nan)
    prescribed[side(lattice, "right"), 0] = strain * (shape[0] - 1)
    case = LoadCase("tension", supports, np.zeros(lattice.nodes.shape), prescribed)
    reference = FemReference(lattice, young=young, poisson=poisson, plane=plane)
    positions = reference.deform(case)
    np.testing.assert_allclose(positions, lattice.nodes + expected, atol=1e-13)
    reaction = (reference.stiffness_matrix @ expected.ravel()).reshape(expected.shape)[side(lattice, "right"), 0].sum()
    modulus = young / (1 - poisson**2) if plane == "strain" and len(shape) == 2 else young
    assert reaction == pytest.approx(modulus * strain * np.prod(np.array(shape[1:]) - 1))


def gauss_stiffness(corners, young, poisson):
    """Stiffness of one plane-stress quadrilateral by two Gauss points a direction, written out."""
    elasticity = young / (1 - poisson**2) * np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    stiffness = np.zeros((8, 8))
    for point in signs / np.sqrt(3):
        gradients = signs * (1 + signs * point)[:, ::-1] / 4
        jacobian = gradients.T @ corners
        x, y = np.linalg.solve(jacobian, gradients.T)
        strain = np.zeros((3, 8))
        strain[0, ::2], strain[1, 1::2], strain[2, ::2], strain[2, 1::2] = x, y, y, x
        stiffness += np.linalg.det(jacobian) * strain.T @ elasticity @ strain
    return stiffness


def test_a_distorted_quadrilateral_has_two_gauss_points_in_each_direction():
    corners = np.array([[0.0, 0.0], [2.0, 0.3], [1.4, 1.9], [-0.3, 0.8]])
    reference = FemReference((corners, [[0, 1, 2, 3]], "quad"), young=3.0, poisson=0.3)
    expected = gauss_stiffness(corners, 3.0, 0.3)
    np.testing.assert_allclose(reference.stiffness_matrix.toarray(), expected, atol=1e-13)


@pytest.mark.parametrize("cell", CELLS)
def test_rigid_motions_of_a_distorted_body_need_no_force(cell):
    rng = np.random.default_rng(1)
    lattice = uneven(SpringLattice.grid(CELLS[cell], cell=cell), rng, share=0.1)
    matrix = FemReference(lattice, young=7.0, poisson=0.3).stiffness_matrix
    spin = rng.normal(size=(lattice.dimension, lattice.dimension))
    motion = lattice.nodes @ (spin - spin.T) + rng.normal(size=lattice.dimension)
    np.testing.assert_allclose(matrix @ motion.ravel(), 0.0, atol=1e-12)


@given(young=st.floats(1e-9, 1e9), thickness=st.floats(1e-3, 1e3))
def test_stiffness_is_proportional_to_modulus_and_thickness(young, thickness):
    lattice = SpringLattice.grid((3, 3))
    forces = np.random.default_rng(2).normal(size=lattice.nodes.shape)
    unit = FemReference(lattice, young=1.0, poisson=0.3).deform(held_at(lattice, forces=forces))
    scaled = FemReference(lattice, young=young, poisson=0.3, thickness=thickness).deform(
        held_at(lattice, forces=forces * young * thickness)
    )
    np.testing.assert_allclose(scaled, unit, rtol=1e-9, atol=1e-12)


def test_no_load_moves_nothing():
    lattice = SpringLattice.grid((3, 3, 3))
    np.testing.assert_array_equal(FemReference(lattice, young=1.0, poisson=0.3).deform(held_at(lattice)), lattice.nodes)


def test_a_force_on_a_support_moves_nothing():
    lattice = SpringLattice.grid((3, 3))
    forces = np.where(side(lattice, "left")[:, None], 1.0, 0.0) * np.ones(2)
    positions = FemReference(lattice, young=1.0, poisson=0.3).deform(held_at(lattice, forces=forces))
    np.testing.assert_array_equal(positions, lattice.nodes)


def test_a_body_held_everywhere_stays():
    lattice = SpringLattice.grid((2, 2))
    case = LoadCase("held", np.ones(4, bool), np.ones((4, 2)))
    np.testing.assert_array_equal(FemReference(lattice, young=1.0, poisson=0.3).deform(case), lattice.nodes)


def test_load_cases_with_other_supports_do_not_disturb_each_other():
    lattice = SpringLattice.grid((3, 3))
    forces = np.random.default_rng(3).normal(size=lattice.nodes.shape)
    shared = FemReference(lattice, young=10.0, poisson=0.3)
    for name in ("left", "right", "left"):
        case = held_at(lattice, name, forces=forces)
        np.testing.assert_array_equal(shared.deform(case), FemReference(lattice, young=10.0, poisson=0.3).deform(case))


def test_plane_stress_bears_the_incompressible_half():
    lattice = SpringLattice.grid((5, 5))
    case = held_at(lattice, forces=0.1 * side(lattice, "right")[:, None] * np.array([1.0, 0.0]))
    half, nearly = (FemReference(lattice, young=1.0, poisson=poisson).deform(case) for poisson in (0.5, 0.5 - 1e-9))
    np.testing.assert_allclose(half, nearly, atol=1e-8)


@pytest.mark.parametrize(
    ("shape", "plane", "poisson"),
    [
        ((3, 3), "strain", 0.5),
        ((3, 3), "strain", np.nan),
        ((3, 3), "stress", 0.51),
        ((3, 3), "stress", -1.0),
        ((3, 3, 3), "stress", 0.5),
    ],
)
def test_poissons_ratio_outside_its_range_is_refused(shape, plane, poisson):
    with pytest.raises(UserError, match="Poisson's ratio must be above -1"):
        FemReference(SpringLattice.grid(shape), young=1.0, poisson=poisson, plane=plane)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"young": -1.0}, "young is -1, but it must be positive"),
        ({"young": 0.0}, "young is 0"),
        ({"young": np.nan}, "young is nan"),
        ({"young": [1.0, 2.0]}, r"young must have the shape \(\)"),
        ({"young": "10"}, "young must hold real numbers"),
        ({"thickness": 0.0}, "thickness is 0"),
        ({"plane": "strian"}, "plane must be 'stress' or 'strain', not 'strian'"),
    ],
)
def test_an_impossible_material_is_refused(changes, sentence):
    with pytest.raises(UserError, match=sentence):
        FemReference(SpringLattice.grid((3, 3)), **({"young": 1.0, "poisson": 0.3} | changes))


SQUARE = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]


@pytest.mark.parametrize(
    ("mesh", "sentence"),
    [
        ((SQUARE, [[0, 1, 2, 3], [3, 2, 1, 0]], "quad"), r"cells\[1\] is inverted"),
        ((SQUARE, [[0, 1, 2], [0, 3, 2]], "triangle"), r"cells\[1\] is inverted"),
        ((SQUARE, [[0, 1, 3, 2]], "quad"), r"cells\[0\] is degenerate"),
        (([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]], [[0, 1, 2, 3]], "quad"), r"cells\[0\] is degenerate"),
        (([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [[0, 1, 2, 3]], "quad"), r"cells\[0\] is degenerate"),
        (([[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]], [[0, 1, 2, 3]], "quad"), r"cells\[0\] is degenerate"),
        ((np.eye(4, 3), [[0, 1, 2, 3]], "tetra"), r"cells\[0\] is inverted"),
        ((SQUARE, [[0, 1, 2]], "triangle"), "Node 3 belongs to no cell"),
        ((SQUARE, [[0, 1, 2, 4]], "quad"), r"cells\[0, 3\] is 4"),
        ((SQUARE, [[0, 1, 2, 3]], "qaud"), "Did you mean 'quad'"),
        ((SQUARE, [[0, 1, 2, 3]]), r"must be \(nodes, cells, cell type\)"),
        (SpringLattice(SQUARE, [[0, 1]]), "needs a lattice with cells"),
    ],
)
def test_an_impossible_mesh_is_refused_naming_the_cell(mesh, sentence):
    with pytest.raises(UserError, match=sentence):
        FemReference(mesh, young=1.0, poisson=0.3)


def test_a_hexahedron_with_two_layers_swapped_is_inverted():
    grid = SpringLattice.grid((2, 2, 2))
    with pytest.raises(UserError, match="is inverted"):
        FemReference((grid.nodes, grid.cells[:, [4, 5, 6, 7, 0, 1, 2, 3]], "hexahedron"), young=1.0, poisson=0.3)


def test_supports_that_leave_the_body_free_are_refused_with_the_number_of_modes():
    lattice = SpringLattice.grid((3, 3))
    reference = FemReference(lattice, young=1.0, poisson=0.3)
    for supports, count in [(np.zeros(9, bool), "3 rigid modes"), (np.arange(9) == 4, "1 rigid mode;")]:
        with pytest.raises(UserError, match=f"'case' leaves the body free to move in {count}"):
            reference.deform(held_at(lattice, supports=supports))


def test_a_load_case_of_another_body_is_refused():
    reference = FemReference(SpringLattice.grid((3, 3)), young=1.0, poisson=0.3)
    with pytest.raises(UserError, match=r"forces must have the shape \(9, 2\), not \(16, 2\)"):
        reference.deform(held_at(SpringLattice.grid((4, 4))))


def test_cooks_membrane_converges_to_its_known_deflection():
    """Plane stress, E = 1, nu = 1/3, a shear force of 1 over the right edge: 23.968 at the middle of that edge."""
    count = 65
    grid = SpringLattice.grid((count, count), spacing=1 / (count - 1), neighbourhood="von-neumann")
    x, y = grid.nodes.T
    nodes = np.stack([48 * x, y * (44 * (1 - x) + 16 * x) + 44 * x], axis=1)
    forces = np.zeros(nodes.shape)
    forces[side(grid, "right"), 1] = 1 / (count - 1)
    forces[(x == 1) & ((y == 0) | (y == 1)), 1] /= 2
    case = LoadCase("shear", side(grid, "left"), forces)
    positions = FemReference((nodes, grid.cells, "quad"), young=1.0, poisson=1 / 3).deform(case)
    middle = np.flatnonzero(np.all(np.isclose(nodes, [48.0, 52.0]), axis=1))[0]
    # The error falls 3.5 times with each halving of the cells: 0.63 % at 32 a side, 0.18 % here, 0.055 % at 128.
    assert positions[middle, 1] - nodes[middle, 1] == pytest.approx(23.968, rel=2e-3)
