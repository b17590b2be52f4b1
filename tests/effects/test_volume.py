"""Cells that keep their area or volume."""

import pickle

import numpy as np
import pytest
from catalogue import body

import springopt as so
from springopt.effects.probe import probe
from springopt.effects.volume import volume_coefficients
from springopt.nodal_volumes import nodal_volumes

GRID, SOLID = so.SpringLattice.grid((5, 4)), so.SpringLattice.grid((4, 3, 3))


def corners_of_one(shape, cell):
    lattice = body(shape, cell, seed=5)
    return lattice.nodes, lattice.cells[:1], lattice.cell_type


@pytest.mark.parametrize("cell", ["tetra", "hexahedron"])
def test_the_polynomial_of_a_cell_is_its_integrated_volume(cell):
    nodes, cells, cell_type = corners_of_one((2, 2, 2), cell)
    x = nodes[cells[0]]
    dets = np.einsum("pa,qra->pqr", x, np.cross(x[:, None], x[None]))
    volume = (volume_coefficients(cell_type) * dets).sum() / 6.0
    assert volume == pytest.approx(nodal_volumes(nodes, cells, cell_type).sum(), rel=1e-13)


@pytest.mark.parametrize("where", ["triangle", "quad", "tetra", "hexahedron"])
def test_a_cell_pays_for_the_change_of_its_volume(where):
    shape = (2, 2) if where in ("triangle", "quad") else (2, 2, 2)
    lattice = body(shape, where, seed=5)
    u = 0.3 * np.random.default_rng(6).standard_normal(lattice.nodes.shape)
    kernel = so.Volume(3.0).potential(lattice)
    found = probe(kernel, lattice, u.reshape(1, -1), stiffness=np.zeros(lattice.spring_count), values=np.array([3.0]))
    expected = 0.0
    for cell in lattice.cells:
        rest, now = (nodal_volumes(x, cell[None], where).sum() for x in (lattice.nodes, lattice.nodes + u))
        expected += 1.5 * rest * (now / rest - 1.0) ** 2
    assert found.energy[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("lattice", [GRID, SOLID], ids=["2D", "3D"])
def test_a_small_swelling_keeps_its_digits(lattice):
    far = so.SpringLattice(lattice.nodes + 1000.0, lattice.springs, None, lattice.cells, lattice.cell_type)
    kernel = so.Volume(1.0).potential(far)
    u = 1e-9 * lattice.nodes.reshape(1, -1)
    found = probe(kernel, far, u, stiffness=np.zeros(far.spring_count), values=np.ones(1))
    growth = (1.0 + 1e-9) ** lattice.dimension - 1.0
    assert found.energy[0] == pytest.approx(0.5 * len(lattice.cells) * growth**2, rel=1e-6)


def halved_at_the_boundary(lattice, straight, diagonal):
    """Stiffness by how many of the cells around an inner spring are there; by the axes that a spring runs along."""
    members = np.zeros((lattice.node_count, len(lattice.cells)), dtype=int)
    members[lattice.cells.T, np.arange(len(lattice.cells))] = 1
    shared = (members[lattice.springs[:, 0]] * members[lattice.springs[:, 1]]).sum(axis=1)
    axes = np.count_nonzero(lattice.nodes[lattice.springs[:, 1]] != lattice.nodes[lattice.springs[:, 0]], axis=1)
    inside = 2.0 ** (lattice.dimension - axes)
    return np.array([0.0, straight, *diagonal])[axes] * shared / inside


@pytest.mark.parametrize("modulus", [0.0, 1.0, 100.0])
@pytest.mark.parametrize("lattice", [GRID, SOLID], ids=["2D", "3D"])
def test_springs_and_volume_have_the_poisson_ratio_of_the_formula(lattice, modulus):
    d = lattice.dimension
    if d == 2:
        stiffness, c11, c12 = halved_at_the_boundary(lattice, 2.0, [1.0]), 3.0, 1.0
        expected = (c12 + modulus) / (c11 + modulus)
    else:
        stiffness, c11, c12 = halved_at_the_boundary(lattice, 11.0 / 3.0, [1.0, 1.0]), 7.0, 7.0 / 3.0
        expected = (c12 + modulus) / (c11 + c12 + 2.0 * modulus)
    supports = np.zeros(lattice.nodes.shape, dtype=bool)
    for axis in range(d):
        supports[lattice.nodes[:, axis] == 0, axis] = True
    forces = np.zeros(lattice.nodes.shape)
    across = lattice.nodes[:, 1:]
    share = np.where((across == 0) | (across == across.max(axis=0)), 0.5, 1.0).prod(axis=1)
    forces[:, 0] = np.where(so.side(lattice, "right"), 1e-9 * share, 0.0)
    solution = so.Model(lattice, so.Volume(modulus)).solve(stiffness, [so.LoadCase("pull", supports, forces)])
    assert solution.status[0] == "converged"
    strain = solution.displacements[0, -1] / lattice.nodes[-1]
    assert -strain[1] / strain[0] == pytest.approx(expected, rel=1e-6)
    if modulus == 0.0:
        assert expected == pytest.approx(1 / 3 if d == 2 else 1 / 4)


def areas(lattice, positions):
    return nodal_volumes(positions, lattice.cells, lattice.cell_type).sum()


@pytest.mark.parametrize("engine", ["lanes", "sparse", "iterative"])
@pytest.mark.parametrize("lattice", [GRID, SOLID], ids=["2D", "3D"])
def test_the_volume_is_kept_the_better_the_stiffer_cells_are(lattice, engine):
    forces = np.where(so.side(lattice, "top")[:, None], np.eye(lattice.dimension)[-1] * -0.3, 0.0)
    case = so.LoadCase("press", so.side(lattice, "bottom"), forces)
    stiffness, changes = np.full(lattice.spring_count, 2.0), []
    for modulus in (1e2, 2e4):
        solution = so.Model(lattice, so.Volume(modulus), engine=engine).solve(stiffness, [case])
        assert solution.status[0] == "converged"
        changes.append(areas(lattice, solution.positions[0]) - areas(lattice, lattice.nodes))
    assert changes[0] / changes[1] == pytest.approx(200.0, rel=0.1)


@pytest.mark.parametrize("engine", ["lanes", "sparse"])
def test_cells_ten_thousand_times_as_stiff_as_springs_find_their_equilibria(engine):
    rng = np.random.default_rng(7)
    for lattice in (GRID, SOLID):
        stiffness = rng.uniform(1.0, 5.0, lattice.spring_count)
        cases = [
            so.LoadCase(str(n), so.side(lattice, "left"), rng.normal(0, size, lattice.nodes.shape))
            for n, size in enumerate((1e-6, 0.01, 0.1, 0.3))
        ]
        solution = so.Model(lattice, so.Volume(3e4), engine=engine).solve(stiffness, cases)
        assert (solution.status == "converged").all()


def test_a_cell_that_was_turned_inside_out_turns_back():
    nodes = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    lattice = so.SpringLattice(nodes, [[0, 2], [1, 2]], None, np.array([[0, 1, 2]]), "triangle")
    swapped = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]])
    case = so.LoadCase("swap", [True, True, False], np.zeros((3, 2)), swapped)
    solution = so.Model(lattice, so.Volume(10.0)).solve([1.0, 1.0], [case])
    assert solution.status[0] == "converged"
    np.testing.assert_allclose(solution.positions[0, 2], [1.0, -1.0], atol=1e-7)


