"""Clocks and intervals: medians with their coverage, warm-up apart, rounds that meet all alike."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from springopt.tradeoff.clock import LEAST_ROUNDS, MOST_ROUNDS, time_all
from springopt.tradeoff.interval import Interval, _left_out

NUMBERS = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=60)


@given(NUMBERS)
def test_an_interval_holds_the_median_and_lies_within_the_numbers(numbers):
    interval = Interval.of(numbers)
    assert min(numbers) <= interval.low <= interval.value <= interval.high <= max(numbers)
    assert interval.value == np.median(numbers)


@pytest.mark.parametrize("count", range(6, 80))
def test_as_many_are_left_out_as_95_percent_allow(count):
    """The true median lies below the number after the k least where at most k of them are below it."""
    left_out = _left_out(count)
    assert 2 * binom.cdf(left_out, count, 0.5) <= 0.05
    assert 2 * binom.cdf(left_out + 1, count, 0.5) > 0.05


@pytest.mark.parametrize("count", range(1, 6))
def test_of_few_numbers_the_range_is_given(count):
    numbers = np.arange(float(count))
    assert Interval.of(numbers) == Interval(np.median(numbers), 0.0, count - 1.0)


def test_the_interval_holds_the_median_of_a_skewed_law_as_often_as_it_says():
    rng = np.random.default_rng(1)
    found = [Interval.of(rng.exponential(size=15)) for _ in range(2000)]
    held = np.mean([each.low <= np.log(2) <= each.high for each in found])
    assert 0.95 <= held <= 0.985  # order statistics of 15 cover 96.5 %


def test_width_is_relative_and_a_share_keeps_it():
    interval = Interval(2.0, 1.0, 4.0)
    assert interval.width == 1.5
    assert interval.over(4.0) == Interval(0.5, 0.25, 1.0)
    assert Interval(0.0, 0.0, 0.0).width == 0.0


def busy(seconds):
    """Keeps the processor at work for so long."""
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


def test_processor_and_wall_time_are_told_apart_and_warm_up_too():
    first = []

    def slow_at_first():
        if not first:
            first.append(True)
            time.sleep(0.2)
        busy(2e-3)

    asleep, worked = time_all([("asleep", lambda: time.sleep(2e-3)), ("works", slow_at_first)], seconds=0.3)
    assert worked.warm_up >= 0.2
    assert np.median(worked.processor) == pytest.approx(2e-3, rel=0.5)
    assert np.median(worked.wall) < 0.1  # the warm-up is in no repeat
    assert np.median(asleep.wall) >= 2e-3
    assert np.median(asleep.processor) < 1e-3


def test_a_task_leaves_when_it_is_sure_and_all_run_when_nothing_is_left_to_spend():
    calls = {"long": 0, "short": 0}

    def task(name, seconds):
        def run():
            calls[name] += 1
            busy(seconds)

        return name, run

    long, short = time_all([task("long", 0.02), task("short", 0.006)], seconds=0.0)
    assert len(long.processor) == len(short.processor) == 1
    long, short = time_all([task("long", 0.02), task("short", 0.006)], seconds=60.0)
    assert LEAST_ROUNDS <= len(long.processor) <= MOST_ROUNDS
    assert len(short.processor) >= LEAST_ROUNDS


def test_calls_that_are_shorter_than_the_clock_ticks_are_repeated():
    calls = []
    (timing,) = time_all([("nothing", lambda: calls.append(0))], seconds=0.2)
    assert len(calls) > 100 * len(timing.processor)
    assert 0.0 < np.median(timing.wall) < 1e-4


def test_what_is_measured_is_told():
    told = []
    time_all([("a", lambda: None)], seconds=0.05, progress=lambda *step: told.append(step))
    assert told[0] == (1, 1, "warm-up: a")
    assert "settings sure after" in told[-1][2]
