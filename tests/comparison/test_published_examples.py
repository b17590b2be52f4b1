"""The statistics of a comparison, beside numbers that others published."""

import math

import numpy as np
import pytest
from scipy.stats import PermutationMethod, friedmanchisquare, mannwhitneyu, norm, rankdata, tiecorrect, wilcoxon

from springopt.comparison.across_scenes import critical_difference, friedman, iman_davenport, rank, signed_ranks
from springopt.comparison.effect_size import probability_of_lower, rank_biserial
from springopt.comparison.holm import holm
from springopt.comparison.profiles import performance_profile
from springopt.comparison.rank_sum import EXACT_UP_TO, mann_whitney
from springopt.comparison.running_time import expected_running_time, running_time

#: Demsar (2006), Table 6: AUC of C4.5, C4.5+m, C4.5+cf and C4.5+m+cf on 14 data sets, in thousandths. The ranks printed
#: beside them tell the two 975 of the data set "voting" apart, which are rounded: half a thousandth does here.
METHODS = ["C4.5", "C4.5+m", "C4.5+cf", "C4.5+m+cf"]
AUC = np.array(
    [
        [763, 768, 771, 798],
        [599, 591, 590, 569],
        [954, 971, 968, 967],
        [628, 661, 654, 657],
        [882, 888, 886, 898],
        [936, 931, 916, 931],
        [661, 668, 609, 685],
        [583, 583, 563, 625],
        [775, 838, 866, 875],
        [1000, 1000, 1000, 1000],
        [940, 962, 965, 962],
        [619, 666, 614, 669],
        [972, 981, 975.5, 975],
        [957, 978, 946, 970],
    ]
)
LOSSES = 1001 - AUC  # whatever falls where the AUC rises, and is positive
DATA_SETS = [f"data set {number}" for number in range(14)]


class TestDemsar2006:
    """Statistical comparisons of classifiers over multiple data sets, J. Mach. Learn. Res. 7."""

    def test_mean_ranks_of_table_6(self) -> None:
        ranks = rank(METHODS, DATA_SETS, LOSSES).mean_ranks
        assert list(ranks) == ["C4.5+m+cf", "C4.5+m", "C4.5+cf", "C4.5"]
        assert [round(mean, 3) for mean in ranks.values()] == [1.964, 2.0, 2.893, 3.143]

    def test_friedman_s_statistic_is_9_28_before_its_correction_for_ties(self) -> None:
        ranks = rankdata(LOSSES, axis=1)
        untied = np.mean([tiecorrect(row) for row in ranks])
        assert friedman(LOSSES).chi_square * untied == pytest.approx(9.28, abs=0.005)
        assert friedman(LOSSES).p == friedmanchisquare(*LOSSES.T).pvalue

    def test_iman_and_davenport_s_statistic_is_3_69_and_rejects_at_5_percent(self) -> None:
        f, p = iman_davenport(9.28, 14, 4)
        assert f == pytest.approx(3.69, abs=0.005)
        assert p < 0.05

    @pytest.mark.parametrize(
        ("alpha", "quantiles"),
        [
            (0.05, [1.960, 2.343, 2.569, 2.728, 2.850, 2.949, 3.031, 3.102, 3.164]),
            (0.10, [1.645, 2.052, 2.291, 2.459, 2.589, 2.693, 2.780, 2.855, 2.920]),
        ],
    )
    def test_critical_values_of_table_5(self, alpha: float, quantiles: list[float]) -> None:
        for methods, quantile in enumerate(quantiles, start=2):
            difference = quantile * math.sqrt(methods * (methods + 1) / (6 * 14))
            assert critical_difference(methods, 14, alpha=alpha) == pytest.approx(difference, rel=5e-4)

    def test_critical_differences_of_the_example(self) -> None:
        assert critical_difference(4, 14) == pytest.approx(1.25, abs=0.005)
        assert critical_difference(4, 14, alpha=0.10) == pytest.approx(1.12, abs=0.005)

    def test_wilcoxon_of_table_2_rejects_and_its_rank_sums_are_93_and_12(self) -> None:
        differences = AUC[:, 1] - AUC[:, 0]
        assert rank_biserial(differences) == pytest.approx((93 - 12) / (93 + 12))
        assert signed_ranks(differences) < 0.05

    def test_holm_rejects_the_first_two_hypotheses_and_keeps_the_third(self) -> None:
        p_values = 2 * norm.sf([0.512, 2.416, 2.342])
        assert p_values == pytest.approx([0.607, 0.016, 0.019], abs=0.002)
        assert (holm(p_values) < 0.05).tolist() == [False, True, True]


@pytest.mark.parametrize("decimals", [15, 1], ids=["without ties", "with ties and zeros"])
def test_signed_ranks_are_scipy_s(decimals: int) -> None:
    # SciPy tries all signs where there are ties.
    for seed in range(4):
        differences = np.random.default_rng(seed).normal(0.2, 0.3, size=7).round(decimals)
        expected = wilcoxon(
            differences, zero_method="zsplit", method="exact" if decimals == 15 else PermutationMethod()
        )
        assert signed_ranks(differences) == pytest.approx(expected.pvalue)


@pytest.mark.parametrize("decimals", [15, 1], ids=["without ties", "with ties"])
def test_rank_sums_are_scipy_s(decimals: int) -> None:
    # SciPy tries all splits where there are ties.
    for seed in range(4):
        rng = np.random.default_rng(seed)
        first, second = rng.normal(0.3, 0.3, size=5).round(decimals), rng.normal(0, 0.3, size=4).round(decimals)
        expected = mannwhitneyu(first, second, method="exact" if decimals == 15 else PermutationMethod())
        assert mann_whitney(first, second) == pytest.approx(expected.pvalue)
        assert mann_whitney(second, first) == pytest.approx(expected.pvalue)


