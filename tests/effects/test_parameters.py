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
