"""The paper's genetic algorithm: the contract in every reading, the paper's constants, and its two recoveries."""

import contextlib
from pathlib import Path

import numpy as np
import pytest
from springopt_paper_ga import CROSSOVERS, LIMITS, MUTATIONS, SELECTIONS, SURVIVALS, PaperGA, Population

import springopt as so
from springopt.budget import Budget
from springopt.testing import CHECKS, Bowl, Box, Unraced
from springopt.testing.optimizer_checks import check_resumes_exactly, check_stays_in_the_box
from springopt.testing.small_grid import binary_grid, real_grid

READINGS = [
    *({"selection": selection} for selection in SELECTIONS),
    *({"crossover": crossover} for crossover in CROSSOVERS),
    *({"limit": limit, "limit_pmut": False} for limit in LIMITS),
    *({"survival": survival, "elite": 0} for survival in SURVIVALS),
    {"mutation": "gene"},
    {"mutation": "individual"},
    {"population": 1, "elite": 0},
]


def minimized(optimizer: PaperGA, kind: str = "real", evaluations: int = 2000) -> so.Problem:
    """A problem after the optimizer was at work on it: 12 numbers in [0, 10], or 12 bits."""
    if kind == "binary":
        box, center = Box(np.zeros(12), np.ones(12), kind="binary"), np.arange(12.0) % 2
    else:
        box, center = Box(np.zeros(12), np.full(12, 10.0)), np.linspace(0.0, 10.0, 12)
    problem = so.Problem(Bowl(center), box, Budget(evaluations=evaluations))
    with contextlib.suppress(so.BudgetSpent):
        optimizer.minimize(problem, np.random.default_rng(0))
    return problem


@pytest.mark.parametrize("check", CHECKS)
def test_it_keeps_the_contract(check):
    check(PaperGA)


@pytest.mark.parametrize("options", READINGS, ids=str)
def test_every_reading_keeps_to_the_box_and_resumes_exactly(options):
    check_stays_in_the_box(PaperGA(**options))
    check_resumes_exactly(PaperGA(**options))


def test_it_finds_the_bits():
    assert minimized(PaperGA(), "binary").best_value == 0


def test_it_finds_numbers_also_at_the_ends_of_the_interval():
    found = minimized(PaperGA(), evaluations=5000).best_point  # the last steps have a deviation of 0.1
    np.testing.assert_allclose(found, np.linspace(0.0, 10.0, 12), atol=0.2)


@pytest.mark.parametrize(("kind", "population"), [("binary", 5), ("real", 10)])
def test_a_generation_costs_as_many_evaluations_as_the_paper_has_individuals(kind, population):
    evaluations = [at for at, _ in minimized(PaperGA(), kind, evaluations=100).notes["mutation_probability"]]
    assert evaluations == list(range(population, 101, population))


def test_the_mutation_probability_falls_with_the_generation():
    probabilities = [number for _, number in minimized(PaperGA(), "binary", 50).notes["mutation_probability"]]
    np.testing.assert_allclose(probabilities[:4], [0.201, 0.101, 0.2 / 3 + 0.001, 0.051])


def test_the_deviation_is_at_most_the_size_of_the_interval():
    limited, free = (minimized(PaperGA(limit_pmut=limit), evaluations=100) for limit in (True, False))
    assert [number for _, number in limited.notes["mutation_deviation"]][:6] == [10, 10, 10, 10, 10, 50 / 6]
    assert free.notes["mutation_deviation"][0] == (10, 50)


def test_the_elite_is_kept_and_not_evaluated_again():
    calm = PaperGA(a=0, b=0, pcross=0, elite=9, population=10)  # nine parents and one copy of some parent live on
    assert minimized(calm, evaluations=1000).best_value == minimized(calm, evaluations=10).best_value


DRAWS = 20_000
ATOL = 0.015  # four deviations of a share of one half in so many draws


def shares(patterns: np.ndarray, count: int) -> np.ndarray:
    """How often each of `count` numbers came."""
    return np.bincount(patterns.ravel(), minlength=count) / patterns.size


def genes_as_number(masks: np.ndarray) -> np.ndarray:
    """The first gene is the highest bit, so that 0b011 are the second and the third of three."""
    return masks @ (1 << np.arange(masks.shape[1])[::-1])


