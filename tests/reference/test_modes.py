"""What one mode answers to a sudden load, in every kind of damping."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from springopt.reference.modes import step_response

TIMES = np.array([0.1, 1.0, 7.0])


@pytest.mark.parametrize("square", [0.0, 0.5, 4.0])
@pytest.mark.parametrize("damping", [0.0, 1e-5, 0.3, 4.0, 4.0 + 1e-9, 30.0])
def test_the_response_is_that_of_a_general_integrator(square, damping):
    def rates(time, state):
        return [state[1], 1.0 - damping * state[1] - square * state[0]]

    expected = solve_ivp(rates, (0.0, TIMES[-1]), [0.0, 0.0], "DOP853", t_eval=TIMES, rtol=1e-12, atol=1e-13).y[0]
    found = step_response(np.array([square]), np.array([damping]), TIMES)[:, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_an_undamped_mode_swings_about_its_static_answer():
    np.testing.assert_allclose(step_response(np.array([4.0]), np.zeros(1), TIMES)[:, 0], (1 - np.cos(2 * TIMES)) / 4)


def test_a_mode_that_nothing_holds_falls():
    np.testing.assert_array_equal(step_response(np.zeros(1), np.zeros(1), TIMES)[:, 0], TIMES**2 / 2)


def test_the_series_of_small_damping_joins_the_closed_form():
    damping = np.array([0.999e-3, 1.001e-3])
    below, above = step_response(np.zeros(2), damping, np.ones(1))[0]
    assert below == pytest.approx(above, rel=1e-6)
    assert below == pytest.approx(0.5 - damping[0] / 6 + damping[0] ** 2 / 24, rel=1e-9)


def test_nothing_overflows_however_strong_the_damping_and_long_the_time():
    found = step_response(np.array([1.0, 1e12]), np.array([1e6, 1e-3]), np.array([1e-9, 1e9]))
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found[1], [1.0, 1e-12])
