"""Equilibria move with the parameters of every effect as the derivatives say, in every engine."""

import numpy as np
import pytest
from catalogue import BODIES, POTENTIALS

import springopt as so
from springopt.forward.derivatives import linearize

MODELS = {"lanes": {}, "sparse": {"engine": "sparse"}, "linear": {"kinematics": "linear"}}
PAIRS = [
    (name, model)
    for name, (make, _) in POTENTIALS.items()
    for model in MODELS
    if model != "linear" or make(BODIES["2D"]).has_expansion_at_rest
]


@pytest.mark.parametrize("where", ["2D", "3D"])
@pytest.mark.parametrize(("name", "model"), PAIRS)
def test_equilibria_move_with_stiffness_and_parameters_as_is_said(name, model, where):
    lattice, (make, _) = BODIES[where], POTENTIALS[name]
    effect = make(lattice)
    fitted = [f"{effect.name}.{own}" for own in effect.parameters(lattice)]
    rng = np.random.default_rng(8)
    forces = 0.1 * rng.standard_normal(lattice.nodes.shape)
    cases = [so.LoadCase(side, so.side(lattice, side), forces) for side in ("left", "bottom")]
    asked = so.Model(lattice, effect, fitted=fitted, **MODELS[model])
    values = np.concatenate([np.zeros(0), *effect.parameters(lattice).values()])
    point = np.concatenate([rng.uniform(3.0, 7.0, lattice.spring_count), values])
    direction = rng.standard_normal(len(point))
    direction[lattice.spring_count :] *= 0.1

    def equilibria(point):
        batch = asked.solve_many(point[None], cases, tolerance=1e-12)
        assert (batch.status == "converged").all()
        return batch.displacements[0].reshape(2, -1)

    def central(h):
        return (equilibria(point + h * direction) - equilibria(point - h * direction)) / (2 * h)

    expected = (4.0 * central(5e-4) - central(1e-3)) / 3.0
    row = asked.terms.rows(point[None])[0]
    linearization = linearize(asked.groups(cases), row, equilibria(point))
    found = linearization.along(direction)
    np.testing.assert_allclose(found, expected, atol=2e-6 * np.abs(expected).max())
    load = rng.standard_normal(expected.shape)
    assert linearization.against(load) @ direction == pytest.approx((load * found).sum(), rel=1e-8)


GRID = BODIES["2D"]
PULL = [so.LoadCase("pull", so.side(GRID, "left"), np.where(so.side(GRID, "right")[:, None], [0.3, 0.1], 0.0))]


@pytest.mark.parametrize(
    ("springs", "modulus", "message"),
    [
        (GRID.spring_count - 1, [1.0, 1.0], "stiffness must have the shape"),  # as many numbers in all
        (GRID.spring_count - 1, 1.0, "stiffness must have the shape"),  # as many as there are springs
        (GRID.spring_count, [1.0, 1.0], r"volume.modulus must have the shape \(1,\), not \(2,\)"),
    ],
)
def test_parameters_of_another_shape_are_refused_and_not_read_as_others(springs, modulus, message):
    given = so.Parameters(np.full(springs, 5.0), {"volume.modulus": modulus})
    with pytest.raises(so.UserError, match=message):
        so.Model(GRID, so.Volume(1.0)).solve(given, PULL)


def test_bare_columns_of_parameters_are_finite():
    row = np.append(np.full(GRID.spring_count, 5.0), np.nan)
    with pytest.raises(so.UserError, match="is nan, but it must be finite"):
        so.Model(GRID, so.Volume(1.0), fitted="volume.modulus").solve(row, PULL)


def test_residuals_and_derivatives_take_parameters():
    positions = so.Model(GRID, so.Volume(2.0)).solve(np.full(GRID.spring_count, 5.0), PULL).positions
    goal = so.Objective(so.Model(GRID, so.Volume(1.0)), PULL, positions, minimize="least-squares")
    given = so.Parameters(np.full(GRID.spring_count, 4.0), {"volume.modulus": 3.0})
    value, gradient = goal.gradient(given)
    residuals, jacobian = goal.jacobian(given)
    assert 0.5 * residuals @ residuals == pytest.approx(value, rel=1e-9)
    np.testing.assert_allclose(goal.residuals(given), residuals)
    np.testing.assert_allclose(jacobian.T @ residuals, gradient.rows()[0], rtol=1e-7, atol=1e-14)
    np.testing.assert_allclose(goal.linearize(given)[1].rmatvec(residuals), gradient.rows()[0], rtol=1e-7, atol=1e-14)


def test_parameters_that_are_not_fitted_take_no_part_in_derivatives():
    springs = np.full(GRID.spring_count, 5.0)
    effects = [so.Volume(np.ones(len(GRID.cells))), so.Gravity((0.0, -0.1))]
    for fitted, count in (((), 0), (("gravity.mass",), len(GRID.cells) + 1)):
        model = so.Model(GRID, effects, fitted=fitted)
        row = model.terms.rows(springs[None])[0]
        displacements = model.solve(springs, PULL).displacements.reshape(1, -1)
        found = linearize(model.groups(PULL), row, displacements).by_parameters
        assert found.shape[1] == count
        assert not found[:, : len(GRID.cells)].any()


@pytest.mark.parametrize(
    ("effect", "values", "sentence"),
    [
        (so.Volume(1.0), {"volume.modulus": -5.0}, "volume.modulus is -5, and modulus is -5"),
        (so.Prestress(scale=0.9), {"prestress.scale": -1.0}, "prestress.scale is -1"),
        (so.ExponentialStiffening(2.0), {"exponential.exponent": -5.0}, "exponential.exponent is -5"),
        (so.Gravity((0.0, -1.0)), {"gravity.mass": -1.0}, "gravity.mass is -1"),
        (so.Volume(1.0), ["volume.modulus"], "a dictionary"),
    ],
)
def test_values_that_an_option_would_not_take_are_refused(effect, values, sentence):
    grid = so.SpringLattice.grid((3, 3))
    case = so.LoadCase("pull", so.side(grid, "left"), 0.1 * np.ones(grid.nodes.shape))
    with pytest.raises(so.UserError, match=sentence):
        so.Model(grid, [effect]).solve(so.Parameters(np.ones(grid.spring_count), values), [case])


def test_load_steps_refuse_loads_that_are_fitted():
    grid = so.SpringLattice.grid((3, 3))
    with pytest.raises(so.UserError, match="grows loads from nothing"):
        so.Model(grid, [so.Gravity((0.0, -1.0))], branch="followed", fitted=["gravity.mass"])


def test_a_density_of_the_area_is_refused_for_a_body_that_is_thick():
    grid = so.SpringLattice.grid((3, 3))
    with pytest.raises(so.UserError, match="of the area in 2D, and this body is 2 thick"):
        so.FemReference(grid, young=1.0, poisson=0.3, thickness=2.0, effects=[so.Gravity((0.0, -1.0), density=1.3)])
