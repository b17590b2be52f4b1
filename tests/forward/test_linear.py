"""Small displacements: against a dense solve, and against tiny loads with finite displacements."""

import numpy as np
import pytest
from engines import SCENES, load, small_displacements
from oracle import out_of_balance, tangent
from test_other_codes import HARD, hard_case

import springopt as so
from springopt.forward.status import STATUSES

GRID = so.SpringLattice.grid((5, 4))
ENGINES = [None, "sparse", "iterative"]
NAMES = ["2D", "3D", "3D, springs removed", "gravity", "rollers", "rollers in 3D", "moved supports"]


def linear(model, engine=None):
    return so.Model(model.lattice, model.effects, kinematics="linear", engine=engine)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", NAMES)
def test_it_is_what_a_dense_solve_gives(name, engine):
    model, stiffness, cases = SCENES[name]
    solution = linear(model, engine).solve(stiffness, cases)
    matrix = tangent(model.lattice, stiffness, model.lattice.nodes)
    weights = sum(effect.constant_forces(model.lattice) for effect in model.effects)
    for case, u, status in zip(cases, solution.displacements, solution.status, strict=True):
        free, known = case.free.ravel(), case.prescribed.ravel().copy()
        side = (case.forces + weights).ravel() - matrix @ known
        known[free] = np.linalg.solve(matrix[np.ix_(free, free)], side[free])
        assert status == "converged"
        np.testing.assert_allclose(u.ravel(), known, atol=1e-11)
        assert np.abs(known).max() > 0.01


@pytest.mark.parametrize("name", [*NAMES, "a stranger's effect"])
def test_it_is_the_limit_of_tiny_loads(name):
    model, stiffness, cases = SCENES[name]
    tiny, tiny_effects = 1e-6, [effect for effect in model.effects if not isinstance(effect, so.Gravity)]
    weights = sum(effect.constant_forces(model.lattice) for effect in model.effects if isinstance(effect, so.Gravity))
    small = [so.LoadCase("s", c.supports, tiny * (c.forces + weights), tiny * c.prescribed) for c in cases]
    nonlinear = so.Model(model.lattice, tiny_effects).solve(stiffness, small, 1e-12)
    solution = linear(model).solve(stiffness, cases)
    np.testing.assert_allclose(nonlinear.displacements / tiny, solution.displacements, atol=2e-6)


def test_prestress_adds_its_geometric_stiffness_and_its_forces():
    model, stiffness, cases = SCENES["prestress"]
    lattice, case = model.lattice, cases[1]
    solution = linear(model).solve(stiffness, [case])
    step, free = 1e-6, case.free.ravel()
    at_rest = out_of_balance(lattice, stiffness, lattice.nodes, case.forces).ravel()
    u = solution.displacements[0]
    pushed = (
        out_of_balance(lattice, stiffness, lattice.nodes + step * u, case.forces)
        - out_of_balance(lattice, stiffness, lattice.nodes - step * u, case.forces)
    ).ravel() / (2 * step)
    np.testing.assert_allclose((at_rest + pushed)[free], 0, atol=1e-8)
    assert solution.status[0] == "converged"
    assert np.abs(at_rest[free]).max() > 0.1


def test_compression_beyond_buckling_is_unstable_not_converged():
    column = so.SpringLattice.grid((2, 9))
    tight = so.SpringLattice(column.nodes, column.springs, 1.3 * column.rest_lengths)
    supports = so.side(column, "bottom") | so.side(column, "top")
    case = load(column, supports=supports, prescribed=np.zeros(column.nodes.shape))
    matrix = tangent(tight, np.ones(column.spring_count), column.nodes)
    free = case.free.ravel()
    assert np.linalg.eigvalsh(matrix[np.ix_(free, free)])[0] < 0
    assert linear(so.Model(tight)).solve(np.ones(column.spring_count), [case]).status[0] == "unstable"


@pytest.mark.parametrize(
    ("name", "status"),
    [("C13_F0.001", "mechanism"), ("C17", "mechanism"), ("C02a", "underdetermined"), ("C12c", "underdetermined")],
)
@pytest.mark.parametrize("solver", ["band", "superlu", "iterative"])
def test_a_load_on_a_mode_without_stiffness_has_no_small_answer(name, status, solver):
    model, case, stiffness = hard_case(HARD[name]["input"])
    found = small_displacements(model, solver, stiffness, [case])
    assert STATUSES[found.codes[0, 0]] == status
    assert np.isfinite(found.displacements).all()
    if name == "C02a":
        known = HARD[name]["expected"]["value"]["u_linear_min_norm"]
        np.testing.assert_allclose(found.displacements[0, 0], np.ravel(known), atol=1e-12)
    if name == "C12c":
        positions = model.lattice.nodes + found.displacements[0, 0].reshape(-1, 2)
        assert np.abs(positions - model.lattice.nodes).max() < 1.0


