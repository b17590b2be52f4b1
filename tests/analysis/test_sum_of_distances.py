"""Sums of distances whose minima are known."""

import numpy as np
import pytest

from springopt.analysis.sum_of_distances import least_sum_of_distances

EYE = np.eye(2)
LOW, HIGH = np.full(2, -10.0), np.full(2, 10.0)


def median(points: list[tuple[float, float]], low=LOW, high=HIGH, start=(3.0, -2.0)) -> np.ndarray:
    """The point of the box with the least sum of distances to these."""
    goals = np.array(points)
    return least_sum_of_distances(np.stack([EYE] * len(goals)), goals, np.array(start), low, high)


def test_of_a_convex_quadrangle_it_is_where_the_diagonals_cross() -> None:
    assert median([(0, 0), (4, 0), (6, 6), (0, 2)]) == pytest.approx([4 / 3, 4 / 3], abs=1e-8)


def test_in_an_obtuse_corner_the_minimum_is_at_the_kink() -> None:
    assert median([(0, 0), (1, 0), (-1, 0.2)]) == pytest.approx([0, 0], abs=1e-9)


def test_bounds_hold() -> None:
    assert median([(2, 2), (2, 3), (4, 2)], high=np.array([1.0, 10.0]), start=(0.0, 0.0))[0] == 1.0


def test_a_corner_of_the_box_is_kept() -> None:
    assert median([(5, 5), (5, 6)], low=LOW, high=np.zeros(2), start=(0.0, 0.0)).tolist() == [0.0, 0.0]


def test_no_distance_is_left_where_all_can_vanish() -> None:
    rng = np.random.default_rng(0)
    blocks, truth = rng.normal(size=(12, 2, 5)), rng.uniform(-1, 1, 5)
    found = least_sum_of_distances(blocks, blocks @ truth, np.zeros(5), np.full(5, -2.0), np.full(5, 2.0))
    assert found == pytest.approx(truth, abs=1e-9)


def test_a_direction_that_no_distance_sees_is_left_as_it_is() -> None:
    blocks = np.stack([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]] * 3)
    goals = np.array([(0.0, 0.0), (1.0, 0.0), (-1.0, 0.2)])
    found = least_sum_of_distances(blocks, goals, np.full(3, 0.5), np.full(3, -1.0), np.full(3, 1.0))
    assert found == pytest.approx([0, 0, 0.5], abs=1e-9)


def test_it_is_not_above_any_neighbour() -> None:
    rng = np.random.default_rng(1)
    blocks, goals = rng.normal(size=(30, 3, 6)), rng.normal(size=(30, 3))
    low, high = np.full(6, -0.1), np.full(6, 0.1)
    found = least_sum_of_distances(blocks, goals, np.zeros(6), low, high)
    neighbours = np.clip(found + 1e-4 * rng.normal(size=(200, 6)), low, high)
    sums = np.linalg.norm(blocks @ neighbours.T[None] - goals[:, :, None], axis=1).sum(axis=0)
    assert np.linalg.norm(blocks @ found - goals, axis=1).sum() <= sums.min() + 1e-12
