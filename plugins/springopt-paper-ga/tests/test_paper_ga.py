"""The paper's genetic algorithm: the contract in every reading, the paper's constants, and its two recoveries."""

import contextlib
from pathlib import Path

import numpy as np
import pytest
from springopt_paper_ga import CROSSOVERS, LIMITS, SELECTIONS, SURVIVALS, PaperGA

import springopt as so
from springopt.budget import Budget
from springopt.testing import CHECKS, Bowl, Box
from springopt.testing.optimizer_checks import check_resumes_exactly, check_stays_in_the_box

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
