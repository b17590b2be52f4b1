"""The whole comparison: which scenes are ranked, what is solved over budget, and its document."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from springopt.analysis.way import Way
from springopt.comparison.across_scenes import rank
from springopt.comparison.comparison import compare
from springopt.comparison.complete_block import complete_block
from springopt.comparison.method_summary import summarize
from springopt.comparison.profiles import solved_over_budget
from springopt.comparison.record import Record
from springopt.comparison.scene_comparison import compare_on_scene

MakeRecord = Callable[..., Record]

ERRORS = [("solved", 1e-16, 3e-16), ("held out none", 0.5, None)]


class TestCompleteBlock:
    def test_everybody_everywhere_leaves_nothing_out(self) -> None:
        block = complete_block({"a": {"x", "y"}, "b": {"y", "x"}}, {})
        assert (block.methods, block.scenes) == (["a", "b"], ["x", "y"])
        assert not block.methods_left_out
        assert not block.scenes_left_out

    def test_the_most_pairs_win_and_what_is_left_out_says_why(self) -> None:
        real = {"1", "2", "3"}
        served = {"a": real, "b": real | {"bits"}, "c": real | {"bits"}, "d": {"bits"}}
        words = {("d", scene): "binary" for scene in real} | {("a", "bits"): "real"}
        block = complete_block(served, words)
        assert (block.methods, block.scenes) == (["a", "b", "c"], ["1", "2", "3"])
        assert block.methods_left_out == {"d": "not on 1, 2, 3 (binary)"}
        assert block.scenes_left_out == {"bits": "no runs of a (real)"}

    def test_where_runs_are_only_missing_there_is_no_word(self) -> None:
        block = complete_block({"a": {"1", "2"}, "b": {"1", "2"}, "c": {"1"}, "d": {"1"}}, {("c", "2"): "memory"})
        assert block.methods_left_out == {"c": "not on 2 (memory)", "d": "not on 2"}

    def test_a_method_alone_on_many_scenes_is_no_ranking(self) -> None:
        block = complete_block({"a": {"1", "2", "3", "4"}, "b": {"4"}}, {})
        assert (block.methods, block.scenes) == (["a", "b"], ["4"])

    def test_many_methods_that_each_lack_another_scene_need_no_search_through_all_sets(self) -> None:
        # Whichever k scenes are left out, the k methods that lack them stay: (n - k) k pairs, the most at half.
        names = [f"{number:02}" for number in range(40)]
        block = complete_block({name: set(names) - {name} for name in names}, {})
        assert (len(block.methods), len(block.scenes)) == (20, 20)

    def test_a_method_that_serves_nothing_is_left_out(self) -> None:
        block = complete_block({"a": {"1"}, "b": {"1"}, "c": set()}, {("c", "1"): "memory"})
        assert block.methods_left_out == {"c": "not on 1 (memory)"}


class TestRanking:
    def test_ties_share_their_ranks_and_two_methods_need_no_friedman(self) -> None:
        ranking = rank(["a", "b"], ["1", "2"], np.array([[0.1, 0.1], [0.2, 0.1]]))
        assert ranking.mean_ranks == {"b": 1.25, "a": 1.75}
        assert ranking.friedman is None

    def test_methods_that_are_the_same_everywhere_do_not_differ(self) -> None:
        ranking = rank(["a", "b", "c"], ["1", "2"], np.full((2, 3), 0.5))
        assert ranking.friedman is not None
        assert (ranking.friedman.p, ranking.friedman.p_f, ranking.friedman.kendall_w) == (1, 1, 0)
        assert {pair.p_holm for pair in ranking.pairs} == {1}
        assert {pair.rank_biserial for pair in ranking.pairs} == {0}

    def test_one_order_on_every_scene_is_kendall_s_1(self) -> None:
        gaps = np.array([[1e-4, 1e-2, 1.0]] * 12) * np.arange(1, 13)[:, None]
        ranking = rank(["a", "b", "c"], [str(scene) for scene in range(12)], gaps)
        assert ranking.friedman is not None
        assert ranking.friedman.kendall_w == pytest.approx(1)
        assert (ranking.friedman.f, ranking.friedman.p_f) == (None, None)
        assert ranking.friedman.p == pytest.approx(np.exp(-12))  # of a chi-square of 24 with two degrees of freedom
        assert [pair.rank_biserial for pair in ranking.pairs] == [1, 1, 1]
        assert all(pair.p == pytest.approx(2 * 0.5**12) for pair in ranking.pairs)


def test_a_tenfold_gap_counts_alike_near_the_floor_and_far_from_it() -> None:
    # Ahead by ten on three scenes, behind by twenty on one: the sums of signed ranks are 6 and 4 whatever the level.
    gaps = np.array([[1e-5, 1e-4], [1e-3, 1e-2], [1e-1, 1.0], [2e-4, 1e-5]])
    assert rank(["a", "b"], list("1234"), gaps).pairs[0].rank_biserial == pytest.approx((6 - 4) / 10)


def test_the_share_solved_counts_scenes_targets_and_runs(record: MakeRecord) -> None:
    # One run reaches 1e-1 after 10 evaluations, another all six targets after 40; of the second scene there is no run.
    runs = [record([(10, 0.1)]), record([(40, 0.0)], seed=1)]
    ways = {"by hand": Way(1.0, "by hand", 0.0, True), "refused": Way(1.0, "by hand", 0.0, True)}
    curves = solved_over_budget({("by hand", "a"): runs}, ways)
    assert [curve.unit for curve in curves] == ["evaluations", "solves", "processor_seconds"]
    assert (curves[0].places[0], curves[0].places[-1]) == (10, 40)
    assert (curves[1].places[0], curves[1].places[-1]) == (20, 80)
    for curve in curves:
        assert (curve.shares["a"][0], curve.shares["a"][-1]) == pytest.approx((1 / 12 / 2, 7 / 12 / 2))


def test_a_summary_counts_against_the_best_method(record: MakeRecord, tmp_path: Path) -> None:
    fast = [record([(10, 1.0), (20, 0.0)], method="fast", seed=seed) for seed in range(2)]
    slow = [record([(10, 1.0), (60, 0.0)], method="slow", seed=seed) for seed in range(2)]
    scene = compare_on_scene(fast + slow, [tmp_path])
    first, second = summarize(["fast", "slow", "absent"], [scene], 2)
    assert first.times_the_best == dict.fromkeys(("evaluations", "solves", "processor_seconds"), 1)
    assert second.times_the_best == dict.fromkeys(("evaluations", "solves", "processor_seconds"), 3)
    assert (second.reached, second.scenes, second.success_rate) == (1, 1, 1)
    assert (second.train_error, second.test_error, second.overhead_share) == (0.1, 0.2, 0.25)


def test_a_method_that_reached_half_of_the_scenes_has_no_median(record: MakeRecord, tmp_path: Path) -> None:
    runs = {scene: [record([(1, 1.0), (2, 0.0)], scene=scene, method="b")] for scene in ("one", "two")}
    runs["one"].append(record([(1, 1.0), (4, 0.0)], scene="one"))
    runs["two"].append(record([(1, 1.0)], scene="two"))
    (its,) = summarize(["a"], [compare_on_scene(each, [tmp_path]) for each in runs.values()], 2)
    assert (its.reached, its.solvable, its.times_the_best["evaluations"]) == (1, 2, np.inf)


def test_errors_of_a_summary_are_of_scenes_with_test_load_cases(record: MakeRecord, tmp_path: Path) -> None:
    runs = {name: [record([(1, 0.0)], scene=name, train_error=error, test_error=test)] for name, error, test in ERRORS}
    (its,) = summarize(["a"], [compare_on_scene(its, [tmp_path]) for its in runs.values()], 2)
    assert (its.train_error, its.test_error) == (1e-16, 3e-16)
    (without,) = summarize(["a"], [compare_on_scene(runs["held out none"], [tmp_path])], 2)
    assert (without.train_error, without.test_error) == (None, None)


def test_the_document_has_everything_and_no_number_that_json_lacks(two_scenes: Path) -> None:
    document = json.loads(compare([two_scenes]).to_json())
    assert [each["method"] for each in document["methods"]] == list(document["ranking"]["mean_ranks"])
    scene, other = document["scenes"]
    assert (scene["scene"], other["scene"]) == ("nine", "soft")
    assert set(scene["methods"][0]["targets"]) == {"1", "2", "3", "4", "5", "6"}
    assert document["refusals"][0]["word"] == "bits"
    assert len(document["solved_over_budget"]) == len(document["performance_profiles"]) == 3


def test_the_same_results_give_the_same_document(folder: Path) -> None:
    assert compare([folder]).to_json() == compare([folder]).to_json()


def test_one_method_or_one_scene_has_no_ranks(two_scenes: Path) -> None:
    assert compare([two_scenes], optimizers=["wide"]).ranking is None
    assert compare([two_scenes], scenes=["nine"]).ranking is None
    assert compare([two_scenes]).ranking is not None


def test_unequal_numbers_of_runs_are_told(two_scenes: Path) -> None:
    assert any("1 to 3 runs on a scene" in note for note in compare([two_scenes]).notes)
