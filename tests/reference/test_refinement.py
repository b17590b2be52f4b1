"""Finer elements of one body: they keep the nodes, supports and loads of its mesh, and approach what is known."""

from dataclasses import dataclass

import numpy as np
import pytest

from springopt.cells import boundary_facets
from springopt.effects.effect import Effect
from springopt.effects.gravity import Gravity
from springopt.errors import UserError
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.reference.discretization import mass_matrix, surface_mass_matrix
from springopt.reference.fem import FemReference
from springopt.reference.refinement import Refinement

SHAPES = {"triangle": (4, 3), "quad": (4, 3), "tetra": (3, 4, 3), "hexahedron": (3, 4, 3)}
every_cell = pytest.mark.parametrize("cell", SHAPES)
FINER = [(1, 1), (2, 1), (0, 2), (1, 2)]
every_finer = pytest.mark.parametrize(("divisions", "order"), FINER)
LAWS = ["linear", "saint-venant-kirchhoff", "neo-hookean"]


def uneven(cell):
    """A mesh whose nodes inside are moved at random, so that the facets of its boundary stay flat."""
    lattice = SpringLattice.grid(SHAPES[cell], cell=cell)
    nodes = lattice.nodes.copy()
    inside = np.all((nodes > 0) & (nodes < nodes.max(axis=0)), axis=1)
    nodes[inside] += np.random.default_rng(0).uniform(-0.2, 0.2, nodes[inside].shape)
    return SpringLattice(nodes, lattice.springs, cells=lattice.cells, cell_type=cell)


def refinement(lattice, divisions=1, order=1):
    return Refinement((lattice.nodes, lattice.cells, lattice.cell_type), divisions, order)


def outer(lattice):
    return np.any((lattice.nodes == lattice.nodes.min(axis=0)) | (lattice.nodes == lattice.nodes.max(axis=0)), axis=1)


def rollers(lattice, *names):
    """Supports of sides across themselves."""
    axes = {"left": 0, "right": 0, "front": 1, "back": 1, "bottom": -1, "top": -1}
    supports = np.zeros(lattice.nodes.shape, dtype=bool)
    for name in names:
        supports[side(lattice, name), axes[name]] = True
    return supports


@every_cell
@every_finer
def test_the_nodes_of_the_mesh_come_first(cell, divisions, order):
    lattice = uneven(cell)
    finer = refinement(lattice, divisions, order)
    nodes = finer.interpolation @ lattice.nodes
    np.testing.assert_array_equal(nodes[: lattice.node_count], lattice.nodes)
    np.testing.assert_allclose(nodes[: len(finer.mesh[0])], finer.mesh[0], atol=1e-14)
    assert len(finer.mesh[1]) == len(lattice.cells) * 2 ** (lattice.dimension * divisions)


@every_cell
@every_finer
def test_loads_do_the_same_work_as_the_nodal_forces_where_the_mesh_can_tell(cell, divisions, order):
    """Totals and moments are a part of that. There are pulls on a side, on single nodes, and inside."""
    lattice = uneven(cell)
    rng = np.random.default_rng(1)
    forces = rng.normal(size=lattice.nodes.shape) * (rng.random(lattice.nodes.shape) < 0.4)
    forces[side(lattice, "right"), 0] += 5.0
    finer = refinement(lattice, divisions, order)
    np.testing.assert_allclose(finer.interpolation.T @ finer.loads(forces), forces, atol=1e-12)
    np.testing.assert_allclose(finer.interpolation.T @ finer.body_loads(forces), forces, atol=1e-12)


@every_cell
def test_elements_of_the_mesh_itself_bear_the_nodal_forces(cell):
    lattice = uneven(cell)
    forces = np.random.default_rng(2).normal(size=lattice.nodes.shape)
    np.testing.assert_allclose(refinement(lattice, 0).loads(forces), forces, atol=1e-12)


def test_a_side_is_pulled_there_alone():
    lattice = SpringLattice.grid((4, 4))
    forces = np.zeros(lattice.nodes.shape)
    forces[side(lattice, "right")] = [1.0, 0.5]
    finer = refinement(lattice, 2)
    is_pulled = finer.loads(forces).any(axis=1)
    np.testing.assert_array_equal(is_pulled, finer.mesh[0][:, 0] == 3.0)


