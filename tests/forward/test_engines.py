"""Every engine finds the equilibria that lanes find, with the same status."""

import numpy as np
import pytest
from engines import ENGINES, SCENES, equilibria, load
from oracle import out_of_balance, smallest_eigenvalue, tangent

import springopt as so
from springopt.forward.batch import find
from springopt.forward.choose import choose
from springopt.forward.rest_modes import zero_mode_counts
from springopt.forward.status import STATUSES

COLUMN = so.SpringLattice.grid((2, 9))
GRID = so.SpringLattice.grid((5, 4))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", SCENES)
def test_engines_agree(name, engine):
    model, stiffness, cases = SCENES[name]
    known = equilibria(model, "lanes", stiffness, cases)
    found = equilibria(model, engine, stiffness, cases)
    assert (STATUSES[known.codes] == "converged").all()
    np.testing.assert_array_equal(found.codes, known.codes)
    np.testing.assert_allclose(found.displacements, known.displacements, atol=1e-8)
    np.testing.assert_allclose(found.energies, known.energies, rtol=1e-10, atol=1e-12)
    if name != "everything held":
        assert np.abs(known.displacements).max() > 0.01  # there is something to agree on


@pytest.mark.parametrize("engine", ENGINES)
def test_engines_agree_on_what_is_no_equilibrium_or_not_the_only_one(engine):
    lattice = so.SpringLattice([[0, 0], [1, 0], [0, 1], [1, 1], [5, 5]], [[0, 2], [1, 3], [2, 3]])
    held = [True, True, False, False, False]
    loads = {"converged": (0.0, 0.8), "underdetermined": (0.0, 0.0), "mechanism": (0.1, 0.0)}
    for status, force in loads.items():
        forces = np.zeros((5, 2))
        forces[[2, 3]] = force
        forces[4] = (0.1, 0) if status == "mechanism" else 0
        case = so.LoadCase(status, held, forces)
        stiffness = np.array([4.0, 4.0, 4.0])
        found = equilibria(so.Model(lattice), engine, stiffness, [case])
        known = equilibria(so.Model(lattice), "lanes", stiffness, [case])
        assert found.codes[0, 0] == known.codes[0, 0]
        np.testing.assert_allclose(found.displacements, known.displacements, atol=1e-8)
        assert STATUSES[found.codes[0, 0]] == ("underdetermined" if status == "converged" else status)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("press", [0.08, 0.11, 0.2])
def test_a_straight_column_ends_in_a_minimum_of_the_same_energy(engine, press):
    case = load(COLUMN, "bottom", "top", (0.0, -press))
    stiffness = np.full(COLUMN.spring_count, 10.0)
    known = equilibria(so.Model(COLUMN), "lanes", stiffness, [case])
    found = equilibria(so.Model(COLUMN), engine, stiffness, [case])
    assert STATUSES[found.codes[0, 0]] == "converged"
    assert found.energies[0, 0] == pytest.approx(known.energies[0, 0], rel=1e-9)
    positions = COLUMN.nodes + found.displacements[0, 0].reshape(-1, 2)
    assert smallest_eigenvalue(COLUMN, stiffness, positions, case) > 0
    assert (np.abs(found.displacements[0, 0].reshape(-1, 2)[-1, 0]) > 1) == (press > 0.1)  # the critical load is 0.097


@pytest.mark.parametrize("engine", ENGINES)
def test_random_topologies_under_strong_loads_end_in_minima(engine):
    rng = np.random.default_rng(2)
    count = 4 if engine == "iterative" else 16
    stiffness = rng.uniform(0.5, 10, (count, GRID.spring_count)) * (rng.random((count, GRID.spring_count)) < 0.85)
    cases = [load(GRID, force=(-0.8, 0.1)), load(GRID, force=(0.3, 0.5))]
    known = equilibria(so.Model(GRID), "lanes", stiffness, cases)
    found = equilibria(so.Model(GRID), engine, stiffness, cases)
    np.testing.assert_array_equal(found.codes, known.codes)
    for k, row, codes in zip(stiffness, found.displacements, found.codes, strict=True):
        for case, u, code in zip(cases, row, codes, strict=True):
            assert STATUSES[code].has_equilibrium
            positions = GRID.nodes + u.reshape(-1, 2)
            assert np.abs(out_of_balance(GRID, k, positions, case.forces)[case.free]).max() < 1e-7
            assert smallest_eigenvalue(GRID, k, positions, case) > -1e-8
    same = np.abs(found.displacements - known.displacements).max(axis=2) < 1e-8
    assert same[:, 1].mean() > 0.9  # in strong compression there are several minima, all of them right


def test_a_sparse_answer_has_the_same_bits_in_any_company():
    rng = np.random.default_rng(1)
    candidates = rng.uniform(0, 10, (4, GRID.spring_count)) * (rng.random((4, GRID.spring_count)) < 0.9)
    cases = [load(GRID, force=force) for force in rng.normal(0, 0.3, (11, 2))]
    together = equilibria(so.Model(GRID), "sparse", candidates, cases)
    alone = equilibria(so.Model(GRID), "sparse", candidates[2:3], cases[9:10])
    np.testing.assert_array_equal(alone.displacements[0, 0], together.displacements[2, 9])
    np.testing.assert_array_equal(alone.energies[0, 0], together.energies[2, 9])


@pytest.mark.parametrize(("length", "force"), [(2.0**-30, 2.0**20), (2.0**10, 2.0**-120)])
def test_sparse_answers_scale_with_the_units_to_the_bit(length, force):
    stiffness = np.random.default_rng(4).uniform(1, 9, GRID.spring_count)
    case = load(GRID, force=(0.3, -0.2))
    there = so.SpringLattice(GRID.nodes * length, GRID.springs, GRID.rest_lengths * length)
    scaled = so.LoadCase("there", case.supports, case.forces * force)
    known = equilibria(so.Model(GRID), "sparse", stiffness, [case])
    found = equilibria(so.Model(there), "sparse", stiffness * (force / length), [scaled])
    np.testing.assert_array_equal(found.displacements, known.displacements * length)
    np.testing.assert_array_equal(found.residuals, known.residuals * force)