@pytest.mark.parametrize("runs", [3, 4, 15])
def test_two_values_apart_are_as_sure_as_the_order_of_so_many_runs(runs: int) -> None:
    assert mann_whitney(np.zeros(runs), np.ones(runs)) == pytest.approx(2 / math.comb(2 * runs, runs))


def test_of_many_runs_the_approximation_is_near_the_exact_sum() -> None:
    rng = np.random.default_rng(0)
    first, second = rng.normal(0.4, 1, EXACT_UP_TO // 2).round(1), rng.normal(0, 1, EXACT_UP_TO // 2).round(1)
    assert mann_whitney(first, second) == pytest.approx(mannwhitneyu(first, second).pvalue, rel=0.03)


def test_holm_by_hand_five_times_the_least_then_never_falling() -> None:
    assert holm(np.array([0.01, 0.02, 0.03, 0.04, 0.05])) == pytest.approx([0.05, 0.08, 0.09, 0.09, 0.09])


class TestRunningTime:
    def test_coco_s_example_of_one_success_among_five_failures(self) -> None:
        # The doctest of cocopp.toolsstats.simulated_evals: 1 evaluation to the success, 2, 4, 2, 6 and 100 in failures.
        spent, solved = np.array([1.0, 2, 4, 2, 6, 100]), np.array([True] + [False] * 5)
        assert expected_running_time(spent, solved) == 115

    def test_it_is_the_mean_of_simulated_restarts(self) -> None:
        # What the definition estimates: runs are drawn until one succeeds (Hansen and others 2016).
        spent, solved = np.array([1.0, 2, 4, 2, 6, 100]), np.array([True] + [False] * 5)
        rng, restarts = np.random.default_rng(0), []
        for _ in range(20_000):
            total, drawn = 0.0, rng.integers(6)
            while not solved[drawn]:
                total, drawn = total + spent[drawn], rng.integers(6)
            restarts.append(total + spent[drawn])
        assert np.mean(restarts) == pytest.approx(115, rel=0.03)

    def test_smoof_s_examples(self) -> None:
        # Tests of the R package smoof, computeExpectedRunningTime.
        assert expected_running_time(np.array([100.0, 200, 600]), np.ones(3, dtype=bool)) == 300
        assert expected_running_time(np.full(10, 100.0), np.zeros(10, dtype=bool)) == np.inf

    def test_success_and_failure_add_up_as_in_coco_s_other_form(self) -> None:
        # Mean of the successful + (1 - p) / p times the mean of the unsuccessful (Hansen and others 2016).
        spent, solved = np.array([10.0, 30, 50, 90]), np.array([True, True, False, False])
        assert expected_running_time(spent, solved) == 20 + (1 - 0.5) / 0.5 * 70

    def test_the_interval_of_runs_without_failure_covers_their_mean(self) -> None:
        estimate = running_time(np.arange(1.0, 16), np.ones(15, dtype=bool))
        assert estimate.low < estimate.value == 8 < estimate.high
        # The percentile interval of a mean of 15: 8 +- 1.96 * 4.32 / sqrt(15).
        assert (estimate.low, estimate.high) == pytest.approx((5.8, 10.2), abs=0.3)

    def test_few_successes_can_t_bound_the_time_from_above(self) -> None:
        estimate = running_time(np.full(15, 10.0), np.arange(15) == 0)
        assert estimate.value == 150
        assert estimate.high == np.inf


class TestEffectSizes:
    def test_scipy_s_example_of_mann_and_whitney_s_u(self) -> None:
        # scipy.stats.mannwhitneyu: U = 17 of the 5 * 4 pairs have the males' age above the females'.
        males, females = np.array([19.0, 22, 16, 29, 24]), np.array([20.0, 11, 17, 12])
        assert probability_of_lower(females, males).value == 17 / 20

    def test_tortoise_and_hare(self) -> None:
        # The order of finish T H H H H H T T T T T H has U = 11 and 25 of 36 (Mann and Whitney's test in Wikipedia).
        order = np.array(list("THHHHHTTTTTH"))
        places = np.arange(12.0)
        assert probability_of_lower(places[order == "T"], places[order == "H"]).value == pytest.approx(11 / 36)

    def test_no_overlap_is_certain_and_its_interval_has_a_width(self) -> None:
        estimate = probability_of_lower(np.arange(15.0), np.arange(15.0) + 20)
        assert estimate.value == estimate.high == 1
        assert 0.8 < estimate.low < 0.9

    def test_the_interval_covers_the_truth_nineteen_times_in_twenty(self) -> None:
        rng, truth = np.random.default_rng(0), norm.cdf(0.8 / math.sqrt(2))
        estimates = [probability_of_lower(rng.normal(size=15), rng.normal(size=15) + 0.8) for _ in range(500)]
        covered = np.mean([estimate.low <= truth <= estimate.high for estimate in estimates])
        assert covered == pytest.approx(0.95, abs=0.02)


def test_a_performance_profile_by_hand() -> None:
    # Dolan and More (2002), equations 2.1 and 2.2: ratios to the best are (1, 2), (4, 1) and (1, inf).
    times = np.array([[10.0, 20], [40, 10], [5, np.inf], [np.inf, np.inf]])
    profile = performance_profile("evaluations", times, ["a", "b"])
    shares = {name: dict(zip(np.round(profile.places, 6), profile.shares[name], strict=True)) for name in ("a", "b")}
    assert (shares["a"][1.0], shares["b"][1.0]) == pytest.approx((2 / 3, 1 / 3))
    assert (shares["a"][4.0], shares["b"][4.0]) == pytest.approx((1, 2 / 3))
    assert min(place for place, share in shares["b"].items() if share > 0.5) == pytest.approx(2, rel=0.06)
