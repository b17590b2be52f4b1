"""Motion in time, against oscillators, free flight and what must never change."""

from dataclasses import replace

import numpy as np
import pytest

import springopt as so
from springopt.forward.status import Status

GRID = so.SpringLattice.grid((4, 3))
CUBE = so.SpringLattice.grid((3, 3, 2))
INTEGRATORS = ["energy-momentum", "l-stable"]
every_integrator = pytest.mark.parametrize("integrator", INTEGRATORS)


def spring(length=1.0):
    """One spring along x between a held node and one that moves along x."""
    return so.SpringLattice(np.array([[0.0, 0.0], [length, 0.0]]), np.array([[0, 1]]))


ALONG_X = np.array([[True, True], [False, True]])


def oscillator(step, times, integrator="energy-momentum", mass=2.0, effects=(), force=0.1, **stepping):
    model = so.Model(spring(), [so.Inertia(mass=mass), *effects], stepping=so.Stepping(step, integrator, **stepping))
    case = so.LoadCase("pull", ALONG_X, np.array([[0.0, 0.0], [force, 0.0]]), times=times)
    return model.solve([8.0], [case])


def elongations(solution):
    return solution.positions[0, :, 1, 0] - 1.0


def pulled(lattice, times, force=0.3, held="left"):
    supports = np.zeros(lattice.nodes.shape, dtype=bool) if held is None else so.side(lattice, held)
    forces = np.zeros(lattice.nodes.shape)
    forces[so.side(lattice, "right"), 0] = force
    forces[so.side(lattice, "right"), 1] = 0.5 * force
    return so.LoadCase("pull", supports, forces, times=times)


@every_integrator
def test_an_oscillator_has_its_frequency_to_second_order(integrator):
    times = np.linspace(0.0, 6.0, 13)[1:]
    exact = 0.1 / 8.0 * (1.0 - np.cos(np.sqrt(8.0 / 2.0) * times))
    errors = [np.abs(elongations(oscillator(h, times, integrator)) - exact).max() for h in (0.1, 0.05, 0.025)]
    # The trapezoidal rule turns by (omega h)^2 / 12 too little: 0.0025 of an angle of 12, at an amplitude of 0.0125.
    assert errors[2] < 3.2e-5
    assert 3.6 < errors[0] / errors[1] < 4.4
    assert 3.6 < errors[1] / errors[2] < 4.4


@every_integrator
def test_a_dashpot_damps_it_as_the_formula_says(integrator):
    times = np.linspace(0.0, 6.0, 13)[1:]
    rate, frequency = 0.15 * 8.0 / (2 * 2.0), 2.0
    damped = np.sqrt(frequency**2 - rate**2)
    decay = np.exp(-rate * times) * (np.cos(damped * times) + rate / damped * np.sin(damped * times))
    solution = oscillator(0.005, times, integrator, effects=[so.Damping(springs=0.15)])
    np.testing.assert_allclose(elongations(solution), 0.1 / 8.0 * (1.0 - decay), atol=1e-6)


@every_integrator
def test_nonlinear_motion_converges_to_second_order(integrator):
    case = pulled(GRID, [1.0, 2.0])
    stiffness = np.random.default_rng(0).uniform(2.0, 6.0, GRID.spring_count)

    def at_the_end(step):
        model = so.Model(GRID, [so.Inertia(mass=1.0)], stepping=so.Stepping(step, integrator))
        return model.solve(stiffness, [case], 1e-10).positions[0, -1]

    finest = at_the_end(1 / 640)
    errors = [np.abs(at_the_end(step) - finest).max() for step in (1 / 20, 1 / 40, 1 / 80)]
    assert 3.5 < errors[0] / errors[1] < 4.5
    assert 3.5 < errors[1] / errors[2] < 4.7


@pytest.mark.parametrize("lattice", [GRID, CUBE], ids=["2D", "3D"])
def test_energy_is_kept_over_a_hundred_thousand_steps(lattice):
    """Large rotations and strains, and steps of a tenth of the fastest period: where the trapezoidal rule blows up."""
    rng = np.random.default_rng(1)
    stiffness = rng.uniform(2.0, 6.0, lattice.spring_count)
    model = so.Model(lattice, [so.Inertia(mass=1.0)], stepping=so.Stepping(0.1))
    solution = model.solve(stiffness, [pulled(lattice, np.linspace(0.0, 1e4, 21)[1:])], 1e-10)
    assert solution.status[0] is Status.CONVERGED
    assert solution.batch.iterations[0, 0] == 100_000
    moved = 0.5 * (solution.velocities[0] ** 2).sum(axis=(1, 2))
    assert np.ptp(solution.energy[0]) < 1e-7 * moved.max()


