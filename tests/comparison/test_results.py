"""Which runs are compared, under which names, and what is said of the others."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from springopt.comparison.record import Record, mean_error
from springopt.comparison.results import read_results
from springopt.comparison.terms import on_equal_terms
from springopt.errors import UserError
from springopt.runner import solve
from springopt.scene import Scene, load_scene
from springopt.scene.bundled import SceneHead
from springopt.store import read

MakeRecord = Callable[..., Record]

NINE = (Path(__file__).parents[1] / "data" / "nine-nodes.toml").read_text()


def test_a_folder_s_runs_go_by_its_labels(folder: Path) -> None:
    results = read_results([folder])
    assert [(each.scene, each.method, each.seed) for each in results.records] == [
        ("nine", label, seed) for label in ("narrow", "wide") for seed in range(3)
    ]
    (refusal,) = results.refusals
    assert (refusal.scene, refusal.method, refusal.word) == ("nine", "stubborn", "bits")
    assert results.methods == ["narrow", "stubborn", "wide"]


def test_a_record_is_what_the_run_file_says(folder: Path) -> None:
    path = folder / "nine" / "wide" / "seed1.h5"
    run = read(path).run
    record = next(each for each in read_results([folder]).records if each.method == "wide" and each.seed == 1)
    assert record.value == run.objective
    assert record.total == {"evaluations": 16, "solves": run.solves, "processor_seconds": run.processor_seconds}
    assert record.time_to(run.objective, "evaluations") == run.history[-1].evaluations
    assert record.time_to(run.objective, "solves") == run.history[-1].solves
    assert record.train_error == pytest.approx(np.mean([error["relative_distance"] for error in run.errors[:2]]))
    assert record.test_error == run.errors[2]["relative_distance"]
    assert record.minimize == "least-squares"


def test_files_and_folders_may_be_mixed_and_no_run_counts_twice(folder: Path) -> None:
    run = folder / "nine" / "wide" / "seed1.h5"
    assert len(read_results([run, folder, folder / "nine"]).records) == 6


def test_a_run_that_is_named_is_read_wherever_it_lies(nine: Scene, folder: Path, tmp_path: Path) -> None:
    solve(nine, "random-search", evaluations=4, out=tmp_path / "seed0.h5")
    results = read_results([tmp_path / "seed0.h5", folder], scenes=["nine"], optimizers=["random-search", "wide"])
    assert results.methods == ["random-search", "wide"]


def test_one_scene_s_folder_keeps_its_labels_and_refusals(folder: Path) -> None:
    results = read_results([folder / "nine"], optimizers=["wide", "stubborn"])
    assert results.methods == ["stubborn", "wide"]
    assert results.refusals[0].scene == "nine"


def test_a_run_outside_a_folder_of_results_goes_by_its_optimizer(nine: Scene, tmp_path: Path) -> None:
    solve(nine, "random-search", evaluations=4, out=tmp_path / "mine.h5")
    (record,) = read_results([tmp_path / "mine.h5"]).records
    assert record.method == "random-search"


def test_what_is_not_compared_is_named(folder: Path) -> None:
    place = folder / "nine" / "wide"
    (place / "seed3.failed.json").write_text('{"sentence": "the optimizer divided by zero."}')
    (place / "seed4.h5.journal").write_bytes(b"")
    (place / "seed5.h5").write_bytes(b"no run")
    left_out = {Path(each.path).name: each.why for each in read_results([folder]).left_out}
    assert "divided by zero" in left_out["seed3.failed.json"]
    assert "--resume" in left_out["seed4.h5.journal"]
    assert "no run file" in left_out["seed5.h5"]


def test_a_complete_run_counts_whatever_lies_beside_it(nine: Scene, tmp_path: Path) -> None:
    solve(nine, "random-search", evaluations=4, out=tmp_path / "mine.h5")
    (tmp_path / "mine.h5.journal").write_bytes(b"left by a process that was killed just after it wrote the run file")
    results = read_results([tmp_path])
    assert [record.path.name for record in results.records] == ["mine.h5"]
    assert results.left_out == []


def test_only_what_is_named_is_compared(folder: Path) -> None:
    results = read_results([folder], optimizers=["wide"])
    assert {each.method for each in results.records} == {"wide"}
    assert not results.refusals


@pytest.mark.parametrize(
    ("chosen", "sentence"),
    [
        ({"optimizers": ["wyde"]}, "no optimizer 'wyde'.*Did you mean 'wide'"),
        ({"scenes": ["ten"]}, "no scene 'ten'"),
        ({"optimizers": ["stubborn"]}, "no complete run of what is to be compared"),
    ],
)
def test_a_choice_that_nothing_has_is_a_mistake(folder: Path, chosen: dict[str, list[str]], sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        read_results([folder], **chosen)


def test_a_group_names_its_scenes(record: MakeRecord, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    heads = {"nine": SceneHead("nine", "Nine", "small", "here"), "ten": SceneHead("ten", "Ten", "small", "here")}
    monkeypatch.setattr("springopt.comparison.results.bundled_scenes", lambda: heads)
    assert len(read_results([folder], scenes=["small"]).records) == 6


def test_what_is_not_asked_for_is_not_read(folder: Path) -> None:
    read = []
    read_results([folder], optimizers=["wide"], progress=lambda count, runs: read.append((count, runs)))
    assert read == [(1, 3), (2, 3), (3, 3)]


def test_nothing_there_is_a_mistake(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="nothing at"):
        read_results([tmp_path / "nowhere"])
    with pytest.raises(UserError, match="no complete run"):
        read_results([tmp_path])


def test_options_that_differ_under_one_name_are_kept_apart(folder: Path, add_run: Callable[..., Path]) -> None:
    add_run("wide", 4, seed=7)
    results = read_results([folder], optimizers=["wide"])
    assert results.methods == ["wide (batch=4)", "wide (batch=8)"]
    assert "differ in batch" in results.notes[0]


def test_a_method_is_called_the_same_on_all_scenes_and_found_by_label_or_name(
    two_scenes: Path, add_run: Callable[..., Path]
) -> None:
    add_run("wide", 4, seed=7)
    results = read_results([two_scenes])
    assert {each.method for each in results.records if each.label == "wide"} == {"wide (batch=4)", "wide (batch=8)"}
    assert {each.scene for each in results.records if each.method == "wide (batch=8)"} == {"nine", "soft"}
    assert "the runs of wide on nine differ in batch" in results.notes[0]
    by_name = read_results([two_scenes], optimizers=["wide (batch=8)", "narrow"])
    assert {each.method for each in by_name.records} == {"narrow", "wide (batch=8)"}
    assert {each.method for each in read_results([two_scenes], optimizers=["wide"]).records} == {
        "wide (batch=4)",
        "wide (batch=8)",
    }
    with pytest.raises(UserError, match=r"no optimizer 'wide \(batch=5\)'"):
        read_results([two_scenes], optimizers=["wide (batch=5)"])


def test_budgets_that_differ_under_one_name_are_kept_apart(folder: Path, add_run: Callable[..., Path]) -> None:
    add_run("wide", 8, seed=7, evaluations=24)
    results = read_results([folder])
    assert "wide (budget of evaluations=24)" in results.methods
    assert any("different budgets (16 evaluations; 24 evaluations)" in note for note in results.notes)


def test_two_states_of_a_scene_are_refused(record: MakeRecord) -> None:
    with pytest.raises(UserError, match="two states of a scene"):
        on_equal_terms([record([(1, 1.0)]), record([(1, 1.0)], digest="2", seed=1)])


def test_different_test_load_cases_under_one_scene_s_name_are_refused(
    nine: Scene, folder: Path, add_run: Callable[..., Path], tmp_path: Path
) -> None:
    other = tmp_path / "nine.toml"
    other.write_text(NINE.replace("force = [0.0, -0.2]", "force = [0.0, -0.3]"))
    scene = load_scene(other)
    assert scene.digest() == nine.digest()
    add_run("wide", 8, seed=7, scene=scene)
    with pytest.raises(UserError, match=r"different test load cases.*compare them apart"):
        read_results([folder])


def test_builds_that_differ_under_one_name_are_told(record: MakeRecord) -> None:
    notes = on_equal_terms(
        [record([(1, 1.0)]), record([(1, 1.0)], seed=1, build={"numpy": "2.1"}), record([(1, 1.0)], method="b")]
    )
    (note,) = notes
    assert "the runs of a were made by builds that differ in numpy" in note


def test_the_same_run_twice_is_refused(record: MakeRecord) -> None:
    with pytest.raises(UserError, match=r"one\.h5 and two\.h5 are the same run"):
        on_equal_terms([record([(1, 1.0)], path=Path("one.h5")), record([(1, 1.0)], path=Path("two.h5"))])


def test_seconds_of_different_processors_are_not_compared_silently(record: MakeRecord) -> None:
    notes = on_equal_terms([record([(1, 1.0)]), record([(1, 1.0)], processor="two", seed=1)])
    assert "2 types of processor" in notes[0]


def test_the_time_to_a_value_is_that_of_the_first_improvement_at_or_below_it(record: MakeRecord) -> None:
    run = record([(1, 4.0), (10, 2.0), (30, 1.0)])
    assert [run.time_to(value, "evaluations") for value in (5, 4, 3, 2, 1, 0.5)] == [1, 1, 10, 10, 30, np.inf]
    assert run.time_to(2, "solves") == 20


def test_runs_are_alike_where_every_improvement_is_the_same(record: MakeRecord) -> None:
    first = record([(1, 4.0), (10, 2.0)])
    assert first.is_like(record([(1, 4.0), (10, 2.0)], seed=1))
    assert not first.is_like(record([(1, 4.0), (11, 2.0)], seed=1))
    assert not first.is_like(record([(1, 4.0), (10, 2.0)], total=101, seed=1))


def test_runs_that_seconds_ended_are_alike_as_far_as_the_shorter_went(record: MakeRecord) -> None:
    first = record([(1, 4.0), (10, 2.0)], budget={"seconds": 1.0})
    assert first.is_like(record([(1, 4.0), (10, 2.0)], total=101, budget={"seconds": 1.0}))
    assert first.is_like(record([(1, 4.0)], total=9, budget={"seconds": 1.0}))
    assert record([(1, 4.0)], total=9, budget={"seconds": 1.0}).is_like(first)
    assert not first.is_like(record([(1, 4.0)], total=10, budget={"seconds": 1.0}))
    assert not first.is_like(record([(1, 4.0)], total=9, budget={"seconds": 1.0}, why_stopped="optimizer finished"))


def test_an_error_without_equilibrium_is_infinite_and_without_load_cases_there_is_none() -> None:
    errors = [{"role": "train", "relative_distance": 0.1}, {"role": "train", "relative_distance": 0.3}]
    assert mean_error(errors, "train") == pytest.approx(0.2)
    assert mean_error(errors, "test") is None
    assert mean_error([{"role": "test", "relative_distance": np.nan}], "test") == np.inf
