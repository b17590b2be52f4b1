"""Derivatives of motions by stiffness and every parameter, against differences; every effect, both integrators."""

import numpy as np
import pytest
from catalogue import BODIES, POTENTIALS

import springopt as so
from springopt.misfit import MISFITS

TIMES = [0.2, 0.5, 0.7]
MOTIONS = {
    name: (lambda body, make=make: [make(body)], tuple(fitted)) for name, (make, fitted) in POTENTIALS.items()
} | {
    "springs": (lambda body: [], ()),
    "dashpots": (lambda body: [so.Damping(springs=0.2)], ()),
    "drag": (lambda body: [so.Damping(nodes=np.linspace(0.1, 0.5, body.node_count))], ()),
    "weights": (lambda body: [so.Gravity((0.3, -0.2, 0.1)[: body.dimension], mass=0.7)], ("mass",)),
}
INTEGRATORS = ["energy-momentum", "l-stable"]


def objective(body, effects, integrator, minimize="least-squares", **options):
    rng = np.random.default_rng(3)
    cases = []
    for number, side in enumerate(("left", "bottom")):
        held = body.nodes[:, 0 if side == "left" else -1] < 0.3
        moved = np.where(held[:, None], 0.05 * number * np.ones(body.dimension), np.nan)
        cases.append(so.LoadCase(str(number), held, 0.5 * rng.standard_normal(body.nodes.shape), moved, times=TIMES))
    plain = so.Model(body, [so.Inertia(density=1.5), *effects])
    fitted = [f"{term.name}.{name}" for term in plain.terms.terms for name in term.effect.parameters(body)]
    fitted = [name for name in fitted if name not in ("prestress.scale", "gravity.mass")] + options.pop("also", [])
    model = so.Model(body, plain.effects, stepping=so.Stepping(0.1, integrator), fitted=fitted, **options)
    reference = body.nodes + 0.1 * rng.standard_normal((len(cases), len(TIMES), *body.nodes.shape))
    return so.Objective(model, cases, reference, minimize=minimize, weights=[1.0, 0.5], tolerance=1e-12)


def candidate(goal):
    rng = np.random.default_rng(4)
    springs = goal.model.lattice.spring_count
    values = goal.model.terms.defaults[goal.model.terms.fitted_columns]
    row = np.concatenate([rng.uniform(3.0, 7.0, springs), values])
    return row, np.concatenate([rng.standard_normal(springs), 0.1 * values * rng.standard_normal(len(values))])


def differences(function, point, direction, step=1e-2):
    def central(h):
        return (function(point + h * direction) - function(point - h * direction)) / (2 * h)

    return (4.0 * central(step / 2) - central(step)) / 3.0


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("body", ["2D", "3D"])
@pytest.mark.parametrize("name", MOTIONS)
def test_gradients_and_jacobians_are_those_of_differences(name, body, integrator):
    make, own = MOTIONS[name]
    effects = make(BODIES[body])
    also = [f"{effects[0].name}.{parameter}" for parameter in own]
    goal = objective(BODIES[body], effects, integrator, also=also)
    row, direction = candidate(goal)
    value, gradient = goal.gradient(row)
    assert value == goal.evaluate(row[None]).values[0]
    expected = differences(lambda z: goal.evaluate(z[None]).values[0], row, direction)
    # A node that comes into contact between two differences has a kink there.
    tolerance = 1e-4 if name in ("plane", "sphere", "inside a sphere", "tension-only") else 1e-7
    assert gradient @ direction == pytest.approx(expected, rel=tolerance)
    residuals, jacobian = goal.jacobian(row)
    np.testing.assert_allclose(residuals @ jacobian, gradient, atol=1e-9 * np.abs(gradient).max())
    _, operator = goal.linearize(row)
    np.testing.assert_allclose(operator.matvec(direction), jacobian @ direction, atol=1e-10)


@pytest.mark.parametrize("minimize", MISFITS)
def test_every_misfit_has_its_gradient_in_motion(minimize):
    goal = objective(BODIES["2D"], [so.Damping(springs=0.1)], "energy-momentum", minimize)
    row, direction = candidate(goal)
    expected = differences(lambda z: goal.evaluate(z[None]).values[0], row, direction)
    assert goal.gradient(row)[1] @ direction == pytest.approx(expected, rel=1e-7)


def test_parameters_by_name_give_gradients_by_name():
    body = BODIES["2D"]
    goal = objective(body, [so.Volume(3.0)], "energy-momentum")
    row, _ = candidate(goal)
    springs = body.spring_count
    value, flat = goal.gradient(row)
    named = so.Parameters(row[:springs], {"volume.modulus": row[springs + 1], "inertia.density": row[springs]})
    same, gradient = goal.gradient(named)
    assert same == pytest.approx(value, rel=1e-12)
    np.testing.assert_allclose(gradient.stiffness, flat[:springs], rtol=1e-9)
    assert gradient.values["volume.modulus"][0] == pytest.approx(flat[springs + 1], rel=1e-9)
    assert gradient.values["inertia.density"][0] == pytest.approx(flat[springs], rel=1e-9)


def test_steps_that_an_error_decides_have_no_derivatives():
    goal = objective(BODIES["2D"], [], "energy-momentum")
    model = so.Model(goal.model.lattice, goal.model.effects, stepping=so.Stepping(0.1, step_error=1e-3))
    loose = so.Objective(model, goal.cases, goal.reference_positions)
    with pytest.raises(so.UserError, match="steps that are fixed"):
        loose.gradient(np.ones(goal.model.lattice.spring_count))
