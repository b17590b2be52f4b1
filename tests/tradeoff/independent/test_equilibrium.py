"""Equilibria that are known, beside the engines' and beside closed forms."""

import numpy as np
import pytest

import springopt as so
from springopt.tradeoff.independent.equilibrium import known_equilibria, polish
from springopt.tradeoff.independent.system import System

EFFECTS = {
    "springs": (),
    "gravity and volume": (so.Gravity((0.0, -0.02)), so.Volume(2.0)),
    "prestress": (so.Prestress(0.9),),
    "stiffening": (so.Stiffening(cubic=2.0),),
    "plane": (so.PlaneContact(20.0, (0.0, 0.05), (0.0, 1.0)),),
    "bending": (so.Bending(0.3),),
}


def pulled(shape=(4, 4)):
    grid = so.SpringLattice.grid(shape)
    forces = np.zeros(grid.nodes.shape)
    forces[-1] = [0.3, -0.1, 0.2][: grid.dimension]
    return grid, so.LoadCase("pull", so.side(grid, "left"), forces)


@pytest.mark.parametrize("effects", EFFECTS.values(), ids=EFFECTS)
@pytest.mark.parametrize("engine", ["lanes", "sparse"])
def test_it_is_that_of_the_engines(effects, engine):
    grid, case = pulled()
    stiffness = np.random.default_rng(1).uniform(1.0, 5.0, (2, grid.spring_count))
    known = known_equilibria(so.Model(grid, effects), "sparse", stiffness, [case])
    found = so.Model(grid, effects, engine=engine).solve_many(stiffness, [case], 1e-13)
    assert known.is_known.all()
    assert known.doubt < 1e-14
    np.testing.assert_allclose(found.displacements, known.displacements.astype(float), atol=1e-12, rtol=0.0)


def test_it_is_that_of_the_engines_in_three_dimensions_and_with_prescribed_displacements():
    grid, case = pulled((3, 3, 3))
    prescribed = np.full(grid.nodes.shape, np.nan)
    prescribed[so.side(grid, "right"), 0] = 0.4
    case = so.LoadCase("stretch", case.supports, case.forces, prescribed)
    stiffness = np.random.default_rng(1).uniform(1.0, 5.0, (1, grid.spring_count))
    known = known_equilibria(so.Model(grid), "sparse", stiffness, [case])
    found = so.Model(grid).solve_many(stiffness, [case], 1e-13)
    np.testing.assert_allclose(found.displacements, known.displacements.astype(float), atol=1e-12, rtol=0.0)


def test_a_bar_is_longer_by_force_over_stiffness_to_the_last_bit_of_long_double():
    bar = so.SpringLattice(np.array([[0.0, 0.0], [3.0, 0.0]]), np.array([[0, 1]]))
    held = np.array([[True, True], [False, True]])
    case = so.LoadCase("pull", held, np.array([[0.0, 0.0], [0.7, 0.0]]))
    known = known_equilibria(so.Model(bar), "sparse", np.array([[2.3]]), [case])
    exact = np.longdouble(0.7) / np.longdouble(2.3)
    assert abs(known.displacements[0, 0, 1, 0] / exact - 1) < 1e-17


def test_a_wrong_answer_is_caught():
    grid, case = pulled()
    stiffness = np.random.default_rng(1).uniform(1.0, 5.0, grid.spring_count)
    right = so.Model(grid).solve(stiffness, [case], 1e-13).displacements[0]
    system = System.of(so.Model(grid), stiffness)
    assert not polish(system, case, right).why
    wrong = right.copy()
    wrong[-1, 0] += 1e-4
    assert "led away" in polish(system, case, wrong).why


def test_a_node_without_springs_stays_at_rest_and_the_others_are_known():
    grid, case = pulled()
    stiffness = np.full(grid.spring_count, 2.0)
    stiffness[(grid.springs == 5).any(axis=1)] = 0.0
    found = so.Model(grid).solve(stiffness, [case], 1e-13)
    known = known_equilibria(so.Model(grid), "sparse", stiffness[None], [case])
    assert found.status[0] is so.Status.UNDERDETERMINED
    assert known.is_known.all()
    assert not known.displacements[0, 0, 5].any()
    np.testing.assert_allclose(found.displacements[0], known.displacements[0, 0].astype(float), atol=1e-12, rtol=0.0)


def test_a_part_that_swings_freely_is_not_known_and_a_mechanism_has_none():
    # Two bars in line that are pulled at their joint; a third one hangs on the joint by a pin.
    nodes = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    chain = so.SpringLattice(nodes, np.array([[0, 1], [1, 2]]))
    held = np.array([[True, True], [False, True], [False, False]])
    at_joint, at_end = np.zeros((2, 3, 2))
    at_joint[1, 0], at_end[2, 0] = 0.2, 0.2
    cases = [so.LoadCase("joint", held, at_joint), so.LoadCase("away", np.zeros(3, dtype=bool), at_end)]
    known = known_equilibria(so.Model(chain), "sparse", np.ones((1, 2)), cases)
    assert not known.is_known.any()
    assert known.has_none.tolist() == [[False, True]]
    assert "leave it open" in known.why[0, 0]
    assert "mechanism" in known.why[0, 1]


def test_a_column_that_buckles_is_known_on_the_branch_that_it_follows():
    column = so.SpringLattice.grid((2, 9))
    forces = np.zeros(column.nodes.shape)
    forces[so.side(column, "top"), 1] = -0.05
    case = so.LoadCase("press", so.side(column, "bottom"), forces)
    model, stiffness = so.Model(column, branch="followed"), np.full((1, column.spring_count), 2.0)
    known = known_equilibria(model, "sparse", stiffness, [case])
    found = model.solve_many(stiffness, [case], 1e-13)
    assert np.abs(found.displacements[..., 0]).max() > 1.0
    np.testing.assert_allclose(found.displacements, known.displacements.astype(float), atol=1e-12, rtol=0.0)
