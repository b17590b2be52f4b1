"""pymoo's algorithms: the contract, their randomness, how they end, and a front whose answer is known."""

import contextlib

import numpy as np
import pytest
from springopt_pymoo.cma_es import CMAES
from springopt_pymoo.de import DE
from springopt_pymoo.ga import GA
from springopt_pymoo.mixed_ga import MixedGA
from springopt_pymoo.nsga2 import NSGA2
from springopt_pymoo.pso import PSO

import springopt as so
from springopt.budget import Budget
from springopt.forward.status import MECHANISM
from springopt.testing import Bowl, Box, Tape, Unraced, check_optimizer
from springopt.testing.optimizer_checks import (
    check_runs_to_its_end,
    check_same_seed_same_journal,
    check_stays_in_the_box,
)
from springopt.testing.small_grid import binary_grid, real_grid

OPTIMIZERS = [CMAES, DE, GA, MixedGA, NSGA2, PSO]
BINARY = [GA, MixedGA, NSGA2]
#: With small populations many generations fit into the budgets of the checks.
VARIANTS = [
    CMAES(first=1, population=4, growth=1),
    CMAES(first=4, sigma=2.0, bipop=True),
    DE(population=6, base="rand", differences=2, crossover="exp"),
    DE(population=8, base="target-to-best", crossover="line", F=2.0),
    DE(population=8, crossover="hypercube", CR=1.0),
    GA(population=4, children=7),
    MixedGA(population=4, children=3),
    NSGA2(population=5, switches=6.0),
    PSO(population=2, adaptive=False, inertia=2.0),
    PSO(population=5, perturb_best=False, fastest=1.0),
]
SIZE = 8
CENTER = np.array([0.3, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0])


def real_box(lower=0.0, size=SIZE):
    return Box(np.full(size, lower), np.full(size, 10.0))


def bits(size=SIZE):
    return Box(np.zeros(size), np.ones(size), kind="binary")


def solved(optimizer, box, *, center=CENTER, evaluations=1000, seed=0, tape=None):
    """A problem after the optimizer was at work on it."""
    problem = so.Problem(Bowl(center[: box.size]), box, Budget(evaluations=evaluations), tape)
    with contextlib.suppress(so.BudgetSpent):
        optimizer.minimize(problem, np.random.default_rng(seed))
    return problem


@pytest.mark.parametrize(
    "optimizer",
    # pymoo's mating of mixed variables goes from gene to gene, and 8 s are too long for every day.
    [pytest.param(each, id=each.name, marks=[pytest.mark.slow] * (each is MixedGA)) for each in OPTIMIZERS],
)
def test_the_contract_is_kept(optimizer):
    check_optimizer(optimizer)


@pytest.mark.parametrize("check", [check_runs_to_its_end, check_stays_in_the_box, check_same_seed_same_journal])
def test_the_mixed_ga_keeps_the_quick_part_of_the_contract(check):
    check(MixedGA)


@pytest.mark.parametrize("optimizer", VARIANTS, ids=repr)
def test_other_options_stay_in_the_box_too(optimizer):
    check_stays_in_the_box(optimizer)


@pytest.mark.parametrize("optimizer", OPTIMIZERS, ids=lambda optimizer: optimizer.name)
def test_numpy_s_global_generator_is_neither_read_nor_changed(optimizer, capsys):
    questions = []
    for seed in (1, 2):
        np.random.seed(seed)  # noqa: NPY002
        state, tape = np.random.get_state()[1].copy(), Tape()  # noqa: NPY002
        solved(optimizer(), real_box(), evaluations=400, tape=tape)
        np.testing.assert_array_equal(np.random.get_state()[1], state)  # noqa: NPY002
        questions.append([answer.question for answer in tape.answers])
    assert questions[0] == questions[1]
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("optimizer", OPTIMIZERS, ids=lambda optimizer: optimizer.name)
@pytest.mark.parametrize("kind", ["real", "binary"])
def test_the_first_questions_are_the_problem_s_own_sample(optimizer, kind):
    if kind == "binary" and optimizer not in BINARY:
        return
    box = real_box() if kind == "real" else bits()
    problem = so.Problem(Bowl(CENTER), box, Budget(evaluations=5))
    sample = {}
    problem.sample = lambda rng, count: sample.setdefault("points", box.sample(rng, count))
    with contextlib.suppress(so.BudgetSpent):
        optimizer().minimize(problem, np.random.default_rng(3))
    assert problem.best_value == Bowl(CENTER).evaluate(sample["points"][:5]).values.min()


