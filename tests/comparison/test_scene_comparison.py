"""One scene: targets, deterministic methods, tests between runs."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from springopt.analysis import known_floor
from springopt.analysis.known_floor import Floor
from springopt.analysis.way import Way
from springopt.comparison.record import Record
from springopt.comparison.scene_comparison import compare_on_scene
from springopt.comparison.targets import SOLVED, clipped, way_of
from springopt.comparison.within_scene import Sample, compare_pairs

MakeRecord = Callable[..., Record]


@pytest.fixture
def floor(tmp_path: Path) -> Callable[..., Path]:
    """Stores a floor of the scene "by hand"; the folder that it lies in."""

    def make(value: float, analytic: float | None = 1.0, proof: str | None = None) -> Path:
        stored = Floor(
            scene="by hand",
            digest="1",
            minimize="distance",
            value=value,
            proof=proof,
            reached=value,
            point=[],
            analytic=analytic,
            evidence={},
        )
        known_floor.store_floor(tmp_path / "by hand.floor.json", stored)
        return tmp_path

    return make


def test_targets_lie_on_the_way_from_the_start_to_the_floor(record: MakeRecord, floor: Callable[..., Path]) -> None:
    way = way_of([record([(1, 0.9)])], [floor(0.5)])
    assert (way.start, way.floor, way.notes) == (1.0, 0.5, ())
    assert way.target(1) == 0.55
    assert way.gap(0.55) == pytest.approx(0.1)
    assert way.gap(2.0) == 3


def test_a_beaten_floor_gives_way_and_the_command_that_stores_it_is_told(
    record: MakeRecord, floor: Callable[..., Path]
) -> None:
    way = way_of([record([(1, 0.9), (2, 0.4)], path=Path("low.h5"))], [floor(0.5)])
    assert way.floor == 0.4
    assert "went below the floor of by hand, 0.5" in way.notes[0]
    assert "springopt floor by hand.toml --from low.h5" in way.notes[0]


def test_rounding_below_a_floor_beats_nothing(record: MakeRecord, floor: Callable[..., Path]) -> None:
    way = way_of([record([(1, 0.5 - 1e-11)])], [floor(0.5)])
    assert not way.notes
    assert way.gap(0.5 - 1e-11) == 0


def test_without_a_floor_the_lowest_run_and_the_first_values_stand_in(record: MakeRecord, tmp_path: Path) -> None:
    runs = [record([(1, first), (2, 0.5)], seed=seed) for seed, first in enumerate((2.0, 3.0, 9.0))]
    way = way_of(runs, [tmp_path])
    assert (way.start, way.floor) == (3.0, 0.5)
    assert any("no floor of by hand is stored" in note for note in way.notes)
    assert any("no start of by hand is stored" in note for note in way.notes)


def test_a_start_at_the_floor_leaves_differences(record: MakeRecord, floor: Callable[..., Path]) -> None:
    way = way_of([record([(1, 1.5)])], [floor(1.0)])
    assert way.gap(1.5) == 0.5
    assert any("not above its floor" in note for note in way.notes)


def test_what_solved_a_scene_is_equal() -> None:
    assert clipped(np.array([0.0, 1e-9, 1e-5])).tolist() == [SOLVED, SOLVED, 1e-5]


def test_success_and_running_time_of_a_target(record: MakeRecord, floor: Callable[..., Path]) -> None:
    runs = [record([(10, 0.6), (20, 0.5)]), record([(10, 0.6), (60, 0.5)], seed=1), record([(1, 0.9)], seed=2)]
    (method,) = compare_on_scene(runs, [floor(0.5)]).methods
    reached = method.targets[6]
    assert (reached.successes, method.runs) == (2, 3)
    assert reached.running_times["evaluations"].value == (20 + 60 + 100) / 2
    assert reached.running_times["solves"].value == 2 * (20 + 60 + 100) / 2
    assert 0.2 < reached.rate.low < 2 / 3 < reached.rate.high < 0.95
    assert method.cost.overhead_seconds == 25


def test_equal_courses_are_one_answer_and_not_fifteen(record: MakeRecord, floor: Callable[..., Path]) -> None:
    same = [record([(1, 0.7)], method="same", seed=seed) for seed in range(15)]
    better = [record([(1, 0.6 + 0.001 * seed)], method="better", seed=seed) for seed in range(15)]
    scene = compare_on_scene(same + better, [floor(0.5)])
    assert [(each.method, each.deterministic) for each in scene.methods] == [("better", False), ("same", True)]
    (pair,) = scene.pairs
    assert pair.test == "sign"
    assert pair.p == pytest.approx(2 * 0.5**15)
    assert (pair.lower.value, pair.ends_lower) == (1, "better")


def test_equal_courses_have_a_success_rate_without_an_interval(record: MakeRecord, floor: Callable[..., Path]) -> None:
    (method,) = compare_on_scene([record([(1, 0.5)], seed=seed) for seed in range(15)], [floor(0.5)]).methods
    rate = method.targets[6].rate
    assert (rate.low, rate.value, rate.high) == (1, 1, 1)


def test_a_deterministic_method_is_known_where_seconds_ended_its_runs(
    record: MakeRecord, floor: Callable[..., Path]
) -> None:
    improvements = [(1, 0.9), (10, 0.8), (20, 0.7)]
    runs = [
        record(improvements[:count], total=total, seed=total, budget={"seconds": 1.0})
        for count, total in [(1, 5), (2, 12), (3, 30)]
    ]
    scene = compare_on_scene([*runs, *(record([(1, 0.6)], method="b", seed=seed) for seed in range(3))], [floor(0.5)])
    assert [each.deterministic for each in scene.methods] == [True, True]
    assert scene.methods[1].gap.median == pytest.approx(0.6)
    (pair,) = scene.pairs
    assert (pair.test, pair.ends_lower) == ("none", "b")


def test_a_single_run_is_not_called_deterministic(record: MakeRecord, floor: Callable[..., Path]) -> None:
    (method,) = compare_on_scene([record([(1, 0.7)])], [floor(0.5)]).methods
    assert not method.deterministic


def sample(name: str, gaps: list[float], deterministic: bool = False) -> Sample:
    return Sample(name, np.array(gaps), deterministic)


def test_two_deterministic_methods_differ_without_a_test() -> None:
    (pair,) = compare_pairs([sample("a", [0.2], True), sample("b", [0.1], True)])
    assert (pair.test, pair.p, pair.p_holm, pair.lower.value, pair.ends_lower) == ("none", None, None, 0, "b")


def test_two_methods_that_both_solved_the_scene_do_not_differ() -> None:
    for deterministic in (False, True):
        (pair,) = compare_pairs([sample("a", [SOLVED], deterministic), sample("b", [SOLVED] * 3)])
        assert (pair.p, pair.lower.value, pair.ends_lower) == (1, 0.5, None)


def test_a_deterministic_method_first_or_second_says_the_same() -> None:
    random, fixed = sample("random", [0.1, 0.2, 0.3, 0.3]), sample("fixed", [0.3], True)
    (one,), (other,) = compare_pairs([random, fixed]), compare_pairs([fixed, random])
    assert one.p == other.p == 0.5
    assert (one.lower.value, other.lower.value) == (0.75, 0.25)
    assert (one.lower.low, one.lower.high) == pytest.approx((1 - other.lower.high, 1 - other.lower.low))


SHIFTS = {"a": 0.0, "b": 0.1, "c": 2.0}


def test_p_values_are_corrected_over_all_pairs_of_the_scene() -> None:
    rng = np.random.default_rng(0)
    pairs = compare_pairs([sample(name, (rng.random(15) + shift).tolist()) for name, shift in SHIFTS.items()])
    assert [pair.ends_lower for pair in pairs] == [None, "a", "b"]
    assert all(pair.p_holm >= pair.p for pair in pairs if pair.p_holm is not None and pair.p is not None)


def test_a_way_knows_its_targets_without_a_start_above_the_floor() -> None:
    assert Way(start=1.0, start_is="by hand", floor=1.0, proven=False).target(1) == 1.1
