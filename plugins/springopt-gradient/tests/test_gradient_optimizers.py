"""The three optimizers: the contract, the paper's springs, the floor of its finite element scene, the true topology."""

import contextlib
from pathlib import Path

import numpy as np
import pytest
from springopt_gradient import LBFGSB, GaussNewton, SparsePath

import springopt as so
from springopt.budget import Budget
from springopt.errors import NotServed
from springopt.testing import CHECKS, Bowl, Box
from springopt.testing.cliff import Cliff

OPTIMIZERS = [GaussNewton, LBFGSB, SparsePath]
#: The lowest objective known of paper-fem-2d; each of the 20 starts of the README ends in it.
FLOOR = 0.10622409
#: Springs without which paper-stiffness-2d is still stiff under all its supports.
ABSENT = [3, 9, 20, 31, 38, 44, 52, 60, 66, 70]


def minimized(optimizer: so.Optimizer, *, cliff: float = np.inf, evaluations: int = 400) -> so.Problem:
    """A bowl of six numbers, two of them best on the box's border, after the optimizer was at work on it."""
    box = Box(np.zeros(6), np.full(6, 10.0))
    bowl = Cliff(Bowl(np.linspace(-2.0, 12.0, 6)), cliff)
    problem = so.Problem(bowl, box, Budget(evaluations=evaluations))
    with contextlib.suppress(so.BudgetSpent):
        optimizer.minimize(problem, np.random.default_rng(0))
    return problem


@pytest.fixture
def sparse_scene(tmp_path: Path) -> Path:
    path = tmp_path / "sparse.toml"
    path.write_text(
        f'extends = "paper-stiffness-2d"\n[reference]\nkind = "spring"\nstiffness = 5.0\nabsent = {ABSENT}\n'
    )
    return path


@pytest.mark.parametrize("check", CHECKS)
@pytest.mark.parametrize("optimizer", OPTIMIZERS)
def test_it_keeps_the_contract(optimizer, check):
    check(optimizer)


@pytest.mark.parametrize("optimizer", [GaussNewton(), LBFGSB()], ids=lambda optimizer: optimizer.name)
def test_the_least_squares_of_a_box_are_found(optimizer):
    best = minimized(optimizer).best_point
    np.testing.assert_allclose(best, np.clip(np.linspace(-2.0, 12.0, 6), 0, 10), atol=1e-4)


def test_a_linear_problem_takes_one_step_and_one_look():
    first_search = GaussNewton(starts=1, damping=1e-12)
    assert minimized(first_search).meter.evaluations == 4


@pytest.mark.parametrize("optimizer", [GaussNewton(), LBFGSB()], ids=lambda optimizer: optimizer.name)
def test_it_comes_close_to_where_there_is_no_equilibrium_any_more(optimizer):
    problem = minimized(optimizer, cliff=1.0)
    assert problem.best_point[0] == 0
    assert problem.notes["searches"]


def test_searches_that_agree_are_enough_and_zero_ends_at_once():
    assert minimized(GaussNewton(agree=2)).notes["searches"][-1][1] == 2
    assert minimized(GaussNewton(agree=0), evaluations=100).meter.evaluations == 100
    assert so.solve("paper-stiffness-2d", "gauss-newton").notes["searches"] == [(18, 1.0)]


@pytest.mark.parametrize("optimizer", ["gauss-newton", "l-bfgs-b"])
def test_a_start_at_the_answer_ends_the_run(optimizer, sparse_scene, tmp_path):
    found = so.solve(sparse_scene, "gauss-newton", out=tmp_path / "found.h5")
    again = so.solve(sparse_scene, optimizer, start=found.run)
    assert again.notes["searches"][-1][1] == 1
    assert again.evaluations <= 10


def test_every_spring_of_the_paper_is_found():
    run = so.solve("paper-stiffness-2d", "gauss-newton", seed=1)
    np.testing.assert_allclose(run.stiffness, 5.0, atol=1e-5)
    assert run.evaluations <= 90


def test_the_floor_of_the_finite_element_scene_is_found_in_its_own_misfit():
    run = so.solve("paper-fem-2d", GaussNewton(starts=1), seed=2)
    assert run.objective == pytest.approx(FLOOR, rel=1e-6)
    assert run.evaluations <= 60


