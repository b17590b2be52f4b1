import numpy as np
import pytest

import springopt as so
from springopt.encoding import Binary, Fitted, Homogeneous, WithParameters

LATTICE = so.SpringLattice.grid((3, 3))
FITTED = [Fitted(("gravity.mass", "gravity-2.mass"), 1, 0.5, 2.0), Fitted(("stranger.numbers",), 3, -1.0, 1.0)]
ENCODING = WithParameters(Homogeneous(LATTICE, upper=10.0), FITTED)


def test_points_decode_to_stiffness_and_then_the_value_of_every_name():
    row = ENCODING.decode([4.0, 1.5, -0.5, 0.0, 0.5])
    assert row[: LATTICE.spring_count].tolist() == [4.0] * LATTICE.spring_count
    assert row[LATTICE.spring_count :].tolist() == [1.5, 1.5, -0.5, 0.0, 0.5]
    assert ENCODING.names == ("gravity.mass", "gravity-2.mass", "stranger.numbers")
    assert ENCODING.parameters([4.0, 1.5, -0.5, 0.0, 0.5]) == {
        "gravity.mass": [1.5],
        "gravity-2.mass": [1.5],
        "stranger.numbers": [-0.5, 0.0, 0.5],
    }


def test_encoding_a_row_and_decoding_it_is_the_row():
    row = ENCODING.decode([4.0, 1.5, -0.5, 0.0, 0.5])
    np.testing.assert_allclose(ENCODING.decode(ENCODING.encode(row)), row)
    alone = ENCODING.encode(row[: LATTICE.spring_count])
    np.testing.assert_allclose(alone, [4.0, 1.25, 0.0, 0.0, 0.0])


def test_pulling_back_is_the_transpose_of_pushing_forward():
    rng = np.random.default_rng(0)
    point, change = ENCODING.sample(rng, 1)[0], rng.standard_normal(ENCODING.size)
    gradient = rng.standard_normal(LATTICE.spring_count + ENCODING.parameter_count)
    forward = ENCODING.push_forward(point, change)
    assert forward @ gradient == pytest.approx(change @ ENCODING.pull_back(point, gradient))
    np.testing.assert_allclose(ENCODING.decode(point + 1e-3 * change) - ENCODING.decode(point), 1e-3 * forward)


def test_bits_have_no_parameters_beside_them():
    with pytest.raises(so.UserError, match="the binary encoding has bits"):
        WithParameters(Binary(LATTICE, stiffness=1.0), FITTED)


@pytest.mark.parametrize("bounds", [(1.0, 1.0), (2.0, 1.0), (0.0, np.inf)])
def test_bounds_are_finite_and_ascend(bounds):
    with pytest.raises(so.UserError, match="a lower and a higher finite bound"):
        Fitted(("gravity.mass",), 1, *bounds)


def test_a_mass_is_found_with_the_stiffness():
    """Under gravity and a load the scale of both is known."""
    grid = so.SpringLattice.grid((4, 3))
    forces = np.zeros((2, *grid.nodes.shape))
    forces[1, so.side(grid, "right"), 0] = 0.2
    cases = [so.LoadCase(str(i), so.side(grid, "left"), force) for i, force in enumerate(forces)]
    truth = so.Parameters(np.full(grid.spring_count, 3.0), {"gravity.mass": 0.02})
    model = so.Model(grid, [so.Gravity((0.0, -1.0), mass=0.05)], fitted=["gravity.mass"])
    objective = so.Objective(model, cases, model.solve(truth, cases, 1e-12).positions, "least-squares")
    encoding = WithParameters(Homogeneous(grid, upper=10.0), [Fitted(("gravity.mass",), 1, 0.0, 1.0)])
    point = np.array([5.0, 0.05])
    for _ in range(20):
        residuals, jacobian = objective.jacobian(encoding.decode(point))
        step = np.linalg.lstsq(encoding.pull_back(point, jacobian), -residuals, rcond=None)[0]
        point = np.clip(point + step, encoding.lower + 1e-3, encoding.upper)
    np.testing.assert_allclose(point, [3.0, 0.02], rtol=1e-6)