@pytest.mark.parametrize(
    ("effect", "kept"),
    [(so.Volume(5.0), 1e-9), (so.Stiffening(cubic=3.0), 2e-4), (so.Bending(0.5), 2e-4)],
    ids=["area", "law", "bending"],
)
def test_energy_with_effects_is_kept_as_far_as_two_points_tell(effect, kept):
    """An area's is of the fourth degree, and exact; others are off by the fifth power of the step, which adds up."""
    stiffness = np.random.default_rng(1).uniform(2.0, 6.0, GRID.spring_count)
    case = pulled(GRID, np.linspace(0.0, 200.0, 11)[1:])

    def drift(step):
        model = so.Model(GRID, [so.Inertia(mass=1.0), effect], stepping=so.Stepping(step))
        solution = model.solve(stiffness, [case], 1e-10)
        assert solution.status[0] is Status.CONVERGED
        moved = 0.5 * (solution.velocities[0] ** 2).sum(axis=(1, 2))
        return np.ptp(solution.energy[0]) / moved.max()

    coarse, fine = drift(0.1), drift(0.05)
    assert coarse < kept
    assert fine < max(coarse / 8, 1e-9)


@pytest.mark.parametrize("stiffness", [1e3, 1e6])
@pytest.mark.parametrize("lattice", [GRID, CUBE], ids=["2D", "3D"])
def test_energy_is_kept_in_impacts_that_steps_do_not_resolve(lattice, stiffness):
    """A body is dropped on a plane and beside a ball."""
    down = np.zeros(lattice.dimension)
    down[-1] = -1.0
    ball = so.SphereContact(stiffness, [0.4] * (lattice.dimension - 1) + [-1.0], 0.9)
    plane = so.PlaneContact(stiffness, 0.3 * down, -down)
    effects = [so.Inertia(mass=1.0), so.Gravity(down), plane, ball]
    case = so.LoadCase("drop", np.zeros(lattice.nodes.shape, bool), 0.0 * lattice.nodes, times=np.arange(1, 41) * 0.1)
    model = so.Model(lattice, effects, stepping=so.Stepping(0.01))
    solution = model.solve(np.full(lattice.spring_count, 30.0), [case], 1e-10)
    assert solution.status[0] is Status.CONVERGED
    assert np.abs(solution.velocities[0, -1]).max() > 0.1
    at_rest = -sum(effects[1].constant_forces(lattice).ravel() * lattice.nodes.ravel())
    np.testing.assert_allclose(solution.energy[0], at_rest, atol=1e-6)


@pytest.mark.parametrize("stiffness", [1e4, 1e6, 1e8])
def test_the_l_stable_integrator_never_gains_in_impacts(stiffness):
    pair = so.SpringLattice(np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[0, 1]]))
    effects = [so.Inertia(mass=1.0), so.Gravity((0.0, -10.0)), so.PlaneContact(stiffness, (0.0, -0.2), (0.0, 1.0))]
    case = so.LoadCase("drop", np.zeros((2, 2), bool), np.zeros((2, 2)), times=np.arange(1, 121) * 0.01)
    solution = so.Model(pair, effects, stepping=so.Stepping(0.01, "l-stable")).solve([1.0], [case])
    assert solution.status[0] is Status.CONVERGED
    assert solution.energy.max() < 0.05  # of 4 that the fall makes
    assert solution.displacements[0, 30:, :, 1].max() < 0.005


@every_integrator
def test_engines_agree_in_contact(integrator):
    effects = [
        so.Inertia(density=1.0),
        so.Gravity((0, 0, -1.0), mass=0.2),
        so.PlaneContact(300.0, (0, 0, -0.05), (0, 0, 1)),
    ]
    case = replace(pulled(CUBE, [0.3, 1.0, 2.0]), forces=0.0 * CUBE.nodes)
    answers = [
        so.Model(CUBE, effects, stepping=so.Stepping(0.02, integrator), engine=name).solve(
            np.full(CUBE.spring_count, 3.0), [case], 1e-10
        )
        for name in ("lanes", "sparse")
    ]
    assert all(answer.status[0] is Status.CONVERGED for answer in answers)
    np.testing.assert_allclose(answers[0].positions, answers[1].positions, atol=1e-7)


