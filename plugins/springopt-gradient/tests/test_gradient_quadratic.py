"""The minimum of a quadratic in a box, judged by its slopes."""

import numpy as np
import pytest
from springopt_gradient.quadratic import minimize_in_box


def a_quadratic(seed: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((size, size)) * 10.0 ** rng.uniform(-2, 2, size)
    return root.T @ root + 1e-6 * np.eye(size), 10 * rng.standard_normal(size)


def test_without_a_bound_in_the_way_it_is_the_solution_of_the_equations():
    A, g = a_quadratic(0, 8)
    far = np.full(8, 1e9)
    np.testing.assert_allclose(A @ minimize_in_box(A, g, -far, far), -g, atol=1e-6)


@pytest.mark.parametrize("size", [1, 2, 30])
def test_slopes_vanish_inside_and_lead_outwards_on_the_bounds(size):
    for seed in range(20):
        A, g = a_quadratic(seed, size)
        lower, upper = -np.full(size, 0.1), np.linspace(0.0, 0.2, size)
        d = minimize_in_box(A, g, lower, upper)
        slope, slack = g + A @ d, 1e-9 * np.abs(g).max()
        assert (np.abs(slope[(d > lower) & (d < upper)]) <= 1e-6 * np.abs(g).max()).all()
        assert (slope[(d == lower) & (lower < upper)] >= -slack).all()
        assert (slope[(d == upper) & (lower < upper)] <= slack).all()


def test_an_interval_of_one_number_is_kept():
    A, g = a_quadratic(1, 6)
    lower, upper = np.full(6, -1.0), np.ones(6)
    lower[2] = upper[2] = 0.0
    assert minimize_in_box(A, g, lower, upper)[2] == 0
