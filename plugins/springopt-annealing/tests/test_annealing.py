"""Simulated annealing: the contract, its acceptance, cooling and steps, and what it finds."""

import contextlib
import math

import numpy as np
import pytest
from springopt_annealing import CHANGES, CYCLE, PROPOSALS, Annealing, Walk, chance, cooled, highest

import springopt as so
from springopt.testing import CHECKS, Bowl, Box, Unraced
from springopt.testing.optimizer_checks import check_stays_in_the_box
from springopt.testing.small_grid import binary_grid, real_grid


def minimized(optimizer: Annealing, kind: str = "real", **limits: float) -> so.Problem:
    """A problem after the optimizer was at work on it: 12 numbers in [0, 10], or 12 bits."""
    if kind == "binary":
        box, center = Box(np.zeros(12), np.ones(12), kind="binary"), np.arange(12.0) % 2
    else:
        box, center = Box(np.zeros(12), np.full(12, 10.0)), np.linspace(0.0, 10.0, 12)
    problem = so.Problem(Bowl(center), box, so.Budget(**limits))
    with contextlib.suppress(so.BudgetSpent):
        optimizer.minimize(problem, np.random.default_rng(0))
    return problem


def noted(problem: so.Problem, name: str) -> np.ndarray:
    return np.array([number for _, number in problem.notes[name]])


@pytest.mark.parametrize("check", CHECKS)
def test_it_keeps_the_contract(check):
    check(Annealing)


@pytest.mark.parametrize("options", [{"draws": 1}, {"first": 0.0}, {"last": 1.0}, {"step": 1.0}], ids=str)
def test_with_any_options_it_keeps_to_the_box(options):
    check_stays_in_the_box(Annealing(**options))


def test_it_finds_the_bits():
    assert minimized(Annealing(), "binary", evaluations=500).best_value == 0


def test_it_finds_numbers_also_at_the_ends_of_the_interval():
    found = minimized(Annealing(), evaluations=5000).best_point
    np.testing.assert_allclose(found, np.linspace(0.0, 10.0, 12), atol=0.1)


@pytest.mark.parametrize(
    ("change", "temperature", "expected"),
    [
        (-1.0, 2.0, 1.0),
        (0.0, 2.0, 1.0),
        (0.0, 0.0, 1.0),
        (2.0, 2.0, math.exp(-1.0)),
        (1e-9, 0.0, 0.0),
        (1e9, 1e-9, 0.0),
    ],
)
def test_a_worse_point_is_accepted_as_the_temperature_allows(change, temperature, expected):
    assert chance(change, temperature) == expected


@pytest.mark.parametrize("temperature", [0.0, 1e-9, 0.3, 1e6])
def test_whatever_is_accepted_is_no_higher_than_what_is_raced_against(temperature):
    rng = np.random.default_rng(0)
    for drawn in (0.0, *rng.random(1000)):
        edge = highest(2.0, temperature, drawn)
        for value in (2.0, edge, np.nextafter(edge, np.inf), 2.0 + rng.exponential(max(temperature, 1.0))):
            assert value <= edge or not drawn < chance(value - 2.0, temperature)


@pytest.mark.parametrize("grid", [real_grid, binary_grid])
def test_raced_or_not_a_run_is_the_same_to_the_bit(grid):
    ends = []
    for cls in (so.Problem, Unraced):
        problem = cls(*grid(), so.Budget(evaluations=800))
        with contextlib.suppress(so.BudgetSpent):
            Annealing().minimize(problem, np.random.default_rng(1))
        history = [(each.evaluations, each.value) for each in problem.meter.history]
        ends.append((history, problem.best_point.tolist(), repr(problem.notes)))
    assert ends[0] == ends[1]


def test_within_a_budget_the_cooling_ends_with_it():
    assert [cooled(asked, 100.0 - asked, size=3) for asked in (0, 25, 100)] == [0.0, 0.25, 1.0]


def test_without_an_end_each_cooling_takes_twice_as_long():
    first = 3 * CYCLE
    shares = [cooled(asked, math.inf, size=3) for asked in (0, first // 2, first - 1, first, 2 * first, 3 * first)]
    np.testing.assert_allclose(shares, [0.0, 0.5, 1.0, 0.0, 0.5, 0.0], atol=2 / first)


def test_the_temperature_falls_from_the_spread_of_the_first_changes_to_the_last_share_of_it():
    problem = minimized(Annealing(last=1e-3), evaluations=2000)
    spent = np.array([evaluations for evaluations, _ in problem.notes["temperature"]])
    settled = spent > 10 + 2 * CHANGES
    shares = (spent[settled] - PROPOSALS) / 2000  # a note comes after its proposals
    first = noted(problem, "temperature")[settled] / 1e-3**shares
    np.testing.assert_allclose(first, first[0])
    assert 1.0 < first[0] < 30.0  # a step of a quarter of the box changes half a square by some 10


def test_scaled_values_are_searched_alike():
    class Steep(Bowl):
        def evaluate(self, stiffness):
            evaluation = super().evaluate(stiffness)
            evaluation.values *= 2.0**20
            return evaluation

    points = []
    for bowl in (Bowl(np.full(3, 2.0)), Steep(np.full(3, 2.0))):
        problem = so.Problem(bowl, Box(np.zeros(3), np.full(3, 10.0)), so.Budget(evaluations=500))
        with contextlib.suppress(so.BudgetSpent):
            Annealing().minimize(problem, np.random.default_rng(0))
        points.append(problem.best_point)
    np.testing.assert_array_equal(points[0], points[1])


def test_steps_adapt_until_the_wished_share_is_accepted():
    rates = noted(minimized(Annealing(step=1.0), evaluations=8000), "acceptance_rate")
    assert 0.35 < rates[len(rates) // 4 : -len(rates) // 4].mean() < 0.53


def test_a_step_is_turned_back_at_the_ends_of_its_interval():
    problem = so.Problem(Bowl(np.zeros(1)), Box(np.full(1, 2.0), np.full(1, 3.0)), so.Budget(evaluations=1))
    walk, rng, twin = Walk(np.full(1, 2.5), 0.0, np.ones(1)), np.random.default_rng(0), np.random.default_rng(0)
    for _ in range(1000):
        moved, free = walk._moved(0, problem, rng), 2.5 + twin.standard_normal()
        while not 2.0 <= free <= 3.0:
            free = 4.0 - free if free < 2.0 else 6.0 - free
        assert moved == pytest.approx(free)


def test_a_target_alone_ends_it_too():
    problem = minimized(Annealing(), target=0.01)
    assert problem.meter.target_reached


@pytest.mark.parametrize(("option", "value"), [("draws", 0), ("first", -1.0), ("last", 0.0), ("step", 2.0)])
def test_options_out_of_range_are_refused(option, value):
    with pytest.raises(so.UserError, match=f"option {option} of annealing lies in"):
        Annealing(**{option: value})


@pytest.mark.slow
def test_it_recovers_the_topology_of_the_paper_s_section_3_1():
    assert so.solve("paper-topology-2d-isotropic", Annealing(), evaluations=3000).objective < 1e-9
