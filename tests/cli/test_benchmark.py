"""`springopt benchmark`: what it runs, what it says, and what it refuses before any work."""

import json
import os
import signal
from pathlib import Path

import pytest

from springopt.cli.bar import say_left
from springopt.journal import Journal
from springopt.random_search import RandomSearch
from springopt.store import read

SCENE = (Path(__file__).parents[1] / "data" / "nine-nodes.toml").read_text()
TWO = ("--optimizers", "random-search,maciel-angles", "--seeds", "2", "--out", "results")


@pytest.fixture
def benchmark(springopt, tmp_path):
    """The command, beside a scene nine.toml."""
    (tmp_path / "nine.toml").write_text(SCENE)
    return lambda *arguments: springopt("benchmark", *arguments)


def test_one_run_file_for_each_scene_optimizer_and_seed(benchmark, tmp_path):
    answer = benchmark("--scenes", "nine.toml", "--scenes", "paper-stiffness-2d", "--evaluations", "3", *TWO)
    assert answer.code == 0
    assert len(list(tmp_path.glob("results/*/*/seed[01].h5"))) == 8
    assert [line.split() for line in answer.out.splitlines() if line.strip().startswith(("random", "maciel"))] == [
        ["random-search", "2", "2"],
        ["maciel-angles", "2", "2"],
    ]
    assert answer.out.splitlines()[-1] == "Compare: springopt compare results"
    assert answer.err == ""


def test_a_reason_in_a_word_where_an_optimizer_can_t_serve_a_scene(benchmark):
    options = ("--evaluations", "2", *TWO)
    answer = benchmark("--scenes", "paper-topology-2d-isotropic", *options)
    assert ["maciel-angles", "real"] in [line.split() for line in answer.out.splitlines()]
    outcomes = json.loads(benchmark("--scenes", "paper-topology-2d-isotropic", *options, "--json").out)
    assert [outcome["state"] for outcome in outcomes] == ["done", "done", "refused", "refused"]
    assert outcomes[2]["word"] == "real"
    assert outcomes[2]["sentence"].startswith("maciel-angles needs a real encoding")


def test_groups_and_patterns_of_files(benchmark, tmp_path):
    (tmp_path / "ten.toml").write_text(SCENE)
    command = ("--scenes", "*.toml,recovered,nine.toml", "--optimizers", "random-search", "--seeds", "1")
    assert "there is no scene and no group 'recovered'" in benchmark(*command, "--out", "a").err
    answer = benchmark(
        *(word.replace("recovered", "paper") for word in command), "--evaluations", "1", "--out", "b", "--json"
    )
    scenes = [outcome["scene"] for outcome in json.loads(answer.out)]
    assert scenes[:2] == ["nine", "ten"]
    assert {"paper-fem-2d", "paper-topology-3d"} < set(scenes)


@pytest.mark.parametrize("change", [("evaluations = 48", "evaluations = 49"), ("batch = 16", "batch = 8")])
def test_two_scenes_of_one_name_are_refused_whatever_they_differ_in(benchmark, tmp_path, change):
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "nine.toml").write_text(SCENE.replace(*change))
    answer = benchmark("--scenes", "nine.toml,more/nine.toml", *TWO)
    assert answer.code == 2
    assert "two of these scenes are called nine, among them more/nine.toml; rename one." in answer.err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--scenes", "paper-fem-3d"), "Did you mean 'paper-fem-2d'"),
        (("--scenes", "gone.toml"), "scene gone.toml can't be read"),
        (("--optimizers", "paper-gaa"), "Did you mean 'paper-ga'"),
        (("--scenes", ""), "--scenes names nothing"),
        (("--optimizers", ","), "--optimizers names nothing"),
        (("--dask", "", "--evaluations", "1"), "no Dask scheduler answers at '' (missing port number"),
        (
            ("--dask", "bogus://x", "--evaluations", "1"),
            "no Dask scheduler answers at 'bogus://x' (unknown address scheme",
        ),
        (("--evaluations", "0"), "evaluations must be a positive whole number"),
        (("--seeds", "0"), "Invalid value for '--seeds'"),
    ],
)
def test_slips_are_told_before_any_work(benchmark, tmp_path, arguments, sentence):
    answer = benchmark("--out", "results", *arguments)
    assert answer.code == 2
    assert sentence in answer.err
    assert not (tmp_path / "results").exists()


