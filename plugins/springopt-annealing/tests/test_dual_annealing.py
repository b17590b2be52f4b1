"""SciPy's dual annealing as an optimizer: the contract, its descents, and the units of its values."""

import contextlib

import numpy as np
import pytest
from springopt_dual_annealing import LOST, DualAnnealing, Measured

import springopt as so
from springopt.testing import CHECKS, Bowl, Box, Cliff, Tape
from springopt.testing.optimizer_checks import check_stays_in_the_box, check_survives_failed_candidates

CENTER = np.linspace(-2.0, 12.0, 4)
BOX = Box(np.zeros(4), np.full(4, 10.0))


def minimized(optimizer: DualAnnealing, evaluations: int = 300) -> tuple[so.Problem, set[str]]:
    """A problem after the optimizer was at work on it, and what it was asked for."""
    tape = Tape()
    problem = so.Problem(Bowl(CENTER), BOX, so.Budget(evaluations=evaluations), tape)
    with contextlib.suppress(so.BudgetSpent):
        optimizer.minimize(problem, np.random.default_rng(0))
    return problem, {answer.kind for answer in tape.answers}


@pytest.mark.parametrize("check", CHECKS)
def test_it_keeps_the_contract(check):
    check(DualAnnealing)


@pytest.mark.parametrize("check", [check_stays_in_the_box, check_survives_failed_candidates])
def test_it_keeps_the_contract_without_descents(check):
    check(DualAnnealing(local_search=False))


def test_it_descends_by_the_gradient_to_the_bottom():
    problem, asked = minimized(DualAnnealing())
    assert asked == {"value", "gradient"}
    np.testing.assert_allclose(problem.best_point, np.clip(CENTER, 0.0, 10.0), atol=1e-6)


def test_without_descents_it_asks_for_values_alone():
    assert minimized(DualAnnealing(local_search=False))[1] == {"value"}


def test_it_goes_on_until_the_budget_is_spent():
    assert minimized(DualAnnealing(), 5000)[0].meter.evaluations >= 4999  # one may be left, too few for a gradient


def test_values_are_measured_in_its_unit_and_a_lost_equilibrium_is_a_wall():
    measured = Measured(so.Problem(Cliff(Bowl(CENTER), 5.0), BOX, so.Budget(evaluations=10)), unit=3.0)
    value, slope = measured.slope(np.ones(4))
    assert measured.value(np.ones(4)) == value == 1.5 * np.square(1.0 - CENTER).sum()
    np.testing.assert_array_equal(slope, 3.0 * (1.0 - CENTER))
    lost, flat = measured.slope(np.full(4, 6.0))
    assert lost == LOST
    assert not flat.any()


@pytest.mark.parametrize(
    ("option", "value"),
    [("draws", 0), ("initial_temp", 0.0), ("restart_temp_ratio", 1.0), ("visit", 1.0), ("accept", 0.0)],
)
def test_options_out_of_range_are_refused(option, value):
    with pytest.raises(so.UserError, match=f"option {option} of dual-annealing is out of range at {value:g}"):
        DualAnnealing(**{option: value})