@pytest.mark.parametrize("engine", ["lanes", "sparse", "iterative"])
@pytest.mark.parametrize("name", ["2D", "rollers in 3D", "moved supports", "prestress", "a stranger's effect"])
def test_gradients_and_jacobians_are_derivatives(name, engine):
    model, stiffness, cases = SCENES[name]
    model = so.Model(model.lattice, model.effects, engine=engine)
    rng = np.random.default_rng(3)
    reference = model.lattice.nodes + rng.normal(0, 0.1, (len(cases), *model.lattice.nodes.shape))
    objective = so.Objective(model, cases, reference, minimize="least-squares", tolerance=1e-11)
    along = rng.normal(size=len(stiffness))
    value, gradient = objective.gradient(stiffness)
    residuals, jacobian = objective.jacobian(stiffness)
    step = 1e-5
    after, before = (objective.residuals(stiffness + sign * step * along) for sign in (1, -1))
    np.testing.assert_allclose(jacobian @ along, (after - before) / (2 * step), atol=2e-7 * np.abs(jacobian).max())
    np.testing.assert_allclose(gradient, residuals @ jacobian, atol=1e-8 * np.abs(gradient).max())
    assert value == pytest.approx(0.5 * residuals @ residuals)


def test_zero_modes_are_counted_alike_by_factors_and_eigenvalues():
    rng = np.random.default_rng(5)
    case = load(GRID, force=(0.1, 0.1))
    (small,) = so.Model(GRID, engine="lanes").groups([case])
    (large,) = so.Model(GRID, engine="sparse").groups([case])
    counts = []
    for density in np.linspace(0.2, 1.0, 9):
        exists = rng.random(GRID.spring_count) < density
        counts.append(zero_mode_counts(small, exists[None])[0])
        assert zero_mode_counts(large, exists[None])[0] == counts[-1]
    assert counts[0] > 5
    assert counts[-1] == 0


@pytest.mark.parametrize("engine", ENGINES)
def test_a_candidate_without_an_equilibrium_costs_the_graded_cap_in_every_engine(engine):
    if engine == "superlu":
        engine = "sparse"
    lattice = so.SpringLattice([[0, 0], [1, 0], [0, 1], [1, 1]], [[0, 2], [1, 3], [2, 3], [0, 3]])
    case = so.LoadCase("pull", [True, True, False, False], [[0, 0], [0, 0], [0.1, 0.1], [0.1, 0]])
    costs = [
        so.Objective(so.Model(lattice, engine=name), [case], lattice.nodes[None], cost_cap=10.0)
        .evaluate(np.array([[0.0, 0.0, 0.0, 0.0], [0.0, 4.0, 0.0, 4.0]]))
        .values
        for name in ("lanes", engine)
    ]
    np.testing.assert_array_equal(costs[0], costs[1])
    assert costs[0][0] == 20.0  # all four unknowns are loose
    assert costs[0][1] == 15.0


@pytest.mark.parametrize(
    ("shape", "engine", "solver"),
    [((5, 5), "lanes", "lanes"), ((10, 10, 10), "sparse", "band"), ((28, 28, 28), "sparse", "superlu")],
)
def test_the_size_chooses_the_engine_and_says_so(shape, engine, solver):
    lattice = so.SpringLattice.grid(shape, neighbourhood="moore")
    (group,) = so.Model(lattice).groups([load(lattice)])
    choice = group.choice
    assert (choice.engine, choice.solver) == (engine, solver)
    assert f"{choice.unknowns:,} unknowns" in choice.why
    assert choice.unknowns == np.count_nonzero(~so.side(lattice, "left")) * lattice.dimension


def test_beyond_direct_factors_it_iterates():
    (group,) = so.Model(GRID).groups([load(GRID)])
    far = group.plan._replace(first=np.zeros(60_000, dtype=np.int64))
    assert choose(far).engine == "iterative"
    assert "100,000" in choose(far).why


def test_an_engine_is_had_by_name_and_another_name_is_refused():
    (group,) = so.Model(GRID, engine="iterative").groups([load(GRID)])
    assert group.choice.solver == "multigrid"
    assert "was asked for" in group.choice.why
    with pytest.raises(so.UserError, match="engine must be one of lanes, sparse, iterative, not 'spars'"):
        so.Model(GRID, engine="spars")
    with pytest.raises(so.UserError, match="kinematics must be one of exact, linear"):
        so.Model(GRID, kinematics="quadratic")


def test_many_candidates_are_those_of_one_by_one():
    stiffness = np.random.default_rng(8).uniform(1, 9, (3, GRID.spring_count))
    cases = [load(GRID, force=(0.2, 0.1)), load(GRID, "top", "bottom", (0.2, 0.1))]
    groups = so.Model(GRID, engine="sparse").groups(cases)
    together = find(groups, stiffness, tolerance=1e-8)
    for m, k in enumerate(stiffness):
        alone = find(groups, k[None], tolerance=1e-8)
        np.testing.assert_array_equal(alone.displacements[0], together.displacements[m])
        rest = out_of_balance(GRID, k, GRID.nodes + alone.displacements[0, 1].reshape(-1, 2), cases[1].forces)
        assert np.abs(rest[cases[1].free]).max() < 1e-8
        assert np.linalg.eigvalsh(tangent(GRID, k, GRID.nodes))[0] > -1e-8
