"""The front of two goals, against the definition."""

import numpy as np
import pytest

from springopt.front import Front


def random_goals(rng, count):
    """Few different numbers, so that there are equals in one goal and in both."""
    return rng.integers(0, 12, count).astype(float), rng.integers(0, 12, count)


def beaten(i, values, springs):
    """Whether another point is as good in both goals and better in one, or the same in both and earlier."""
    as_good = (values <= values[i]) & (springs <= springs[i])
    better = (values < values[i]) | (springs < springs[i])
    return (as_good & (better | (np.arange(len(values)) < i))).any()


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("batch", [1, 7, 30])
def test_it_holds_every_point_that_no_other_beats_whatever_the_batches(seed, batch):
    values, springs = random_goals(np.random.default_rng(seed), 30)
    points = np.arange(30.0)[:, None]
    front = Front()
    for start in range(0, 30, batch):
        part = slice(start, start + batch)
        front = front.joined(values[part], springs[part], points[part])
    unbeaten = [i for i in range(30) if not beaten(i, values, springs)]
    assert sorted(front.points[:, 0].tolist()) == unbeaten
    kept = front.points[:, 0].astype(int)
    np.testing.assert_array_equal(front.values, values[kept])
    np.testing.assert_array_equal(front.springs, springs[kept])
    assert (np.diff(front.springs) > 0).all()
    assert (np.diff(front.values) < 0).all()


def test_an_empty_front_is_false_and_stays_empty_with_no_more_points():
    assert not Front()
    assert not Front().joined(np.empty(0), np.empty(0, dtype=int), np.empty((0, 3)))


def test_points_that_change_nothing_leave_the_front_as_it_is():
    front = Front().joined(np.array([2.0, 1.0]), np.array([1, 2]), np.zeros((2, 3)))
    assert front.joined(np.array([2.0, 3.0]), np.array([2, 1]), np.ones((2, 3))) is front
