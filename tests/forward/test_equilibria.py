"""The forward solve against closed forms and against an oracle that computes everything again."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import energy, out_of_balance, smallest_eigenvalue, tangent

import springopt as so
from springopt.forward.lane_factors import tangents

GRID = so.SpringLattice.grid((4, 3))


def pull(lattice, force, *, hold="left", on="right", name="pull"):
    forces = np.zeros(lattice.nodes.shape)
    forces[so.side(lattice, on)] = force
    return so.LoadCase(name, so.side(lattice, hold), forces)


def chain(*positions, axis=0):
    nodes = np.zeros((len(positions), 2))
    nodes[:, axis] = positions
    return so.SpringLattice(nodes, [[i, i + 1] for i in range(len(positions) - 1)])


def test_one_spring_hangs_longer_by_force_over_stiffness():
    lattice = chain(0.0, 1.0)
    case = so.LoadCase("pull", [True, False], [[0, 0], [0.5, 0]])
    solution = so.Model(lattice).solve([2.0], [case])
    assert solution.status[0] == "converged"
    np.testing.assert_allclose(solution.positions[0], [[0, 0], [1.25, 0]], atol=1e-12)
    assert solution.energy[0] == pytest.approx(0.5 * 2 * 0.25**2 - 0.5 * 1.25)


def test_zero_load_moves_nothing_and_leaves_no_residual():
    case = pull(GRID, (0, 0))
    solution = so.Model(GRID).solve(np.full(GRID.spring_count, 3.0), [case])
    assert solution.status[0] == "converged"
    np.testing.assert_array_equal(solution.positions[0], GRID.nodes)
    assert solution.residual[0] == 0


def test_a_pendulum_on_its_head_swings_down():
    lattice = chain(0.0, 1.0, axis=1)
    model = so.Model(lattice, [so.Gravity((0, -9.81), mass=0.1)])
    solution = model.solve([2.5], [so.LoadCase("weight", [True, False], np.zeros((2, 2)))])
    assert solution.status[0] == "converged"
    np.testing.assert_allclose(solution.positions[0], [[0, 0], [0, -1.3924]], atol=1e-8)


def test_gravity_is_a_force_of_mass_times_acceleration_on_every_node():
    mass = np.linspace(1, 2, GRID.node_count)
    weight = mass[:, None] * [0.0, -0.05]
    by_effect = so.Model(GRID, [so.Gravity((0, -0.05), mass=mass)]).solve(
        np.full(GRID.spring_count, 4.0), [so.LoadCase("rest", so.side(GRID, "left"), np.zeros_like(GRID.nodes))]
    )
    by_force = so.Model(GRID).solve(
        np.full(GRID.spring_count, 4.0), [so.LoadCase("weight", so.side(GRID, "left"), weight)]
    )
    np.testing.assert_array_equal(by_effect.positions, by_force.positions)
    np.testing.assert_allclose(by_effect.energy, by_force.energy, rtol=1e-14)


def test_a_prescribed_displacement_is_where_it_was_prescribed():
    supports = so.side(GRID, "left") | so.side(GRID, "right")
    prescribed = np.where(so.side(GRID, "right")[:, None], [0.3, 0.1], 0.0)
    case = so.LoadCase("stretch", supports, np.zeros_like(GRID.nodes), prescribed)
    solution = so.Model(GRID).solve(np.full(GRID.spring_count, 4.0), [case])
    assert solution.status[0] == "converged"
    right = so.side(GRID, "right")
    np.testing.assert_array_equal(solution.positions[0][right], GRID.nodes[right] + [0.3, 0.1])


def test_a_roller_holds_one_axis_only():
    supports = np.zeros((GRID.node_count, 2), dtype=bool)
    supports[so.side(GRID, "left"), 0] = True
    supports[0] = True
    forces = np.where(so.side(GRID, "right")[:, None], [0.4, 0.0], 0.0)
    solution = so.Model(GRID).solve(np.full(GRID.spring_count, 4.0), [so.LoadCase("roll", supports, forces)])
    assert solution.status[0] == "converged"
    u = solution.displacements[0]
    left = so.side(GRID, "left")
    np.testing.assert_array_equal(u[left, 0], 0)
    assert np.abs(u[left, 1]).max() > 1e-3
    rest = out_of_balance(GRID, np.full(GRID.spring_count, 4.0), solution.positions[0], forces)
    assert np.abs(rest[~supports]).max() < 1e-8


def test_everything_held_is_an_equilibrium():
    forces = np.full(GRID.nodes.shape, 0.3)
    case = so.LoadCase("held", np.ones(GRID.node_count, dtype=bool), forces)
    solution = so.Model(GRID).solve(np.full(GRID.spring_count, 4.0), [case])
    assert solution.status[0] == "converged"
    np.testing.assert_array_equal(solution.positions[0], GRID.nodes)


@pytest.mark.parametrize(
    ("force", "status"), [((0.0, 0.8), "converged"), ((0.0, 0.0), "underdetermined"), ((0.3, 0.0), "converged")]
)
def test_a_square_without_diagonals_stands_by_its_tension_only(force, status):
    lattice = so.SpringLattice([[0, 0], [1, 0], [0, 1], [1, 1]], [[0, 2], [1, 3], [2, 3]])
    case = so.LoadCase("load", [True, True, False, False], [[0, 0], [0, 0], force, force])
    solution = so.Model(lattice).solve([4.0, 4.0, 4.0], [case])
    assert solution.status[0] == status
    if force == (0.0, 0.8):
        np.testing.assert_allclose(solution.positions[0][2:], [[0, 1.2], [1, 1.2]], atol=1e-12)
    if force == (0.3, 0.0):  # it swings over until the springs hang along the load
        np.testing.assert_allclose(solution.positions[0][2:].mean(axis=0)[1], 0, atol=1e-8)


def test_the_zero_modes_of_an_underdetermined_case_are_listed():
    lattice = so.SpringLattice([[0, 0], [1, 0], [0, 1], [5, 5]], [[0, 1], [0, 2], [1, 2]])
    case = so.LoadCase("load", [True, True, False, False], [[0, 0], [0, 0], [0.1, 0.1], [0, 0]])
    solution = so.Model(lattice).solve(np.ones(3), [case])
    assert solution.status[0] == "underdetermined"
    (modes,) = solution.zero_modes
    assert modes.shape == (2, 4, 2)
    assert np.abs(modes[:, :3]).max() == 0
    np.testing.assert_array_equal(solution.displacements[0, 3], 0)


def test_a_load_on_a_part_that_nothing_holds_is_a_mechanism():
    lattice = so.SpringLattice([[0, 0], [1, 0], [0, 1], [5, 5]], [[0, 1], [0, 2], [1, 2]])
    case = so.LoadCase("load", [True, True, False, False], [[0, 0], [0, 0], [0, 0], [0.1, 0]])
    solution = so.Model(lattice).solve(np.ones(3), [case])
    assert solution.status[0] == "mechanism"
    assert np.isfinite(solution.positions).all()


def test_a_free_body_under_balanced_loads_is_underdetermined_and_keeps_its_shape():
    forces = np.zeros(GRID.nodes.shape)
    forces[so.side(GRID, "left")], forces[so.side(GRID, "right")] = (-0.3, 0), (0.3, 0)
    free = so.Model(GRID).solve(
        np.full(GRID.spring_count, 4.0), [so.LoadCase("free", np.zeros(GRID.node_count, dtype=bool), forces)]
    )
    assert free.status[0] == "underdetermined"
    assert np.abs(out_of_balance(GRID, np.full(GRID.spring_count, 4.0), free.positions[0], forces)).max() < 1e-8


def test_a_perfectly_straight_column_above_its_critical_load_buckles_to_a_minimum():
    column = so.SpringLattice.grid((2, 9))
    forces = np.where(so.side(column, "top")[:, None], [0.0, -0.11], 0.0)
    case = so.LoadCase("press", so.side(column, "bottom"), forces)
    stiffness = np.full(column.spring_count, 10.0)
    solution = so.Model(column).solve(stiffness, [case])
    assert solution.status[0] == "converged"
    assert abs(solution.displacements[0, -1, 0]) > 1
    assert smallest_eigenvalue(column, stiffness, solution.positions[0], case) > 0


def test_a_nonlinear_effect_of_a_stranger_joins_the_same_loop():
    from ground_springs import GroundSprings

    forces = np.zeros(GRID.nodes.shape)
    forces[-1] = (2.0, 1.0)
    case = so.LoadCase("pull", np.zeros(GRID.node_count, dtype=bool), forces)
    stiffness = np.full(GRID.spring_count, 5.0)
    solution = so.Model(GRID, [GroundSprings(3.0)]).solve(stiffness, [case])
    assert solution.status[0] == "converged"
    rest = out_of_balance(GRID, stiffness, solution.positions[0], forces) - 3.0 * solution.displacements[0] ** 3
    assert np.abs(rest).max() < 1e-8


@st.composite
def problems(draw):
    """A grid with random springs missing, random loads, one or two sides held."""
    shape = draw(st.sampled_from([(3, 3), (4, 3), (2, 2, 3), (3, 2, 2)]))
    seed = draw(st.integers(0, 2**32 - 1))
    density = draw(st.sampled_from([1.0, 0.9, 0.7, 0.5]))
    size = draw(st.sampled_from([1e-3, 0.1, 0.5, 2.0]))
    rng = np.random.default_rng(seed)
    lattice = so.SpringLattice.grid(shape)
    stiffness = rng.uniform(0.5, 10, lattice.spring_count) * (rng.random(lattice.spring_count) < density)
    case = so.LoadCase("random", so.side(lattice, "left"), rng.normal(0, size, lattice.nodes.shape))
    return lattice, stiffness, case


@settings(max_examples=150, deadline=None)
@given(problems())
def test_an_answer_called_converged_is_balanced_and_a_minimum(problem):
    lattice, stiffness, case = problem
    solution = so.Model(lattice).solve(stiffness, [case])
    status, positions = solution.status[0], solution.positions[0]
    assert np.isfinite(positions).all()
    assert status in ("converged", "underdetermined", "mechanism")
    if status == "mechanism":
        return
    rest = out_of_balance(lattice, stiffness, positions, case.forces)
    reaction = np.abs(rest[case.supports]).max()
    assert np.abs(rest[case.free]).max() <= 1e-7 * max(np.abs(case.forces).max(), reaction)
    lowest = smallest_eigenvalue(lattice, stiffness, positions, case)
    scale = stiffness.max()
    assert lowest > (0 if status == "converged" else -1e-8 * scale)
    assert solution.energy[0] == pytest.approx(energy(lattice, stiffness, positions, case.forces), rel=1e-10)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 9), st.sampled_from([0.3, 0.5, 0.8, 1.0]))
def test_an_answer_has_the_same_bits_in_any_company(seed, count, density):
    rng = np.random.default_rng(seed)
    candidates = rng.uniform(0, 10, (10, GRID.spring_count)) * (rng.random((10, GRID.spring_count)) < density)
    cases = [pull(GRID, (0.3, 0.1)), pull(GRID, (-0.5, 0.0), hold="top", on="bottom"), pull(GRID, (-1.5, 0.2))]
    model = so.Model(GRID)
    together = model.solve_many(candidates, cases)
    alone = model.solve_many(candidates[count : count + 1], cases[:2])
    reversed_few = model.solve_many(candidates[count::-1], cases[1::-1])
    for other, number in ((alone, slice(None)), (reversed_few, slice(None, None, -1))):
        np.testing.assert_array_equal(other.positions[0, number], together.positions[count, :2])
        np.testing.assert_array_equal(other.status[0, number], together.status[count, :2])
        np.testing.assert_array_equal(other.energy[0, number], together.energy[count, :2])


@pytest.mark.parametrize(("length", "force"), [(2.0**-30, 2.0**20), (2.0**10, 2.0**-40), (2.0**3, 1.0), (1.0, 2.0**-7)])
def test_answers_scale_with_the_units_to_the_bit(length, force):
    stiffness = np.random.default_rng(4).uniform(1, 9, GRID.spring_count)
    case = pull(GRID, (0.3, -0.2))
    scaled_grid = so.SpringLattice(
        GRID.nodes * length, GRID.springs, GRID.rest_lengths * length, GRID.cells, GRID.cell_type
    )
    scaled_case = so.LoadCase("pull", case.supports, case.forces * force)
    here = so.Model(GRID).solve(stiffness, [case])
    there = so.Model(scaled_grid).solve(stiffness * (force / length), [scaled_case])
    np.testing.assert_array_equal(there.displacements, here.displacements * length)
    np.testing.assert_array_equal(there.residual, here.residual * force)


@pytest.mark.parametrize("shape", [(4, 3), (3, 2, 2)])
def test_the_tangent_of_the_kernels_is_the_derivative_of_the_forces(shape):
    lattice = so.SpringLattice.grid(shape)
    rng = np.random.default_rng(5)
    stiffness, u = rng.uniform(1, 9, lattice.spring_count), rng.normal(0, 0.1, lattice.nodes.shape)
    case = so.LoadCase("none", so.side(lattice, "left"), np.zeros(lattice.nodes.shape))
    u[case.supports] = 0
    (group,) = so.Model(lattice).groups([case])
    ours = tangents(group.plan, stiffness, u.reshape(1, -1))[0]
    theirs = tangent(lattice, stiffness, lattice.nodes + u)
    free = case.free.ravel()
    np.testing.assert_allclose(ours[np.ix_(free, free)], theirs[np.ix_(free, free)], atol=1e-12)


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [
        (np.full(GRID.spring_count, np.nan), r"stiffness\[0, 0\] is nan"),
        (np.full(GRID.spring_count, -1.0), r"stiffness\[0, 0\] is -1"),
        (np.ones(3), r"stiffness must have the shape"),
    ],
)
def test_bad_stiffness_is_refused_before_any_solve(stiffness, message):
    with pytest.raises(so.UserError, match=message):
        so.Model(GRID).solve(stiffness, [pull(GRID, (0.1, 0))])


def test_no_load_case_and_a_load_case_of_another_lattice_are_refused():
    with pytest.raises(so.UserError, match="At least one load case"):
        so.Model(GRID).solve(np.ones(GRID.spring_count), [])
    other = so.SpringLattice.grid((3, 3))
    with pytest.raises(so.UserError, match="has forces of shape"):
        so.Model(GRID).solve(np.ones(GRID.spring_count), [pull(other, (0.1, 0))])


def test_a_load_case_outside_a_list_is_refused():
    with pytest.raises(so.UserError, match="must come in a list"):
        so.Model(GRID).solve(np.ones(GRID.spring_count), pull(GRID, (0.1, 0)))


def test_an_acceleration_that_does_not_fit_the_lattice_is_refused():
    with pytest.raises(so.UserError, match="acceleration must have the shape"):
        so.Model(GRID, [so.Gravity((0, 0, -9.81))])
