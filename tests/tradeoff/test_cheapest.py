"""The reverse question: what is proposed, what a run of its own refutes, what is said when nothing is good enough."""

import numpy as np
import pytest
from axis_of_words import axis_of, point

from springopt.tradeoff.cheapest import find_cheapest
from springopt.tradeoff.measure import Measured
from springopt.tradeoff.point import Request

POINTS = [point("fast", 1e-2, 1.0), point("middle", 1e-4, 2.0), point("slow", 1e-6, 4.0)]


def measured(points, **options):
    axis, asked = axis_of(points, **options)
    return Measured(axis, axis.measure(None, Request(1.0)), 1.0), asked


@pytest.mark.parametrize(("target", "name"), [(0.5, "fast"), (1e-2, "fast"), (1e-3, "middle"), (1e-6, "slow")])
def test_the_cheapest_that_is_accurate_enough_is_run_again(target, name):
    found, asked = measured(POINTS)
    answer = find_cheapest(None, found, target_error=target, seconds=1.0)
    assert answer.verified.name == name
    assert asked[-1].only == {("s", name)}
    assert asked[-1].seed != asked[0].seed
    assert asked[-1].before == found.findings.numbers == {"words": 1}
    assert f"the cheapest setting that keeps an error of {target:.3g} is s, {name}" in answer.said


@pytest.mark.parametrize(("time", "name"), [(1.5, "fast"), (2.0, "middle"), (9.0, "slow")])
def test_the_most_accurate_that_is_fast_enough(time, name):
    answer = find_cheapest(None, measured(POINTS)[0], time=time, seconds=1.0)
    assert answer.verified.name == name
    assert f"the most accurate setting that keeps {time:.3g} s" in answer.said


def test_what_a_second_run_refutes_is_not_the_answer():
    worse = [point("fast", 1e-2, 1.0), point("middle", 1e-2, 2.0), point("slow", 1e-6, 4.0)]
    answer = find_cheapest(None, measured(POINTS, again=worse)[0], target_error=1e-3, seconds=1.0)
    assert [each.name for each in answer.refuted] == ["middle"]
    assert answer.verified.name == "slow"
    assert "1 cheaper did not hold when run again" in answer.said


def test_where_none_meets_it_the_closest_is_named():
    answer = find_cheapest(None, measured(POINTS)[0], target_error=1e-9, seconds=1.0)
    assert answer.verified is None
    assert answer.closest.name == "slow"
    assert "no setting keeps an error of 1e-09; closest is s, slow" in answer.said


def test_what_fails_now_and_then_meets_no_target():
    answer = find_cheapest(None, measured([point("a", [1e-9, np.inf], 1.0)])[0], target_error=1.0, seconds=1.0)
    assert answer.verified is None
    assert "no setting has an answer in every case" in answer.said


def test_the_upper_end_of_the_interval_counts():
    wide = point("wide", [1e-3, 2e-3, 5e-3], 1.0)
    assert find_cheapest(None, measured([wide])[0], target_error=3e-3, seconds=1.0).verified is None
    assert find_cheapest(None, measured([wide])[0], target_error=5e-3, seconds=1.0).verified is not None


def test_what_was_fast_enough_once_but_not_again_is_said_to_be_more_accurate():
    slower = [point("fast", 1e-2, 1.0), point("middle", 1e-4, 9.0), point("slow", 1e-6, 9.0)]
    answer = find_cheapest(None, measured(POINTS, again=slower)[0], time=2.0, seconds=1.0)
    assert answer.verified.name == "fast"
    assert answer.said.endswith("1 more accurate did not hold when run again.")


def test_where_none_holds_again_none_is_called_close():
    worse = [point(each.name, 1.0, 1.0) for each in POINTS]
    answer = find_cheapest(None, measured(POINTS, again=worse)[0], target_error=1e-3, seconds=1.0)
    assert answer.said == (
        "words: no setting is sure to keep an error of 0.001; 2 that did (s, middle and others) did not hold when run "
        "again."
    )
