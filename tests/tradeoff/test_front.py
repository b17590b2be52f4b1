"""The Pareto front of points, and the price of a digit along it."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from springopt.tradeoff.front import pareto_front, price_of_a_digit
from springopt.tradeoff.point import Point


def point(error, seconds, *, name="a", errors=None, spread=0.0):
    """A setting with this error in this time; with five repeats that are spread by so much."""
    repeats = seconds * (1.0 + spread * np.linspace(-1, 1, 5))
    return Point("series", name, np.array([error] if errors is None else errors), repeats, repeats)


POINTS = st.lists(st.tuples(st.floats(1e-12, 1.0), st.floats(1e-6, 10.0)), min_size=1, max_size=20)


@given(POINTS)
def test_nothing_beats_the_front_and_the_front_beats_the_rest(numbers):
    points = [point(*pair) for pair in numbers]
    front = pareto_front(points)
    place = [(each.processor_seconds.value, each.error.value) for each in front]
    assert place == sorted(place)
    assert all(after[1] < before[1] for before, after in pairwise(place))
    for each in points:
        time, error = each.processor_seconds.value, each.error.value
        assert any(t <= time and e <= error for t, e in place)


def test_what_fails_now_and_then_is_not_on_the_front():
    fails = point(None, 1e-3, errors=[1e-9, np.inf])
    assert fails.failures == 1
    assert fails.error.value == 1e-9
    assert pareto_front([fails, point(1e-2, 1.0)])[0].processor_seconds.value == 1.0
    assert point(None, 1.0, errors=[np.inf]).error is None


@pytest.mark.parametrize("factor", [1.0, 1.3, 3.1, 10.0])
def test_the_price_is_the_factor_of_time_for_a_tenth_of_the_error(factor):
    points = [point(10.0**-digits, 1e-3 * factor**digits + 1e-12 * digits) for digits in range(2, 9)]
    price = price_of_a_digit(points)
    assert price.factor.value == pytest.approx(factor, rel=1e-6)
    assert price.digits == pytest.approx(6.0)
    assert price.said.startswith(f"one digit more costs {factor:.3g} times (")


def test_a_series_that_hardly_moves_has_no_price_to_believe():
    price = price_of_a_digit([point(1e-1, 1.0), point(0.4e-1, 100.0)])
    assert price.factor.value == pytest.approx(100.0 ** (1.0 / np.log10(2.5)))
    assert price.said == "one digit more is out of reach: it would cost more than 1,000 times"


def test_its_interval_is_wider_where_repeats_differ_and_holds_the_factor():
    exact, noisy = (
        price_of_a_digit([point(10.0**-digits, 2.0**digits, spread=spread) for digits in range(4)])
        for spread in (0.0, 0.4)
    )
    assert exact.factor.width < 1e-9
    assert noisy.factor.low < 2.0 < noisy.factor.high


@pytest.mark.parametrize("points", [[], [point(1e-3, 1.0)], [point(1e-3, 1.0), point(0.9e-3, 2.0)]])
def test_too_few_points_or_digits_have_no_price(points):
    assert price_of_a_digit(points) is None


def test_an_error_of_zero_is_on_the_front_and_has_no_price():
    points = [point(1e-2, 1.0), point(1e-4, 2.0), point(0.0, 3.0)]
    assert len(pareto_front(points)) == 3
    assert price_of_a_digit(points).digits == pytest.approx(2.0)


def test_points_close_together_do_not_decide_the_price():
    crowd = [point(1.0 - 0.01 * number, 1.0 + 0.1 * number) for number in range(4)]
    assert price_of_a_digit([*crowd, point(1e-2, 100.0)]).factor.value == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize("seed", range(10))
def test_points_whose_repeats_overlap_have_no_price_or_a_finite_one(seed):
    rng = np.random.default_rng(seed)
    points = [
        point(None, seconds, errors=10.0 ** rng.normal(middle, 0.5, 12)) for middle, seconds in [(-1, 1e-3), (-1.5, 1)]
    ]
    price = price_of_a_digit(points)
    assert price is None or 1.0 < price.factor.low <= price.factor.value <= price.factor.high < 1e12


def test_single_repeats_tell_no_interval():
    points = [
        Point("s", "a", np.array([error]), np.array([time]), np.array([time])) for error, time in [(1, 1), (0.1, 2)]
    ]
    assert price_of_a_digit(points).said == "one digit more costs 2 times (too few repeats for an interval)"