@pytest.mark.parametrize("law", LAWS)
@every_cell
@every_finer
def test_a_bar_that_is_pulled_evenly_stretches_evenly(cell, divisions, order, law):
    """The patch test, with loads: all elements have the same answer, at large strain as well."""
    lattice = uneven(cell)
    facets = boundary_facets(lattice.cells, cell)
    ends = facets[side(lattice, "right")[facets].all(axis=1)]
    forces = np.zeros(lattice.nodes.shape)
    forces[:, 0] = 0.5 * surface_mass_matrix(lattice.nodes, lattice.cells, cell, ends).sum(axis=1).ravel()
    case = LoadCase("pull", rollers(lattice, "left", "bottom", *(["front"] if lattice.dimension == 3 else [])), forces)
    material = {"young": 10.0, "poisson": 0.3, "law": law}
    known = FemReference(lattice, **material).deform(case)
    found = FemReference(lattice, **material, order=order, refinements=divisions).deform(case)
    assert known[:, 0].max() > lattice.nodes[:, 0].max() + 0.05
    np.testing.assert_allclose(found, known, atol=1e-9)


@every_cell
def test_rigid_motions_of_second_order_elements_need_no_force(cell):
    lattice = uneven(cell)
    reference = FemReference(lattice, young=7.0, poisson=0.3, order=2)
    spin = np.random.default_rng(1).normal(size=(lattice.dimension, lattice.dimension))
    motion = refinement(lattice, 0, 2).interpolation @ (lattice.nodes @ (spin - spin.T) + 1.0)
    np.testing.assert_allclose(reference.stiffness_matrix @ motion.ravel(), 0.0, atol=1e-11)


@every_cell
@pytest.mark.parametrize("divisions", [0, 1])
def test_a_column_under_its_own_weight_is_exact_with_second_order_elements(cell, divisions):
    """Between smooth walls its displacement is quadratic: rho g (y^2 / 2 - L y) / M, with M of confined compression."""
    lattice = SpringLattice.grid(SHAPES[cell], cell=cell)
    walls = ["left", "right", "bottom"] + (["front", "back"] if lattice.dimension == 3 else [])
    case = LoadCase("standing", rollers(lattice, *walls), np.zeros(lattice.nodes.shape))
    gravity = Gravity([0.0] * (lattice.dimension - 1) + [-9.81], density=0.3)
    reference = FemReference(
        lattice, young=50.0, poisson=0.3, plane="strain", order=2, refinements=divisions, effects=[gravity]
    )
    y, height = lattice.nodes[:, -1], lattice.nodes[:, -1].max()
    expected = lattice.nodes.copy()
    expected[:, -1] += 0.3 * 9.81 * (y**2 / 2 - height * y) / (50.0 * 0.7 / (1.3 * 0.4))
    np.testing.assert_allclose(reference.deform(case), expected, atol=1e-12)


@dataclass(frozen=True)
class InsideForce(Effect):
    """A force by volume that is linear in each cell and vanishes at the boundary."""

    acts_from_outside = True

    def constant_forces(self, lattice, fitted=frozenset()):
        hump = np.sin(np.pi * lattice.nodes / lattice.nodes.max(axis=0)).prod(axis=1)
        densities = np.outer(np.where(outer(lattice), 0.0, hump), [1.0, -0.5])
        return mass_matrix(lattice.nodes, lattice.cells, lattice.cell_type) @ densities


def orders(lattice, case, law, order, levels, finest):
    """Observed between one level and the next, of the mean distance at the nodes."""
    body = {"young": 20.0, "poisson": 0.3, "law": law, "effects": [InsideForce()]}
    known = FemReference(lattice, **body, order=2, refinements=finest).deform(case)
    answers = [FemReference(lattice, **body, order=order, refinements=level).deform(case) for level in levels]
    errors = [np.linalg.norm(answer - known, axis=1).mean() for answer in answers]
    return np.log2(np.array(errors[:-1]) / errors[1:])


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("cell", "least"), [("quad", 3.5), ("triangle", 2.7)])
def test_a_smooth_problem_shows_the_orders_of_theory(cell, least, law):
    """Between smooth walls, which a reflection takes away. At nodes that all meshes have order 3 may be 4."""
    lattice = SpringLattice.grid((5, 5), cell=cell)
    case = LoadCase("pushed inside", rollers(lattice, "left", "right", "bottom", "top"), np.zeros(lattice.nodes.shape))
    assert 1.7 < orders(lattice, case, law, 1, (1, 2), 3)[-1] < 2.3
    assert least < orders(lattice, case, law, 2, (1, 2), 3)[-1] < 4.5