def test_a_slip_that_only_a_job_can_tell_leaves_no_note_of_the_request(benchmark, tmp_path):
    (tmp_path / "nine.toml").write_text(SCENE.replace("batch = 16", 'batch = "many"'))
    answer = benchmark("--scenes", "nine.toml", *TWO)
    assert answer.code == 2
    assert not (tmp_path / "results").exists()


def test_on_a_terminal_a_bar_counts_the_runs_and_tells_the_time_left(benchmark, monkeypatch):
    monkeypatch.setenv("TTY_COMPATIBLE", "1")  # rich takes standard error for a terminal
    answer = benchmark("--scenes", "nine.toml", *TWO)
    assert answer.code == 0
    assert "4/4" in answer.err
    assert "about 0 s left maciel-angles on nine" in answer.err


@pytest.mark.parametrize(
    ("seconds", "said"), [(42.4, "about 42 s left"), (600, "about 10 min left"), (9000, "about 2.5 h left")]
)
def test_the_time_left_is_told_as_people_would(seconds, said, monkeypatch):
    monkeypatch.setattr("time.monotonic", lambda: 1000.0)
    assert say_left(1000.0 + seconds) == said


def test_a_folder_that_can_not_be_made_is_refused(benchmark):
    answer = benchmark("--scenes", "nine.toml", *TWO[:-1], "nine.toml/results")
    assert answer.code == 2
    assert "can't be written (Not a directory); choose another folder." in answer.err


def test_a_folder_of_other_things_is_refused(benchmark, tmp_path):
    assert "nine.toml is a file and no folder" in benchmark("--out", "nine.toml").err
    assert "holds other things than results of a benchmark" in benchmark("--out", ".").err


class TestTheSameFolder:
    @pytest.fixture
    def once(self, benchmark, tmp_path):
        assert benchmark("--scenes", "nine.toml", *TWO).code == 0
        return tmp_path / "results"

    def test_a_second_call_adds_what_is_new(self, benchmark, once, tmp_path):
        (tmp_path / "ten.toml").write_text(SCENE)
        before = {path: path.stat().st_mtime_ns for path in once.glob("*/*/*.h5")}
        more = ("--optimizers", "random-search,van-gelder", "--seeds", "3", "--out", "results")
        assert benchmark("--scenes", "nine.toml,ten.toml", *more).code == 0
        assert {path: path.stat().st_mtime_ns for path in before} == before
        assert len(list(once.glob("*/*/*.h5"))) == 4 + 1 + 3 + 6
        written = json.loads((once / "benchmark.json").read_text())
        assert [request["seeds"] for request in written["requests"]] == [2, 3]
        assert written["scenes"]["nine"]["budget"] == {"evaluations": 48}
        assert written["requests"][0]["versions"]["random-search"]["numpy"]

    def test_the_same_call_is_noted_once(self, benchmark, once):
        benchmark("--scenes", "nine.toml", *TWO)
        assert len(json.loads((once / "benchmark.json").read_text())["requests"]) == 1

    def test_another_budget_is_refused(self, benchmark, once):
        answer = benchmark("--scenes", "nine.toml", "--evaluations", "30", *TWO)
        assert answer.code == 2
        assert "runs on nine with a budget of 48 evaluations, and now it is 30 evaluations" in answer.err

    @pytest.mark.parametrize("force", ["0.3", "-0.2"])  # of a training and of a test load case
    def test_a_scene_that_was_changed_is_refused(self, benchmark, once, tmp_path, force):
        (tmp_path / "nine.toml").write_text(SCENE.replace(force, "0.4"))
        answer = benchmark("--scenes", "nine.toml", *TWO)
        assert answer.code == 2
        assert "results has runs on another state of scene nine; choose another folder." in answer.err

    @pytest.mark.filterwarnings("always::RuntimeWarning")
    def test_another_build_is_told(self, benchmark, once, monkeypatch):
        monkeypatch.setattr("springopt.benchmark.request.this_origin", lambda optimizer: {"numpy": "9.9"})
        answer = benchmark("--scenes", "nine.toml", *TWO)
        assert answer.code == 0
        assert "Warning: results has runs of another build" in answer.err

    def test_of_a_scene_without_runs_everything_may_change(self, benchmark, once, tmp_path):
        place = once / "nine" / "random-search"
        for path in once.glob("*/*/*.h5"):
            path.unlink()
        assert benchmark("--scenes", "nine.toml", "--evaluations", "3", *TWO).code == 0
        assert read(place / "seed0.h5").run.evaluations == 3
        assert json.loads((once / "benchmark.json").read_text())["scenes"]["nine"]["budget"] == {"evaluations": 3}

    @pytest.mark.parametrize(
        ("text", "why"),
        [
            ("{", "JSONDecodeError"),
            ("[]", "TypeError"),
            ('{"format": 1, "scenes": {}}', "KeyError: 'requests'"),
            ('{"format": 1, "scenes": [], "requests": []}', "AttributeError"),
            ('{"format": 1, "scenes": {"nine": {}}, "requests": []}', "KeyError: 'digest'"),
            (
                '{"format": 1, "scenes": {"nine": {"digest": "", "budget": {"solves": "x"}}}, "requests": []}',
                "ValueError",
            ),
            ('{"format": 1, "scenes": {}, "requests": [{}]}', "KeyError: 'versions'"),
            ('{"format": 1, "scenes": {}, "requests": [{"versions": []}]}', "AttributeError"),
        ],
    )
    def test_a_damaged_note_is_refused(self, benchmark, once, text, why):
        (once / "benchmark.json").write_text(text)
        answer = benchmark("--scenes", "nine.toml", *TWO)
        assert answer.code == 2
        assert f"benchmark.json can't be read ({why}" in answer.err


