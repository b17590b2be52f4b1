"""Springs that harden and soften, polynomially and exponentially."""

import numpy as np
import pytest

import springopt as so
from springopt.effects.probe import probe

SPRING = so.SpringLattice([[0.0, 0.0], [0.0, -2.0]], [[0, 1]])


def hanging(effect, weight, k=3.0):
    """The strain of a spring of length 2 that carries a weight, negative to stand on it."""
    case = so.LoadCase("weight", np.array([[True, True], [True, False]]), [[0, 0], [0, -weight]])
    solution = so.Model(SPRING, effect).solve([k], [case])
    assert solution.status[0] == "converged"
    return -solution.displacements[0, 1, 1] / 2.0


@pytest.mark.parametrize("weight", [0.5, 5.0, -2.0])
def test_a_hardening_spring_carries_a_weight_at_the_root_of_its_polynomial(weight):
    strain = hanging(so.Stiffening(quadratic=0.5, cubic=3.0), weight)
    roots = np.roots([3.0, 0.5, 1.0, -abs(weight) / 6.0])
    expected = np.sign(weight) * roots[np.abs(roots.imag) < 1e-12].real[0]
    assert strain == pytest.approx(expected, rel=1e-10)


def test_a_softening_spring_is_longer():
    assert hanging(so.Stiffening(quadratic=-0.5), 0.5) == pytest.approx(1 - np.sqrt(1 - 1 / 6), rel=1e-10)


@pytest.mark.parametrize("weight", [0.5, 50.0, -2.0])
@pytest.mark.parametrize("exponent", [0.0, 0.3, 20.0])
def test_an_exponential_spring_carries_a_weight_at_the_logarithm(weight, exponent):
    strain = hanging(so.ExponentialStiffening(exponent), weight)
    is_linear = weight < 0 or exponent == 0
    expected = weight / 6.0 if is_linear else np.log1p(exponent * weight / 6.0) / exponent
    assert strain == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("strain", [1e-12, 1e-6, 1e-3, 0.05, 0.1, 0.7, 3.0])
def test_the_exponential_keeps_its_digits(strain):
    kernel = so.ExponentialStiffening(5.0).potential(SPRING)
    found = probe(kernel, SPRING, np.array([[0, 0, 0, -2.0 * strain]]), stiffness=np.ones(1), values=np.array([5.0]))
    terms = [(5.0 * strain) ** n / np.prod(np.arange(1.0, n + 1)) for n in range(2, 60)]
    assert -found.forces[0, 3] == pytest.approx(2.0 * sum(terms) / 5.0, rel=1e-13)
    assert found.energy[0] == pytest.approx(4.0 * sum(terms[1:]) / 25.0, rel=1e-13)


def test_a_removed_spring_that_is_pulled_beyond_all_bounds_adds_nothing():
    kernel = so.ExponentialStiffening(50.0).potential(SPRING)
    found = probe(kernel, SPRING, np.array([[0, 0, 0, -1e6]]), stiffness=np.zeros(1), values=np.array([50.0]))
    assert found.energy[0] == 0
    np.testing.assert_array_equal(found.forces, 0)


@pytest.mark.parametrize("effect", [so.Stiffening(1.0), so.ExponentialStiffening(1.0)])
def test_springs_without_a_rest_length_have_no_strain(effect):
    lattice = so.SpringLattice([[0, 0], [1, 0]], [[0, 1]], [0.0])
    with pytest.raises(so.UserError, match="acts on the strain of springs, but spring 0 has the rest length 0"):
        so.Model(lattice, effect)


@pytest.mark.parametrize(
    ("effect", "message"),
    [
        (so.Stiffening(quadratic=[1.0, 2.0]), r"quadratic must have the shape \(\), not \(2,\)"),
        (so.Stiffening(cubic=np.nan), "cubic is nan, but it must be finite"),
        (so.ExponentialStiffening(-1.0), "exponent is -1, but it must be finite and not negative"),
    ],
)
def test_options_that_make_no_sense_are_refused(effect, message):
    with pytest.raises(so.UserError, match=message):
        so.Model(SPRING, effect)


def test_two_laws_at_once_are_refused():
    with pytest.raises(so.UserError, match="stiffening and tension-only both change the law of the springs"):
        so.Model(SPRING, [so.Stiffening(1.0), so.TensionOnly()])


def test_steps_far_into_the_exponential_are_taken_back_and_not_taken_for_rounding():
    grid, rng = so.SpringLattice.grid((7, 6)), np.random.default_rng(0)
    stiffness = rng.uniform(0.5, 10, (8, grid.spring_count))
    forces = rng.normal(0, 0.3, grid.nodes.shape) + np.array([0.15, -0.3])
    case = so.LoadCase("press", so.side(grid, "bottom"), forces)
    found = so.Model(grid, so.ExponentialStiffening(20.0)).solve_many(stiffness, [case])
    assert (found.status == "converged").all()
