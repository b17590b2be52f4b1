"""A population never stops for one bad candidate, and its cost is a slope to climb."""

import numpy as np
import pytest
from graded_cost import pull, walk

import springopt as so

FORCES = {"pull": (0.3, 0.0), "press": (-0.3, 0.0), "shear": (0.0, 0.3)}


def goal(shape):
    lattice = so.SpringLattice.grid(shape)
    padding = (0.0,) * (len(shape) - 2)
    cases = [pull(lattice, name, (*force, *padding)) for name, force in FORCES.items()]
    model = so.Model(lattice)
    return so.Objective(model, cases, model.solve(np.full(lattice.spring_count, 5.0), cases).positions)


def check_population(objective, count, density):
    rng = np.random.default_rng(round(10 * density))
    springs = objective.model.lattice.spring_count
    exists = rng.random((count, springs)) < density
    evaluation = objective.evaluate(np.where(exists, rng.uniform(0.5, 10, (count, springs)), 0.0))
    assert np.isfinite(evaluation.values).all()
    assert ((evaluation.values > 0) & (evaluation.values <= 2 * objective.cost_cap)).all()
    failed = evaluation.codes > 1
    assert (evaluation.values[failed] >= objective.cost_cap).all()
    assert np.isin(evaluation.codes, [0, 1, 2, 3, 4]).all()
    # Beside the loads that nothing resists, hardly any are given up.
    assert (evaluation.codes > 2).mean() < 0.01


@pytest.mark.parametrize("density", [0.3, 0.5, 0.7, 0.9])
def test_random_topologies_all_get_a_cost(density):
    check_population(goal((5, 5)), 200, density)
    check_population(goal((3, 3, 3)), 50, density)


@pytest.mark.slow
@pytest.mark.parametrize("density", [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
def test_ten_thousand_random_topologies_all_get_a_cost(density):
    check_population(goal((5, 5)), 10_000, density)
    check_population(goal((4, 4, 4)), 300, density)


def test_the_cost_falls_as_springs_are_added_until_there_is_an_equilibrium():
    paths = walk()
    median = np.median(paths.costs, axis=0)
    assert (np.diff(median) <= 0).all()
    assert median[0] == 2.0
    assert median[-1] < 1e-9
    still_failing = ~paths.has_equilibria[:, :-1] & ~paths.has_equilibria[:, 1:]
    steps = np.diff(paths.costs, axis=1)[still_failing]
    assert (steps <= 0).all()
    assert (steps < 0).mean() > 0.8
