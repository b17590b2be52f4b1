"""Springs that go slack."""

import numpy as np
import pytest

import springopt as so

CHAIN = so.SpringLattice([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], [[0, 1], [1, 2]])
GRID = so.SpringLattice.grid((5, 4))


@pytest.mark.parametrize("engine", ["lanes", "sparse", "iterative"])
def test_the_slack_side_of_a_chain_carries_nothing(engine):
    case = so.LoadCase("pull", [True, False, True], [[0, 0], [0.3, 0], [0, 0]])
    solution = so.Model(CHAIN, so.TensionOnly(), engine=engine).solve([3.0, 7.0], [case])
    assert solution.status[0] == "converged"
    np.testing.assert_allclose(solution.displacements[0, 1], [0.1, 0.0], atol=1e-10)


def test_nothing_changes_where_all_springs_are_in_tension():
    tense = so.Prestress(scale=0.5)
    held = so.side(GRID, "left") | so.side(GRID, "right") | so.side(GRID, "top") | so.side(GRID, "bottom")
    case = so.LoadCase("push", held, np.full(GRID.nodes.shape, 0.1))
    stiffness = np.full(GRID.spring_count, 3.0)
    alone, both = (so.Model(GRID, effects).solve(stiffness, [case]) for effects in (tense, [tense, so.TensionOnly()]))
    np.testing.assert_array_equal(both.positions, alone.positions)


def test_a_net_hangs_in_its_cables():
    forces = np.full(GRID.nodes.shape, (0.0, -0.02))
    case = so.LoadCase("weight", so.side(GRID, "top"), forces)
    model = so.Model(GRID, so.TensionOnly())
    stiffness = np.full(GRID.spring_count, 3.0)
    solution = model.solve(stiffness, [case])
    assert solution.status[0].has_equilibrium
    ends = solution.positions[0][GRID.springs]
    longer = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) - GRID.rest_lengths
    tension = stiffness * np.maximum(longer, 0)
    along = (ends[:, 1] - ends[:, 0]) / np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)[:, None]
    balance = forces.copy()
    np.add.at(balance, GRID.springs[:, 0], tension[:, None] * along)
    np.add.at(balance, GRID.springs[:, 1], -tension[:, None] * along)
    assert np.abs(balance[~so.side(GRID, "top")]).max() < 1e-8


def test_small_displacements_are_refused():
    with pytest.raises(so.UserError, match="small displacements would leave tension-only out"):
        so.Model(CHAIN, so.TensionOnly(), kinematics="linear")


@pytest.mark.parametrize("engine", ["lanes", "sparse", "iterative"])
def test_a_law_of_the_springs_holds_nothing_that_no_support_holds(engine):
    case = so.LoadCase("push", np.zeros(3, dtype=bool), [[0.1, 0], [0, 0], [0, 0]])
    solution = so.Model(CHAIN, so.TensionOnly(), engine=engine).solve([3.0, 7.0], [case])
    assert solution.status[0] == "mechanism"
    assert solution.batch.iterations[0, 0] == 0