@pytest.mark.parametrize("minimize", ["least-squares", "relative-distance"])
def test_no_gradient_is_left_in_the_scenes_own_misfit(minimize):
    plain = so.load_scene("paper-fem-2d-three-class")
    objective = plain.objective.model_copy(update={"minimize": minimize})
    setup = plain.model_copy(update={"objective": objective}).build()
    problem = so.Problem(setup.objective, setup.encoding, Budget(evaluations=500))
    GaussNewton().minimize(problem, np.random.default_rng(0))
    value, best = problem.best_value, problem.best_point
    for step in 1e-3 * np.vstack([np.eye(3), -np.eye(3)]):
        assert problem.evaluate((best + step)[None])[0] > value


def test_the_knee_of_the_path_is_the_true_topology(sparse_scene):
    run = so.solve(sparse_scene, SparsePath(fewest=72 - len(ABSENT) - 2))
    springs, values = run.front.springs, run.front.values
    knee = int(np.flatnonzero(springs == 72 - len(ABSENT))[0])
    assert np.flatnonzero(run.front.points[knee] == 0).tolist() == ABSENT
    assert values[knee] < 1e-6
    assert values[knee - 1] > 1e-2


def test_the_path_leads_to_as_few_numbers_as_asked(sparse_scene):
    path = SparsePath(fewest=58, agree=1)
    assert so.solve(sparse_scene, path).front.springs.min() == 58


@pytest.mark.parametrize(
    ("optimizer", "options", "sentence"),
    [
        (GaussNewton, {"starts": 0}, "starts of gauss-newton is at least 1"),
        (GaussNewton, {"damping": 0.0}, "damping of gauss-newton"),
        (LBFGSB, {"agree": -1}, "agree of l-bfgs-b is 0 or more"),
        (LBFGSB, {"memory": 0}, "memory of l-bfgs-b"),
        (SparsePath, {"fewest": 0}, "fewest of sparse-path"),
    ],
)
def test_options_out_of_range_are_refused(optimizer, options, sentence):
    with pytest.raises(so.UserError, match=sentence):
        optimizer(**options)


def test_a_path_to_zero_needs_zero_in_the_box():
    problem = so.Problem(Bowl(np.ones(2)), Box(np.ones(2), np.full(2, 2.0)), Budget(evaluations=10))
    with pytest.raises(NotServed, match="a lower bound of 0") as refusal:
        SparsePath().minimize(problem, np.random.default_rng(0))
    assert refusal.value.word == "zero"


@pytest.mark.parametrize("optimizer", [GaussNewton(), SparsePath()], ids=lambda optimizer: optimizer.name)
def test_a_jacobian_too_large_for_memory_is_refused_before_it_is_asked_for(optimizer, monkeypatch):
    setup = so.load_scene("paper-fem-2d").build()
    problem = so.Problem(setup.objective, setup.encoding, Budget(evaluations=10))
    monkeypatch.setattr("springopt_gradient.memory.LARGEST_BYTES", 1e6)
    with pytest.raises(
        NotServed, match=f"{optimizer.name} would need some .* GB of memory for its Jacobian"
    ) as refusal:
        optimizer.minimize(problem, np.random.default_rng(0))
    assert refusal.value.word == "memory"
    assert problem.meter.evaluations == 0


@pytest.mark.slow
def test_every_identifiable_spring_is_found_from_any_start_in_few_evaluations():
    runs = [so.solve("paper-stiffness-2d", "gauss-newton", seed=seed) for seed in range(30)]
    assert max(np.abs(run.point - 5.0).max() for run in runs) <= 1e-5
    evaluations = [run.evaluations for run in runs]
    assert np.median(evaluations) <= 30
    assert max(evaluations) <= 90


@pytest.mark.slow
def test_twenty_starts_agree_on_the_floor():
    values = [so.solve("paper-fem-2d", GaussNewton(starts=1), seed=seed).objective for seed in range(20)]
    np.testing.assert_allclose(values, FLOOR, rtol=1e-7)


@pytest.mark.slow
def test_l_bfgs_b_comes_near_the_floor():
    assert so.solve("paper-fem-2d", LBFGSB(starts=1)).objective == pytest.approx(FLOOR, rel=1e-3)