@pytest.mark.parametrize(
    ("selection", "contestants", "values", "expected"),
    [
        ("tournament", 1, [0, 1, 3, 4], np.full(4, 1 / 4)),
        ("tournament", 2, [0, 1, 3, 4], np.array([7, 5, 3, 1]) / 16),
        ("tournament", 3, [0, 1, 3, 4], np.array([37, 19, 7, 1]) / 64),
        ("rank", 2, [0, 1, 3, 4], np.array([4, 3, 2, 1]) / 10),
        ("roulette", 2, [0, 1, 3, 4], np.array([4, 3, 1, 0]) / 8),
        ("roulette", 2, [1, 1, 1, 1], np.full(4, 1 / 4)),
    ],
)
def test_a_selection_prefers_the_better_by_its_shares_and_both_parents_alike(selection, contestants, values, expected):
    rng = np.random.default_rng(0)
    selected = (SELECTIONS[selection](np.array(values, float), contestants, rng) for _ in range(DRAWS // 4))
    first, second = np.concatenate(list(selected), axis=1)
    pairs = shares(4 * first + second, 16).reshape(4, 4)
    np.testing.assert_allclose(pairs, np.outer(expected, expected), atol=ATOL)


@pytest.mark.parametrize(
    ("crossover", "size", "expected"),
    [
        ("uniform", 3, dict.fromkeys(range(8), 1 / 8)),
        ("one-point", 4, dict.fromkeys([0b0111, 0b0011, 0b0001], 1 / 3)),
        ("two-point", 3, {0: 1 / 4} | dict.fromkeys([0b100, 0b010, 0b001, 0b110, 0b011, 0b111], 1 / 8)),
    ],
)
def test_a_crossover_takes_each_of_its_patterns_from_the_second_parent_alike(crossover, size, expected):
    masks = CROSSOVERS[crossover]((DRAWS, size), np.random.default_rng(0))
    wanted = [expected.get(pattern, 0.0) for pattern in range(2**size)]
    np.testing.assert_allclose(shares(genes_as_number(masks), 2**size), wanted, atol=ATOL)


def test_a_child_has_a_second_parent_with_probability_pcross():
    parents = Population(np.repeat(np.arange(DRAWS)[:, None], 2, axis=1), np.arange(DRAWS))
    children = PaperGA(pcross=0.7, crossover="one-point").cross(parents, np.random.default_rng(0))
    assert np.mean(children[:, 0] != children[:, 1]) == pytest.approx(0.7, abs=ATOL)


@pytest.mark.parametrize(
    ("mutation", "expected"),
    [
        ("every-gene", [0, 0, 0, 1]),
        ("gene", [0.7 * 0.7, 0.7 * 0.3, 0.3 * 0.7, 0.3 * 0.3]),
        ("individual", [0.7, 0.3 / 2, 0.3 / 2, 0]),
    ],
)
def test_a_mutation_meets_genes_with_probability_pmut(mutation, expected):
    masks = MUTATIONS[mutation](0.3, (DRAWS, 2), np.random.default_rng(0))
    np.testing.assert_allclose(shares(genes_as_number(masks), 4), expected, atol=ATOL)


@pytest.mark.parametrize(("mutation", "share"), [("every-gene", 1), ("gene", 0.1), ("individual", 0.1 / 2)])
def test_a_mutation_moves_the_numbers_that_it_meets_by_pmut_of_the_interval(mutation, share):
    box = Box(np.zeros(2), np.full(2, 100.0))
    problem = so.Problem(Bowl(np.full(2, 50.0)), box, Budget(evaluations=1))
    points = np.full((DRAWS, 2), 50.0)
    steps = PaperGA().mutate(points, 0.1, mutation, problem, np.random.default_rng(0)) - points
    assert np.mean(steps != 0) == pytest.approx(share, abs=ATOL)
    assert steps[steps != 0].std() == pytest.approx(0.1 * 100, rel=0.06)  # four deviations of 2000 steps' own


def limited(limit: str, sigma: float) -> tuple[np.ndarray, np.ndarray]:
    """Steps of that deviation from 2.5 in [2, 3], and where they would have led without limits."""
    points = np.full((DRAWS, 1), 2.5)
    moved = LIMITS[limit](points, np.array([sigma]), np.array([2.0]), np.array([3.0]), np.random.default_rng(0))
    return moved, points + sigma * np.random.default_rng(0).standard_normal(points.shape)


@pytest.mark.parametrize("limit", LIMITS)
def test_a_step_within_the_box_is_taken_as_it_is_and_the_others_end_in_the_box(limit):
    moved, free = limited(limit, 0.5)
    inside = (free >= 2) & (free <= 3)
    np.testing.assert_allclose(moved[inside], free[inside])
    assert 0.6 < inside.mean() < 0.8
    assert ((moved >= 2) & (moved <= 3)).all()


def test_clipped_steps_stop_at_the_end_that_they_crossed():
    moved, free = limited("clip", 0.5)
    assert (moved[free < 2] == 2).all()
    assert (moved[free > 3] == 3).all()


def test_reflected_steps_turn_back_at_each_end():
    moved, free = limited("reflect", 2.0)
    while ((free < 2) | (free > 3)).any():
        free = np.where(free < 2, 2 * 2 - free, np.where(free > 3, 2 * 3 - free, free))
    np.testing.assert_allclose(moved, free)


def test_redrawn_steps_are_spread_as_those_that_stayed_inside():
    moved, free = limited("redraw", 0.5)
    inside = (free >= 2) & (free <= 3)
    tenths = np.linspace(0, 1, 11)
    np.testing.assert_allclose(np.quantile(moved[~inside], tenths), np.quantile(free[inside], tenths), atol=0.03)


def test_steps_too_large_to_be_redrawn_are_clipped():
    assert set(np.unique(limited("redraw", 1e9)[0])) == {2.0, 3.0}


@pytest.mark.parametrize(
    ("survival", "elite", "survivors"),
    [
        ("generational", 0, ["best child", "second child", "worst child"]),
        ("generational", 1, ["best child", "best parent", "second child"]),
        ("generational", 2, ["best child", "best parent", "second parent"]),
        ("compete", 0, ["best child", "best parent", "second child"]),
    ],
)
def test_survivors_are_the_best_that_may_survive_and_among_equals_children(survival, elite, survivors):
    names = ["best parent", "second parent", "worst parent", "worst child", "best child", "second child"]
    points, values = np.arange(6.0)[:, None], np.array([1.0, 2.0, 3.0, 4.0, -1.0, 2.0])
    after = SURVIVALS[survival](Population(points[:3], values[:3]), Population(points[3:], values[3:]), elite)
    numbers = after.points[:, 0].astype(int)
    assert [names[number] for number in numbers] == survivors
    assert after.values.tolist() == values[numbers].tolist()


@pytest.mark.parametrize("survival", SURVIVALS)
@pytest.mark.parametrize("grid", [real_grid, binary_grid])
def test_raced_or_not_a_run_is_the_same_to_the_bit(grid, survival):
    optimizer, ends = PaperGA(population=8, survival=survival), []
    for cls in (so.Problem, Unraced):
        problem = cls(*grid(), Budget(evaluations=600))
        with contextlib.suppress(so.BudgetSpent):
            optimizer.minimize(problem, np.random.default_rng(1))
        by_generation = {(each.evaluations - 1) // 8: each.value for each in problem.meter.history}
        ends.append((by_generation, problem.best_point.tolist(), repr(problem.notes), problem.meter.evaluations))
    assert ends[0] == ends[1]


@pytest.mark.parametrize(
    ("options", "kind", "sentence"),
    [
        ({"pcross": 1.5}, "real", r"pcross of paper-ga lies in \[0, 1\], not at 1.5"),
        ({"population": 0}, "real", "population of paper-ga"),
        ({"elite": 5}, "binary", "no child could live among 5 individuals"),
        ({"mutation": "every-gene"}, "binary", "would flip every bit"),
    ],
)
def test_options_out_of_range_are_refused(options, kind, sentence):
    with pytest.raises(so.UserError, match=sentence):
        minimized(PaperGA(**options), kind)


def test_the_scene_with_one_side_clamped_differs_in_its_supports():
    clamped = so.load_scene(Path(__file__).parents[1] / "stiffness-2d-clamped.toml")
    assert {hold.on[0] for case in clamped.load_cases.train for hold in case.hold} == {"left"}


@pytest.mark.slow
def test_it_recovers_the_stiffness_of_section_4_2():
    stiffness = so.solve("paper-stiffness-2d", PaperGA(a=2.0)).stiffness
    assert np.count_nonzero(stiffness) == 72
    assert stiffness.mean() == pytest.approx(5, abs=0.1)
    assert stiffness.std() < 0.65


@pytest.mark.slow
def test_it_recovers_the_topology_of_section_3_2():
    assert np.count_nonzero(so.solve("paper-topology-3d", PaperGA()).stiffness) >= 463