@pytest.mark.parametrize(
    ("lattice", "modulus", "message"),
    [
        (so.SpringLattice([[0, 0], [1, 0]], [[0, 1]]), 1.0, "volume acts on cells, but this lattice has none"),
        (GRID, [1.0, 2.0], r"modulus must have the shape \(12,\), not \(2,\)"),
        (GRID, -1.0, "modulus is -1, but it must be finite and not negative"),
    ],
)
def test_options_that_do_not_fit_are_refused(lattice, modulus, message):
    with pytest.raises(so.UserError, match=message):
        so.Model(lattice, so.Volume(modulus))


@pytest.mark.parametrize("effect", [so.Volume(3.0), so.Bending(2.0)])
def test_a_body_that_nothing_holds_is_pushed_away_whatever_keeps_its_shape(effect):
    grid = so.SpringLattice.grid((4, 3))
    forces = np.zeros(grid.nodes.shape)
    forces[5, 0] = 0.1
    case = so.LoadCase("pushed", np.zeros(grid.nodes.shape, dtype=bool), forces)
    solution = so.Model(grid, [effect]).solve(np.ones(grid.spring_count), [case])
    assert solution.status[0] is so.Status.MECHANISM


def test_models_with_effects_are_sent_to_workers():
    grid = so.SpringLattice.grid((4, 3))
    model = so.Model(grid, [so.Volume(3.0)])
    case = so.LoadCase("pull", so.side(grid, "left"), np.full(grid.nodes.shape, 0.01))
    stiffness = np.ones(grid.spring_count)
    there = pickle.loads(pickle.dumps(model)).solve(stiffness, [case]).positions
    np.testing.assert_array_equal(there, model.solve(stiffness, [case]).positions)