def test_ctrl_c_ends_it_and_the_same_command_goes_on(benchmark, tmp_path, monkeypatch):
    def minimize(self, problem, rng):
        problem.evaluate(problem.sample(rng, 3))
        os.kill(os.getpid(), signal.SIGINT)
        problem.evaluate(problem.sample(rng, 3))

    monkeypatch.setattr(RandomSearch, "minimize", minimize)
    answer = benchmark("--scenes", "nine.toml", *TWO)
    assert answer.code == 130
    assert "What ended is in results; the same command goes on." in answer.err
    monkeypatch.setattr(RandomSearch, "minimize", lambda self, p, rng: [p.evaluate(p.sample(rng, 3)) for _ in "ab"])
    assert benchmark("--scenes", "nine.toml", *TWO).code == 0
    assert read(tmp_path / "results" / "nine" / "random-search" / "seed0.h5").run.evaluations == 6


def test_ctrl_c_with_a_cluster_tells_what_is_lost(benchmark, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("springopt.benchmark.execute.run_jobs", interrupted)
    answer = benchmark("--scenes", "nine.toml", "--dask", "tcp://127.0.0.1:1", *TWO)
    assert answer.code == 130
    said = "What ended is in results; the same command goes on, and what was under way on the cluster starts anew."
    assert said in answer.err


def test_runs_that_another_process_is_at_are_told_and_are_no_failure(benchmark, tmp_path, monkeypatch):
    def minimize(self, problem, rng):
        problem.best_of(problem.sample(rng, 3), 1)  # as its own first question
        raise ZeroDivisionError("its own mistake")

    with monkeypatch.context() as patched:
        patched.setattr(RandomSearch, "minimize", minimize)
        assert benchmark("--scenes", "nine.toml", *TWO).code == 1
    with Journal.open(tmp_path / "results" / "nine" / "random-search" / "seed0.h5.journal"):
        answer = benchmark("--scenes", "nine.toml", *TWO)
    assert answer.code == 0
    assert "Another process is at 1 of these runs; the same command goes on with what it leaves." in answer.out
    assert ["random-search", "1", "of", "2"] in [line.split() for line in answer.out.splitlines()]


def test_runs_that_fail_are_told_and_the_others_go_on(benchmark, monkeypatch):
    def minimize(self, problem, rng):
        raise ZeroDivisionError("its own mistake")

    monkeypatch.setattr(RandomSearch, "minimize", minimize)
    answer = benchmark("--scenes", "nine.toml", *TWO)
    assert answer.code == 1
    assert "random-search on nine, seed 0, failed: optimizer random-search" in answer.out
    assert ["random-search", "0", "of", "2"] in [line.split() for line in answer.out.splitlines()]
    assert ["maciel-angles", "2"] in [line.split() for line in answer.out.splitlines()]