@pytest.mark.parametrize("lattice", [GRID, CUBE], ids=["2D", "3D"])
def test_momentum_is_kept_in_free_flight(lattice):
    """Loads in balance wring the body; the centre stays, and angular momentum grows by their torque alone."""
    rng = np.random.default_rng(2)
    forces = 0.3 * rng.standard_normal(lattice.nodes.shape)
    forces -= forces.mean(axis=0)
    case = so.LoadCase("wrung", np.zeros(lattice.nodes.shape, dtype=bool), forces, times=np.linspace(0.0, 10.0, 11)[1:])
    masses = rng.uniform(0.5, 2.0, lattice.node_count)
    model = so.Model(lattice, [so.Inertia(mass=masses.tolist())], stepping=so.Stepping(0.05))
    solution = model.solve(rng.uniform(2.0, 6.0, lattice.spring_count), [case], 1e-11)
    momentum = np.einsum("n,tnd->td", masses, solution.velocities[0])
    np.testing.assert_allclose(momentum, 0.0, atol=1e-9)
    free = so.LoadCase("alone", case.supports, 0.0 * forces, times=case.times)
    assert np.abs(model.solve(np.ones(lattice.spring_count), [free]).velocities).max() == 0.0


def test_angular_momentum_is_kept_by_springs_that_pull_themselves_together():
    lattice = so.SpringLattice(GRID.nodes, GRID.springs, 0.7 * GRID.rest_lengths)
    uneven = np.random.default_rng(3).uniform(0.5, 5.0, lattice.spring_count)
    case = so.LoadCase("let go", np.zeros(GRID.nodes.shape, dtype=bool), 0.0 * GRID.nodes, times=[5.0, 10.0, 20.0])
    solution = so.Model(lattice, [so.Inertia(mass=1.0)], stepping=so.Stepping(0.05)).solve(uneven, [case], 1e-11)
    x, v = solution.positions[0], solution.velocities[0]
    assert np.abs(v).max() > 0.1
    np.testing.assert_allclose((x[..., 0] * v[..., 1] - x[..., 1] * v[..., 0]).sum(axis=1), 0.0, atol=1e-9)


@every_integrator
def test_a_falling_body_is_where_it_should_be(integrator):
    case = so.LoadCase("fall", np.zeros(GRID.nodes.shape, dtype=bool), 0.0 * GRID.nodes, times=[0.5, 1.0, 2.0])
    effects = [so.Inertia(mass=3.0), so.Gravity((0.0, -9.81), mass=3.0)]
    solution = so.Model(GRID, effects, stepping=so.Stepping(0.1, integrator)).solve(np.ones(GRID.spring_count), [case])
    fallen = solution.displacements[0, :, :, 1]
    np.testing.assert_allclose(fallen, np.repeat(-9.81 / 2 * np.square(case.times)[:, None], 12, axis=1), rtol=1e-9)


@every_integrator
@pytest.mark.parametrize("engine", ["sparse", "iterative"])
def test_engines_agree(engine, integrator):
    case = [pulled(CUBE, [0.3, 1.0, 2.0]), pulled(CUBE, [0.5, 1.5, 2.5], -0.3)]
    stiffness = np.random.default_rng(4).uniform(2.0, 6.0, CUBE.spring_count)
    effects = [so.Inertia(density=1.0), so.Damping(springs=0.05, nodes=0.1), so.Volume(2.0), so.Stiffening(cubic=3.0)]
    stepping = so.Stepping(0.1, integrator)
    answers = [
        so.Model(CUBE, effects, stepping=stepping, engine=name).solve(stiffness, case, 1e-10)
        for name in ("lanes", engine)
    ]
    assert all(status is Status.CONVERGED for answer in answers for status in answer.status)
    np.testing.assert_allclose(answers[0].positions, answers[1].positions, atol=1e-8)


def test_an_answer_does_not_depend_on_its_company():
    stiffness = np.random.default_rng(5).uniform(2.0, 6.0, (11, GRID.spring_count))
    cases = [pulled(GRID, [0.5, 1.0]), pulled(GRID, [0.25, 2.0], -0.4)]
    model = so.Model(GRID, [so.Inertia(mass=1.0)], stepping=so.Stepping(0.1))
    together = replace(model, threads=2).solve_many(stiffness, cases).positions
    for row, positions in zip(stiffness, together, strict=True):
        np.testing.assert_array_equal(model.solve(row, cases).positions, positions)