@pytest.mark.parametrize("optimizer", OPTIMIZERS, ids=lambda optimizer: optimizer.name)
def test_no_criterion_of_pymoo_ends_a_search_before_its_budget(optimizer):
    problem = solved(optimizer(), real_box(size=2), evaluations=2000)
    assert problem.meter.evaluations == 2000
    assert problem.best_value < 1e-3


@pytest.mark.parametrize("optimizer", BINARY, ids=lambda optimizer: optimizer.name)
def test_a_box_of_bits_that_is_exhausted_ends_the_search(optimizer):
    problem = solved(optimizer(), bits(size=3))
    assert problem.meter.evaluations == 8
    np.testing.assert_array_equal(problem.best_point, [0, 1, 1])


def known_front(center, *, upper):
    """The lowest value for each number of springs: those go first whose absence costs the least."""
    held = 0.5 * (np.minimum(center, upper) - center) ** 2
    gained = np.sort(0.5 * center**2 - held)[::-1]
    return (0.5 * center**2).sum() - np.append(0.0, np.cumsum(gained))


def test_nsga2_finds_the_front_of_a_binary_box():
    center = np.array([0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9])
    front = solved(NSGA2(population=40), bits(), center=center).front
    absent, present = 0.5 * center**2, 0.5 * (1 - center) ** 2
    np.testing.assert_array_equal(front.springs, np.arange(9))
    np.testing.assert_allclose(front.values, absent.sum() - np.append(0, np.cumsum((absent - present)[::-1])))


def test_nsga2_finds_the_front_of_a_real_box():
    front = solved(NSGA2(population=40), real_box(), evaluations=3000).front
    known = known_front(CENTER, upper=10.0)
    assert set(front.springs) >= set(range(8))  # the weakest spring, 0.3 of 12, is hardly worth it
    np.testing.assert_allclose(front.values, known[front.springs], atol=0.01 * known[0])


def test_nsga2_leaves_springs_that_can_not_be_absent():
    problem = solved(NSGA2(population=10), real_box(lower=0.5))
    np.testing.assert_array_equal(problem.front.springs, [SIZE])


def test_nsga2_keeps_candidates_without_an_equilibrium_behind_all_others():

    class Capped(Bowl):
        """Below six springs there is no equilibrium."""

        cost_cap = 1e3

        def evaluate(self, stiffness):
            found = super().evaluate(stiffness)
            failed = np.count_nonzero(stiffness, axis=1) < 6
            found.values[failed], found.codes[failed] = 1.5 * self.cost_cap, MECHANISM
            return found

    problem = so.Problem(Capped(CENTER), real_box(), Budget(evaluations=3000))
    asked = []
    ask = problem.objectives
    problem.objectives = lambda points: asked.append(ask(points)) or asked[-1]
    with contextlib.suppress(so.BudgetSpent):
        NSGA2(population=40).minimize(problem, np.random.default_rng(0))
    assert problem.front.springs[0] == 6
    assert np.median(asked[-1][:, 1]) >= 6


def test_the_mixed_ga_switches_springs_off():
    problem = solved(MixedGA(), real_box(), center=np.where(CENTER > 3.5, CENTER, 0.0), evaluations=3000)
    assert np.count_nonzero(problem.best_point[:4]) == 0
    assert problem.best_point[4:].all()


@pytest.mark.parametrize(
    ("optimizer", "options"),
    [
        (CMAES, {"sigma": 0.0}),
        (CMAES, {"population": 3}),
        (DE, {"population": 5}),
        (GA, {"population": 1}),
        (GA, {"children": 0}),
        (MixedGA, {"population": 1}),
        (NSGA2, {"switches": -1.0}),
        (PSO, {"fastest": 1.5}),
    ],
)
def test_an_option_outside_its_range_is_refused_in_one_sentence(optimizer, options):
    ((name, value),) = options.items()
    with pytest.raises(so.UserError, match=rf"option {name} of {optimizer.name} lies in \[.*\], not at {value}"):
        optimizer(**options)


@pytest.mark.parametrize("optimizer", [GA(population=10), MixedGA(population=10)])
@pytest.mark.parametrize("grid", [real_grid, binary_grid])
def test_raced_or_not_genetic_algorithms_are_the_same_to_the_bit(grid, optimizer):
    ends = []
    for cls in (so.Problem, Unraced):
        tape = Tape()
        problem = cls(*grid(), Budget(evaluations=600), tape)
        with contextlib.suppress(so.BudgetSpent):
            optimizer.minimize(problem, np.random.default_rng(1))
        ends.append(([answer.question for answer in tape.answers], problem.best_point.tolist(), problem.best_value))
        solves = problem.meter.solves
    assert ends[0] == ends[1]
    assert solves == 4 * 600
