"""Sums of norms whose minimum is known from geometry."""

import numpy as np
import pytest
from springopt_gradient.norms import SumOfNorms

CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.3, 0.8]])


def nearest_to(points: np.ndarray, weights: np.ndarray, low: float = -5.0, high: float = 5.0) -> np.ndarray:
    """The point with the least weighted sum of distances to these, in a square box."""
    jacobian = np.tile(np.eye(points.shape[1]), (len(points), 1, 1))
    bounds = np.full(points.shape[1], low), np.full(points.shape[1], high)
    return SumOfNorms(-points, jacobian, weights).step(0.0, *bounds)


def test_fermats_point_sees_the_corners_at_a_third_of_a_turn():
    to_corners = CORNERS - nearest_to(CORNERS, np.ones(3))
    directions = to_corners / np.linalg.norm(to_corners, axis=1)[:, None]
    np.testing.assert_allclose(directions @ directions.T, 1.5 * np.eye(3) - 0.5, atol=1e-6)


def test_a_corner_that_outweighs_the_others_is_met():
    np.testing.assert_allclose(nearest_to(CORNERS, np.array([1.0, 1.0, 3.0])), CORNERS[2], atol=1e-6)


def test_on_a_line_it_is_the_median():
    numbers = np.array([[0.1], [0.2], [1.0], [4.0], [4.5]])
    np.testing.assert_allclose(nearest_to(numbers, np.ones(5)), [1.0], atol=1e-6)


def test_outside_the_box_its_border_is_the_nearest():
    np.testing.assert_allclose(nearest_to(CORNERS + 2, np.ones(3), high=1.0), [1.0, 1.0], atol=1e-12)


@pytest.mark.parametrize("damping", [1e-3, 1.0, 1e3])
def test_damping_shortens_the_step(damping):
    model = SumOfNorms(-CORNERS, np.tile(np.eye(2), (3, 1, 1)), np.ones(3))
    far = np.full(2, 5.0)
    damped, more = (np.linalg.norm(model.step(factor * damping, -far, far)) for factor in (1, 10))
    assert 0 < more < damped < np.linalg.norm(nearest_to(CORNERS, np.ones(3)))
