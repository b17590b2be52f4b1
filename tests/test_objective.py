"""The objective: values, gradients against differences, and candidates without an equilibrium."""

from dataclasses import replace

import numpy as np
import pytest

import springopt as so
from springopt.misfit import MISFITS

GRID = so.SpringLattice.grid((4, 3))
STIFFNESS = np.random.default_rng(3).uniform(2, 8, GRID.spring_count)


def pull(force, *, hold="left", on="right", role="train"):
    forces = np.zeros(GRID.nodes.shape)
    forces[so.side(GRID, on)] = force
    return so.LoadCase(f"{hold} {force}", so.side(GRID, hold), forces, role=role)


CASES = [pull((0.3, 0.1)), pull((0.0, -0.2), hold="bottom", on="top"), pull((0.2, 0.2), role="test")]


def objective(minimize="distance", cases=CASES, **options):
    reference = so.SpringReference(so.Model(GRID), 5.0)
    return so.Objective(so.Model(GRID), cases, [reference.deform(case) for case in cases], minimize=minimize, **options)


@pytest.mark.parametrize("minimize", MISFITS)
def test_the_gradient_is_that_of_differences(minimize):
    goal = objective(minimize)
    value, gradient = goal.gradient(STIFFNESS)
    assert value == pytest.approx(goal.evaluate(STIFFNESS[None]).values[0], rel=1e-12)
    steps = 1e-5 * np.eye(len(STIFFNESS))
    ahead = goal.evaluate(STIFFNESS + steps).values
    behind = goal.evaluate(STIFFNESS - steps).values
    np.testing.assert_allclose(gradient, (ahead - behind) / 2e-5, atol=1e-9)


def test_the_jacobian_is_that_of_differences_and_agrees_with_the_gradient():
    goal = objective("least-squares", weights=[2.0, 0.5, 1.0])
    residuals, jacobian = goal.jacobian(STIFFNESS)
    np.testing.assert_array_equal(residuals, goal.residuals(STIFFNESS))
    value, gradient = goal.gradient(STIFFNESS)
    assert value == pytest.approx(0.5 * residuals @ residuals, rel=1e-12)
    np.testing.assert_allclose(jacobian.T @ residuals, gradient, atol=1e-12)
    for spring in (0, 7, 20):
        step = np.zeros(len(STIFFNESS))
        step[spring] = 1e-5
        difference = goal.residuals(STIFFNESS + step) - goal.residuals(STIFFNESS - step)
        np.testing.assert_allclose(jacobian[:, spring], difference / 2e-5, atol=1e-9)


@pytest.mark.parametrize("minimize", MISFITS)
def test_residuals_tell_the_value_in_every_misfit(minimize):
    goal = objective(minimize, weights=[2.0, 0.0, 1.0])
    value = goal.evaluate(STIFFNESS[None]).values[0]
    assert goal.value_of(goal.residuals(STIFFNESS)) == pytest.approx(value, rel=1e-12)


def test_a_reference_is_found_again_at_zero_cost_with_a_zero_gradient():
    goal = objective("least-squares")
    value, gradient = goal.gradient(np.full(GRID.spring_count, 5.0))
    assert value < 1e-18
    assert np.abs(gradient).max() < 1e-9


def test_the_definitions_agree_with_each_other():
    goal = objective()
    errors = goal.errors(STIFFNESS)
    assert [error.role for error in errors] == ["train", "train", "test"]
    for minimize, attribute in (
        ("distance", "distance"),
        ("relative-distance", "relative_distance"),
        ("least-squares", "least_squares"),
    ):
        value = objective(minimize).evaluate(STIFFNESS[None]).values[0]
        assert value == pytest.approx(sum(getattr(error, attribute) for error in errors[:2]), rel=1e-9)
    assert errors[0].relative_distance == pytest.approx(errors[0].distance / GRID.rest_lengths.min())
    assert all(error.max_distance >= error.distance for error in errors)


def test_test_cases_do_not_enter_the_value():
    with_test, without = objective(), objective(cases=CASES[:2])
    np.testing.assert_array_equal(with_test.evaluate(STIFFNESS[None]).values, without.evaluate(STIFFNESS[None]).values)


def test_the_cost_of_a_mechanism_falls_as_springs_are_added():
    goal = objective()
    order = np.random.default_rng(8).permutation(GRID.spring_count)
    ladder = np.zeros((GRID.spring_count + 1, GRID.spring_count))
    for count in range(1, GRID.spring_count + 1):
        ladder[count:, order[count - 1]] = 5.0
    evaluation = goal.evaluate(ladder)
    assert np.isfinite(evaluation.values).all()
    assert evaluation.codes[0] == 2
    assert evaluation.codes[-1] == 0
    stuck = evaluation.codes == 2
    assert (evaluation.values[stuck] >= goal.cost_cap).all()
    assert (evaluation.values[~stuck] < goal.cost_cap).all()
    assert len(np.unique(evaluation.values[stuck])) > 3
    assert (np.diff(evaluation.values[stuck]) <= 0).all()


def test_a_candidate_without_an_equilibrium_has_no_gradient():
    goal = objective()
    with pytest.raises(so.NoEquilibrium, match="has no equilibrium at this stiffness: mechanism"):
        goal.gradient(np.zeros(GRID.spring_count))
    with pytest.raises(so.NoEquilibrium):
        goal.jacobian(np.zeros(GRID.spring_count))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"minimize": "distanse"}, "Did you mean 'distance'"),
        ({"cases": [CASES[2]]}, "at least one load case with the role 'train'"),
        ({"weights": [1.0]}, "weights must have the shape"),
        ({"weights": [1.0, -1.0, 1.0]}, "weights"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"cost_cap": -1.0}, "cost_cap"),
    ],
)
def test_bad_options_are_refused_in_one_sentence(options, message):
    with pytest.raises(so.UserError, match=message):
        objective(**options)


def test_a_reference_model_without_an_equilibrium_is_refused():
    with pytest.raises(so.UserError, match="must have an equilibrium"):
        so.SpringReference(so.Model(GRID), 0.0).deform(CASES[0])


def test_a_value_has_the_same_bits_in_any_batch():
    goal = objective()
    candidates = np.random.default_rng(11).uniform(0.5, 9, (70, GRID.spring_count))
    together = goal.evaluate(candidates).values
    alone = [goal.evaluate(candidate[None]).values[0] for candidate in candidates]
    np.testing.assert_array_equal(together, alone)
    assert goal.gradient(candidates[0])[0] == together[0]


def test_values_are_cut_down_to_the_cap():
    goal = objective(cost_cap=0.01)
    assert goal.evaluate(STIFFNESS[None]).values[0] == 0.01


def test_load_cases_with_and_without_times_are_refused_beside_each_other():
    model = so.Model(GRID, so.Inertia(1.0), stepping=so.Stepping(0.1))
    moving = replace(CASES[0], times=[1.0])
    with pytest.raises(so.UserError, match="have equally many times, or none of them has any"):
        so.Objective(model, [CASES[2], moving], np.stack([GRID.nodes] * 2))
