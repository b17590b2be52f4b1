"""Motions and stability limits that are known in closed form."""

import numpy as np
import pytest

import springopt as so
from springopt.errors import UserError
from springopt.tradeoff.independent.motion import known_motion
from springopt.tradeoff.independent.stability_limit import stability_limit
from springopt.tradeoff.independent.system import System

STIFFNESS, MASS, FORCE = 5.0, 0.8, 0.3
OMEGA = np.sqrt(STIFFNESS / MASS)


def oscillator(*effects, mass=MASS, times=(0.4, 1.7, 9.0)):
    """One mass on one spring, pulled along it."""
    pair = so.SpringLattice(np.array([[0.0, 0.0], [2.0, 0.0]]), np.array([[0, 1]]))
    held = np.array([[True, True], [False, True]])
    case = so.LoadCase("pull", held, np.array([[0.0, 0.0], [FORCE, 0.0]]), times=np.array(times))
    model = so.Model(pair, [so.Inertia(mass=mass), *effects])
    return System.of(model, np.array([STIFFNESS]), np.float64), case


def test_one_mass_swings_about_its_equilibrium():
    system, case = oscillator()
    motion = known_motion(system, case)
    exact = FORCE / STIFFNESS * (1.0 - np.cos(OMEGA * case.times))
    np.testing.assert_allclose(motion.displacements[:, 1, 0], exact, rtol=1e-10)
    assert not motion.displacements[:, 0].any()
    assert motion.doubt < 1e-8


def test_a_dashpot_takes_the_swing_away():
    system, case = oscillator(so.Damping(springs=0.1))
    decay = 0.1 * STIFFNESS / (2.0 * MASS)
    damped = np.sqrt(OMEGA**2 - decay**2)
    swing = np.exp(-decay * case.times) * (np.cos(damped * case.times) + decay / damped * np.sin(damped * case.times))
    np.testing.assert_allclose(
        known_motion(system, case).displacements[:, 1, 0], FORCE / STIFFNESS * (1 - swing), rtol=1e-10
    )


def test_a_support_that_is_moved_pulls_from_the_beginning():
    system, case = oscillator()
    prescribed = np.array([[0.2, 0.0], [np.nan, np.nan]])
    case = so.LoadCase("jerk", case.supports, np.zeros((2, 2)), prescribed, times=case.times)
    np.testing.assert_allclose(
        known_motion(system, case).displacements[:, 1, 0], 0.2 * (1.0 - np.cos(OMEGA * case.times)), rtol=1e-10
    )


def test_a_node_without_mass_is_refused():
    system, case = oscillator(mass=[1.0, 0.0])
    with pytest.raises(UserError, match="node 1 moves and has no mass"):
        known_motion(system, case)


def test_a_fast_body_ends_where_small_steps_of_the_forward_solve_do():
    grid = so.SpringLattice.grid((3, 3))
    forces = np.zeros(grid.nodes.shape)
    forces[-1] = [0.5, 0.2]
    case = so.LoadCase("pull", so.side(grid, "left"), forces, times=np.array([0.5, 2.0]))
    effects = [
        so.Inertia(mass=0.5),
        so.Volume(1.0),
        so.Damping(nodes=0.1),
        so.PlaneContact(30.0, (0.0, -0.01), (0.0, 1.0)),
    ]
    stiffness = np.full(grid.spring_count, 3.0)
    motion = known_motion(System.of(so.Model(grid, effects), stiffness, np.float64), case)
    coarse, fine = (
        so.Model(grid, effects, stepping=so.Stepping(step)).solve(stiffness, [case], 1e-12).displacements[0]
        for step in (4e-3, 2e-3)
    )
    # Of second order: what is off in the coarse one is four times what is off in the fine one.
    np.testing.assert_allclose((4.0 * fine - coarse) / 3.0, motion.displacements, atol=1e-6)


def largest_of_central_differences(step, damping=0.0, count=2000):
    """The largest displacement of the oscillator, velocities half a step behind."""
    x, v, largest = 0.0, 0.0, 0.0
    for _ in range(count):
        v += step * (FORCE - STIFFNESS * x - damping * v) / MASS
        x += step * v
        largest = max(largest, abs(x))
    return largest


@pytest.mark.parametrize("damping", [0.0, 0.1, 1.0])
def test_central_differences_are_stable_just_below_the_limit_and_unstable_just_above(damping):
    system, case = oscillator(*([so.Damping(springs=damping)] if damping else []))
    limit = stability_limit(system, case)
    zeta = damping * OMEGA / 2.0
    assert limit.frequency == pytest.approx(OMEGA)
    assert limit.damping_ratio == pytest.approx(zeta)
    assert limit.step == pytest.approx(2.0 / OMEGA * (np.sqrt(1.0 + zeta**2) - zeta))
    assert largest_of_central_differences(0.99 * limit.step, damping * STIFFNESS) < 10.0 * FORCE / STIFFNESS
    assert largest_of_central_differences(1.01 * limit.step, damping * STIFFNESS) > 1e3


def test_nothing_limits_what_does_not_vibrate():
    system, case = oscillator()
    held = so.LoadCase("held", np.ones((2, 2), dtype=bool), np.zeros((2, 2)), times=case.times)
    assert stability_limit(system, held).step == np.inf
    assert not known_motion(system, held).displacements.any()