def test_with_damping_it_comes_to_rest_where_statics_say():
    effects = [so.Inertia(mass=1.0), so.Damping(springs=0.3, nodes=0.2)]
    stiffness = np.random.default_rng(6).uniform(2.0, 6.0, GRID.spring_count)
    at_rest = so.Model(GRID, effects).solve(stiffness, [replace(pulled(GRID, [1.0]), times=None)], 1e-11)
    moving = so.Model(GRID, effects, stepping=so.Stepping(0.2, "l-stable")).solve(stiffness, [pulled(GRID, [400.0])])
    np.testing.assert_allclose(moving.positions[0, -1], at_rest.positions[0], atol=1e-7)


def test_steps_become_as_short_as_the_error_takes():
    times = np.linspace(0.0, 6.0, 4)[1:]
    exact = 0.1 / 8.0 * (1.0 - np.cos(2.0 * times))
    loose, tight = (oscillator(1.0, times, step_error=error) for error in (1e-4, 1e-7))
    for solution, error in ((loose, 1e-4), (tight, 1e-7)):
        steps = solution.batch.iterations[0, 0]
        assert np.abs(elongations(solution) - exact).max() < steps * error
    assert tight.batch.iterations[0, 0] > 4 * loose.batch.iterations[0, 0]


def test_a_node_without_mass_is_refused_or_followed_by_stages():
    times = [0.5, 1.0, 2.0]
    chain = so.SpringLattice(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), np.array([[0, 1], [1, 2]]))
    supports = np.array([[True, True], [False, True], [False, True]])
    case = so.LoadCase("pull", supports, np.array([[0.0, 0], [0, 0], [0.1, 0]]), times=times)
    inertia = so.Inertia(mass=[1.0, 0.0, 2.0])
    with pytest.raises(so.UserError, match="node 1 moves and has no mass"):
        so.Model(chain, [inertia], stepping=so.Stepping(0.01)).solve([16.0, 16.0], [case])
    model = so.Model(chain, [inertia], stepping=so.Stepping(0.01, "l-stable"))
    x = model.solve([16.0, 16.0], [case]).displacements[0, :, :, 0]
    exact = 0.1 / 8.0 * (1.0 - np.cos(2.0 * np.array(times)))
    np.testing.assert_allclose(x[:, 2], exact, atol=2e-5)
    np.testing.assert_allclose(x[:, 1], x[:, 2] / 2, atol=1e-9)


def test_a_motion_that_breaks_off_says_so():
    """A step of 256 from rest finds no balance: the way ends where it stopped; a sixteenth of it gets through."""
    case = pulled(GRID, 256.0 * np.arange(1, 4))
    stiffness = np.random.default_rng(7).uniform(2.0, 6.0, GRID.spring_count)

    def ended(step):
        effects = [so.Inertia(mass=1.0), so.Damping(nodes=1.0)]
        return so.Model(GRID, effects, stepping=so.Stepping(step, "l-stable")).solve(stiffness, [case])

    broken = ended(256.0)
    assert broken.status[0] is Status.ITERATION_LIMIT
    assert not broken.displacements.any()
    assert ended(16.0).status[0] is Status.CONVERGED


@pytest.mark.parametrize(
    ("model", "sentence"),
    [
        (so.Model(GRID), "nothing has a mass; add the effect inertia"),
        (so.Model(GRID, [so.Inertia(mass=1.0)]), "no step is stated"),
        (
            so.Model(GRID, [so.Inertia(mass=1.0)], stepping=so.Stepping(0.1), kinematics="linear"),
            "exact kinematics only",
        ),
    ],
)
def test_what_motion_needs_is_asked_for(model, sentence):
    with pytest.raises(so.UserError, match=sentence):
        model.solve(np.ones(GRID.spring_count), [pulled(GRID, [1.0])])


def test_cases_with_and_without_times_are_solved_apart():
    cases = [pulled(GRID, [1.0]), pulled(GRID, None)]
    with pytest.raises(so.UserError, match="equally many times"):
        so.Model(GRID, [so.Inertia(mass=1.0)], stepping=so.Stepping(0.1)).solve(np.ones(GRID.spring_count), cases)


@pytest.mark.parametrize(
    "wrong", [{"step": 0.0}, {"step": -1.0}, {"step": 0.1, "integrator": "euler"}, {"step": 0.1, "step_error": 0.0}]
)
def test_steps_are_positive_and_integrators_known(wrong):
    with pytest.raises(so.UserError, match="must be"):
        so.Stepping(**wrong)
