"""The branch that load steps follow from rest: another code's continuation, closed forms, symmetric buckling."""

from pathlib import Path

import numpy as np
import pytest
from ladder.snap_through import STIFFNESS, critical_height, heights, lattice_of, load
from oracle import smallest_eigenvalue

import springopt as so

DATA = Path(__file__).parents[1] / "data" / "msm"
#: These come to a limit point, at 0.9986 and 0.9983 of their load, and snap by several spacings: which of many minima
#: they snap to depends on the size of the steps, the other code's too.
BEHIND_A_LIMIT_POINT = {("grid5x5_random", "compress_3"), ("grid4x4x4_removed5", "compress_3")}


def solve(model, stiffness, case):
    solution = model.solve(stiffness, [case])
    assert solution.status[0] == "converged"
    return solution


@pytest.mark.parametrize("name", ["grid5x5_random", "grid4x4x4_removed5"])
def test_load_steps_arrive_where_another_codes_load_steps_arrive(name):
    data = np.load(DATA / f"{name}.npz")
    lattice = so.SpringLattice(data["points"], data["springs"], data["L0"])
    for number, load_name in enumerate(data["case_names"]):
        case = so.LoadCase(str(load_name), data["fixed"], data["loads"][number])
        effects = [so.Gravity(data["gravity"][number], data["mass"])]
        solution = solve(so.Model(lattice, effects, branch="followed"), data["k"], case)
        assert smallest_eigenvalue(lattice, data["k"], solution.positions[0], case) > 0
        if (name, str(load_name)) not in BEHIND_A_LIMIT_POINT:
            np.testing.assert_allclose(solution.positions[0], data["x_continuation"][number], atol=1e-8)


@pytest.mark.parametrize("share", [0.5, 0.99, 0.999, 1.001, 1.5])
def test_the_von_mises_truss_stays_above_until_it_snaps_through(share):
    height = 0.3
    lattice = lattice_of(height, 2)
    force = share * load(critical_height(height), np.sqrt(1 + height**2), 2)
    case = so.LoadCase("press", [True, True, False], [[0, 0], [0, 0], [0, -force]])
    solution = solve(so.Model(lattice, branch="followed"), np.full(2, STIFFNESS), case)
    np.testing.assert_allclose(solution.positions[0, 2], [0, heights(height, force, 2)[0]], atol=1e-7)


@pytest.mark.parametrize("is_above", [False, True])
def test_a_perfect_column_stays_straight_below_its_critical_load_and_bends_above(is_above):
    column = so.SpringLattice.grid((2, 9))
    stiffness = np.full(column.spring_count, 10.0)
    force = 0.11 if is_above else 0.09  # critical at 0.0967
    forces = np.where(so.side(column, "top")[:, None], [0.0, -force], 0.0)
    case = so.LoadCase("press", so.side(column, "bottom"), forces)
    solution = solve(so.Model(column, branch="followed"), stiffness, case)
    sideways = np.abs(solution.displacements[0, -2:].sum(axis=0)[0])
    assert sideways > 1 if is_above else sideways < 1e-7
    assert smallest_eigenvalue(column, stiffness, solution.positions[0], case) > 0


def test_prescribed_displacements_grow_with_the_loads():
    lattice = so.SpringLattice([[0, 0], [1, 0.2], [2, 0]], [[0, 1], [1, 2]])
    prescribed = np.array([[0.0, 0.0], [np.nan, np.nan], [-0.1, 0.0]])
    case = so.LoadCase("squeeze", [False] * 3, np.zeros((3, 2)), prescribed)
    solution = so.Model(lattice, branch="followed").solve([3.0, 3.0], [case])
    height = np.sqrt(1.04 - 0.95**2)
    np.testing.assert_allclose(solution.positions[0], [[0, 0], [0.95, height], [1.9, 0]], atol=1e-7)


def test_a_mechanism_and_a_loose_part_are_told_as_on_the_other_branch():
    lattice = so.SpringLattice([[0, 0], [1, 0], [0, 1], [1, 1]], [[0, 2], [1, 3], [2, 3]])
    cases = [
        so.LoadCase("sideways", [True, True, False, False], [[0, 0], [0, 0], [0.3, 0], [0.3, 0]]),
        so.LoadCase("none", [True, True, False, False], np.zeros((4, 2))),
    ]
    statuses = so.Model(lattice, branch="followed").solve([4.0, 4.0, 4.0], cases).status
    assert list(statuses) == ["converged", "underdetermined"]
    loose = so.Model(lattice, branch="followed").solve([4.0, 0.0, 0.0], cases)
    assert list(loose.status) == ["mechanism", "underdetermined"]


def test_a_followed_answer_has_the_same_bits_in_any_company():
    lattice = so.SpringLattice.grid((4, 3))
    rng = np.random.default_rng(2)
    candidates = rng.uniform(0.5, 10, (7, lattice.spring_count)) * (rng.random((7, lattice.spring_count)) < 0.8)
    forces = [np.where(so.side(lattice, "right")[:, None], force, 0.0) for force in ([0.5, 0.1], [-1.5, 0.2])]
    cases = [so.LoadCase(str(number), so.side(lattice, "left"), force) for number, force in enumerate(forces)]
    model = so.Model(lattice, branch="followed")
    together = model.solve_many(candidates, cases)
    for number in range(7):
        alone = model.solve_many(candidates[number : number + 1], cases[1:])
        np.testing.assert_array_equal(alone.positions[0, 0], together.positions[number, 1])
        assert alone.status[0, 0] == together.status[number, 1]


def test_an_unknown_branch_is_refused():
    with pytest.raises(so.UserError, match=r"branch must be one of minimum, followed, not 'folowed'\. Did"):
        so.Model(so.SpringLattice.grid((2, 2)), branch="folowed")