def test_cook_s_membrane_bends_as_the_literature_has_it():
    """The middle of the free end rises by 23.96 (Cook 1974, the limit of fine meshes)."""
    lattice = SpringLattice.grid((5, 5))
    x, y = lattice.nodes.T / 4
    nodes = np.stack([48 * x, 44 * x + y * (44 - 28 * x)], axis=1)
    forces = np.zeros(nodes.shape)
    forces[side(lattice, "right"), 1] = [1 / 8, 1 / 4, 1 / 4, 1 / 4, 1 / 8]
    case, mesh = LoadCase("shear", side(lattice, "left"), forces), (nodes, lattice.cells, "quad")
    rises = {
        (order, refinements): FemReference(mesh, young=1.0, poisson=1 / 3, order=order, refinements=refinements).deform(
            case
        )[14, 1]
        - nodes[14, 1]
        for order, refinements in [(1, 0), (1, 2), (2, 0), (2, 2)]
    }
    assert abs(rises[2, 2] - 23.96) < 0.02
    assert abs(rises[2, 0] - 23.96) < 0.15 < abs(rises[1, 2] - 23.96) < 1.0 < abs(rises[1, 0] - 23.96)


def test_a_support_holds_what_lies_between_its_nodes_and_moves_it_linearly():
    lattice = SpringLattice.grid((3, 3))
    prescribed = np.full(lattice.nodes.shape, np.nan)
    prescribed[:3, 0] = [0.1, 0.3, 0.7]
    prescribed[8, 1] = 0.0
    case = LoadCase("moved", np.zeros(lattice.nodes.shape, dtype=bool), np.zeros(lattice.nodes.shape), prescribed)
    finer = refinement(lattice, 2)
    found, nodes = finer.load_case(case), finer.mesh[0]
    bottom = nodes[:, 1] == 0.0
    np.testing.assert_array_equal(found.supports[:, 0], bottom)
    np.testing.assert_allclose(found.prescribed[bottom, 0], np.interp(nodes[bottom, 0], [0, 1, 2], [0.1, 0.3, 0.7]))
    assert np.flatnonzero(found.supports[:, 1]).tolist() == [8]
    assert finer.count_points(case.supports) == 1


def test_sides_that_meet_hold_no_corner_between_them():
    """The edge across a triangle in the corner joins two held nodes, by chance."""
    lattice = SpringLattice.grid((3, 3), cell="triangle")
    supports = side(lattice, "left") | side(lattice, "top")
    case = LoadCase("held", supports, np.zeros(lattice.nodes.shape))
    finer = refinement(lattice, 2)
    found, (x, y) = finer.load_case(case), finer.mesh[0].T
    np.testing.assert_array_equal(found.supports.all(axis=1), (x == 0.0) | (y == 2.0))


def test_a_held_line_inside_stays_a_line():
    lattice = SpringLattice.grid((5, 5))
    supports = lattice.nodes[:, 0] == 2.0
    finer = refinement(lattice, 1, 2)
    found = finer.load_case(LoadCase("held", supports, np.zeros(lattice.nodes.shape)))
    nodes = finer.interpolation @ lattice.nodes
    np.testing.assert_array_equal(found.supports.all(axis=1), nodes[:, 0] == 2.0)


@pytest.mark.parametrize("changes", [{"order": 2}, {"refinements": 1}, {"refinements": 1, "lumped": True}])
def test_a_motion_settles_where_the_equilibrium_is(changes):
    lattice = SpringLattice.grid((3, 3))
    forces = np.zeros(lattice.nodes.shape)
    forces[side(lattice, "right")] = [0.2, -0.3]
    body = FemReference(lattice, young=10.0, poisson=0.3, density=1.0, mass_damping=4.0, **changes)
    rest = body.deform(LoadCase("rest", side(lattice, "left"), forces))
    motion = body.deform(LoadCase("motion", side(lattice, "left"), forces, times=np.array([0.5, 200.0])))
    assert motion.shape == (2, 9, 2)
    np.testing.assert_allclose(motion[1], rest, atol=1e-9)
    assert np.abs(motion[0] - rest).max() > 1e-3


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"order": 3}, "order must be 1 or 2"),
        ({"order": True}, "order must be 1 or 2"),
        ({"refinements": -1}, "refinements must be a whole number"),
        ({"refinements": 1.0}, "refinements must be a whole number"),
        ({"refinements": 10}, "at most 1,000,000 are tried"),
        ({"order": 2, "plane": "strain", "formulation": "b-bar"}, "'b-bar' is for first-order elements"),
        ({"order": 2, "density": 1.0, "lumped": True}, "lumped mass is for first-order elements"),
    ],
)
def test_what_elements_can_t_be_is_refused(changes, fault):
    with pytest.raises(UserError, match=fault):
        FemReference(SpringLattice.grid((3, 3)), young=1.0, poisson=0.3, **changes)