@pytest.mark.parametrize("engine", ENGINES)
def test_the_energy_is_that_of_the_second_order_expansion(engine):
    model, stiffness, cases = SCENES["moved supports"]
    solution = linear(model, engine).solve(stiffness, cases)
    matrix, u = tangent(model.lattice, stiffness, model.lattice.nodes), solution.displacements[0].ravel()
    assert solution.energy[0] == pytest.approx(0.5 * u @ matrix @ u - np.vdot(cases[0].forces, solution.positions[0]))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", ["2D", "rollers in 3D", "moved supports", "prestress", "a stranger's effect"])
def test_gradients_and_jacobians_are_derivatives(name, engine):
    model, stiffness, cases = SCENES[name]
    rng = np.random.default_rng(3)
    reference = model.lattice.nodes + rng.normal(0, 0.1, (len(cases), *model.lattice.nodes.shape))
    objective = so.Objective(linear(model, engine), cases, reference, minimize="least-squares")
    along, step = rng.normal(size=len(stiffness)), 1e-5
    _, gradient = objective.gradient(stiffness)
    residuals, jacobian = objective.jacobian(stiffness)
    after, before = (objective.residuals(stiffness + sign * step * along) for sign in (1, -1))
    np.testing.assert_allclose(jacobian @ along, (after - before) / (2 * step), atol=1e-7 * np.abs(jacobian).max())
    np.testing.assert_allclose(gradient, residuals @ jacobian, atol=1e-9 * np.abs(gradient).max())


def test_more_load_cases_than_lanes_and_several_candidates_keep_their_places():
    rng = np.random.default_rng(0)
    stiffness = rng.uniform(1, 9, (3, GRID.spring_count))
    cases = [load(GRID, force=force) for force in rng.normal(0, 0.2, (11, 2))]
    batch = linear(so.Model(GRID)).solve_many(stiffness, cases)
    for m, c in ((0, 0), (1, 7), (2, 8), (2, 10)):
        alone = linear(so.Model(GRID)).solve(stiffness[m], cases[c : c + 1])
        np.testing.assert_array_equal(batch.displacements[m, c], alone.displacements[0])


@pytest.mark.parametrize("lean", [0.3, 1e-2, 1e-6, 0.0])
def test_a_free_mode_is_kept_at_rest_and_so_it_is_in_the_gradient(lean):
    """A node that hangs on one spring: it goes along with what holds it, and not around it."""
    nodes = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.8], [0.5 + lean, 1.8]])
    lattice = so.SpringLattice(nodes, np.array([[0, 2], [1, 2], [2, 3]]))
    forces = np.array([[0.0, 0.0], [0.0, 0.0], [0.01, -0.3], [0.0, 0.0]])
    case = so.LoadCase("press", np.array([True, True, False, False]), forces)
    model, stiffness = so.Model(lattice, kinematics="linear"), np.array([3.0, 4.0, 2.0])
    solution = model.solve(stiffness, [case])
    along = (nodes[3] - nodes[2]) / np.linalg.norm(nodes[3] - nodes[2])
    moved, held = solution.displacements[0, 3], solution.displacements[0, 2]
    assert solution.status[0] == "underdetermined"
    np.testing.assert_allclose(moved, (held @ along) * along, atol=1e-9)
    objective = so.Objective(model, [case], (nodes + 0.05)[None], minimize="least-squares")
    _, gradient = objective.gradient(stiffness)
    steps = 1e-4 * np.eye(3)
    differences = (objective.evaluate(stiffness + steps).values - objective.evaluate(stiffness - steps).values) / 2e-4
    np.testing.assert_allclose(gradient, differences, atol=1e-8)


def test_twice_the_load_moves_twice_as_far():
    stiffness = np.full(GRID.spring_count, 4.0)
    cases = [load(GRID, force=(0.3, -0.2)), load(GRID, force=(0.6, -0.4))]
    once, twice = linear(so.Model(GRID)).solve(stiffness, cases).displacements
    np.testing.assert_allclose(twice, 2 * once, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("name", ["2D", "3D", "gravity", "rollers", "moved supports", "prestress"])
def test_eight_at_a_time_they_are_those_of_one_by_one_mechanisms_and_all(name):
    """Candidates with few springs, a node without any, and none at all are left to the engine that tells free modes."""
    model, stiffness, cases = SCENES[name]
    rng = np.random.default_rng(12)
    candidates = stiffness * (rng.random((21, len(stiffness))) < np.linspace(0.4, 1.2, 21)[:, None])
    candidates[3] = 0.0
    nothing = linear(model).solve_many(0.0 * candidates[:2], cases)
    assert (nothing.status != "converged").all()
    candidates[20, (model.lattice.springs == 7).any(axis=1)] = 0.0
    together, apart = (linear(model, engine).solve_many(candidates, cases) for engine in (None, "sparse"))
    assert {group.choice.solver for group in linear(model).groups(cases)} == {"lanes"}
    np.testing.assert_array_equal(together.status, apart.status)
    assert len(set(together.status.ravel())) > 1
    scale = np.maximum(np.abs(apart.displacements).max(axis=(2, 3), keepdims=True), 1e-12)
    found = together.status == "converged"
    np.testing.assert_allclose((together.displacements / scale)[found], (apart.displacements / scale)[found], atol=1e-7)
    np.testing.assert_allclose(together.energy[found], apart.energy[found], rtol=1e-7, atol=1e-9)
