"""Jobs of a benchmark: begun, taken up, left alone, refused, failed."""

import dataclasses
import json
import os
import signal
import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from springopt.benchmark import job as benchmark_job
from springopt.benchmark import run_job, run_jobs, same_result
from springopt.errors import NotServed, UserError
from springopt.journal import journal_path
from springopt.random_search import RandomSearch
from springopt.runner import solve
from springopt.scene import Scene
from springopt.store import read


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "results"


def files(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def broken(self, problem, rng):
    problem.evaluate(problem.sample(rng, 3))
    raise ZeroDivisionError("its own mistake")


def pressing_ctrl_c(self, problem, rng):
    problem.evaluate(problem.sample(rng, 3))
    os.kill(os.getpid(), signal.SIGINT)
    problem.evaluate(problem.sample(rng, 3))


class TestOneJob:
    def test_it_writes_the_run_that_solve_gives_whatever_ran_before_it(self, nine, job, folder, tmp_path):
        run_job(job(nine, "gauss-newton"), folder)
        outcome = run_job(job(nine, seed=4), folder)
        written = read(folder / "nine" / "random-search" / "seed4.h5")
        solve(nine, "random-search", seed=4, out=tmp_path / "solved.h5")
        assert same_result(written, read(tmp_path / "solved.h5"))
        run = written.run
        assert (outcome.state, outcome.objective, outcome.evaluations) == ("done", run.objective, 48)
        assert outcome.run == run.run
        assert outcome.took > 0
        assert files(folder) == ["nine/gauss-newton/seed0.h5", "nine/random-search/seed4.h5"]

    def test_limits_options_label_and_start_are_passed_on(self, nine, job, folder):
        given = {"limits": {"evaluations": 9}, "options": {"batch": 2}, "label": "pairs", "start": "random-search"}
        with pytest.warns(RuntimeWarning, match="the start random-search spent the whole budget"):
            run_job(job(nine, **given), folder)
        run = read(folder / "nine" / "pairs" / "seed0.h5").run
        assert (run.evaluations, run.options, run.start) == (9, {"batch": 2}, "random-search")

    def test_a_complete_run_file_is_left_alone(self, nine, job, folder):
        first = run_job(job(nine), folder)
        before = (folder / "nine" / "random-search" / "seed0.h5").stat().st_mtime_ns
        again = run_job(job(nine), folder)
        assert (folder / "nine" / "random-search" / "seed0.h5").stat().st_mtime_ns == before
        assert dataclasses.replace(again, took=first.took) == first

    def test_a_journal_that_was_left_beside_it_goes(self, nine, job, folder):
        run_job(job(nine), folder)
        for suffix in ("", "-wal", "-shm"):
            (folder / "nine" / "random-search" / f"seed0.h5.journal{suffix}").write_bytes(b"left")
        assert run_job(job(nine), folder).state == "done"
        assert files(folder) == ["nine/random-search/seed0.h5"]

    def test_a_scene_whose_title_changed_is_the_same(self, nine, job, folder):
        run_job(job(nine), folder)
        assert run_job(job(nine.model_copy(update={"title": "Another"})), folder).state == "done"

    def test_one_whose_test_load_cases_changed_is_another(self, nine, job, folder):
        run_job(job(nine), folder)
        changed = Scene.from_json(nine.to_json().replace("-0.2", "-0.3"))
        assert changed.digest() == nine.digest()
        outcome = run_job(job(changed), folder)
        assert "is a run with another scene; choose another folder." in outcome.sentence

    @pytest.mark.parametrize(
        ("change", "what"),
        [
            ({"limits": {"evaluations": 49}}, "budget"),
            ({"options": {"batch": 3}}, "options"),
            ({"start": "x"}, "start"),
        ],
    )
    def test_another_job_s_run_is_not_taken_for_this_one_s(self, nine, job, folder, change, what):
        run_job(job(nine), folder)
        outcome = run_job(job(nine, **change), folder)
        assert outcome.state == "failed"
        assert f"is a run with another {what}; choose another folder." in outcome.sentence
        assert files(folder) == ["nine/random-search/seed0.h5"]

    def test_a_run_that_was_cut_short_is_taken_up(self, nine, job, folder, monkeypatch):
        monkeypatch.setattr(RandomSearch, "minimize", pressing_ctrl_c)
        with pytest.raises(KeyboardInterrupt):
            run_job(job(nine), folder)
        assert not read(folder / "nine" / "random-search" / "seed0.h5").run.complete
        monkeypatch.undo()
        monkeypatch.setattr(RandomSearch, "minimize", lambda self, p, rng: [p.evaluate(p.sample(rng, 3)) for _ in "ab"])
        assert run_job(job(nine), folder).evaluations == 6
        assert read(folder / "nine" / "random-search" / "seed0.h5").run.complete

    def test_what_a_killed_run_left_is_taken_up_or_begun_anew(self, nine, job, folder, monkeypatch):
        journal = journal_path(folder / "nine" / "random-search" / "seed0.h5")
        monkeypatch.setattr(RandomSearch, "minimize", broken)
        run_job(job(nine), folder)
        assert journal.exists()
        (folder / "nine" / "random-search" / "seed1.h5.journal").write_bytes(b"")
        monkeypatch.undo()
        monkeypatch.setattr(RandomSearch, "minimize", lambda self, p, rng: p.evaluate(p.sample(rng, 3)))
        assert [run_job(job(nine, seed=seed), folder).evaluations for seed in (0, 1)] == [3, 3]
        assert files(folder) == ["nine/random-search/seed0.h5", "nine/random-search/seed1.h5"]

    def test_a_run_that_another_process_is_at_is_left_to_it(self, nine, job, folder, monkeypatch):
        second = []

        def minimize(self, problem, rng):
            problem.evaluate(problem.sample(rng, 3))
            second.append(run_job(job(nine), folder))
            problem.evaluate(problem.sample(rng, 3))

        monkeypatch.setattr(RandomSearch, "minimize", minimize)
        assert run_job(job(nine), folder).evaluations == 6
        assert second[0].state == "elsewhere"
        assert "seed0.h5.journal is in use by another process" in second[0].sentence
        assert files(folder) == ["nine/random-search/seed0.h5"]

    @pytest.mark.parametrize("is_laid_out", [True, False])
    def test_so_is_one_that_another_process_began_since(self, nine, job, folder, monkeypatch, is_laid_out):
        journal = journal_path(folder / "nine" / "random-search" / "seed0.h5")
        journal.parent.mkdir(parents=True)
        if is_laid_out:  # between this one's look and its own beginning
            monkeypatch.setattr("springopt.benchmark.job._was_begun", lambda out: False)
            monkeypatch.setattr("springopt.benchmark.job.require_unused", lambda journal: None)
            monkeypatch.setattr(Path, "unlink", lambda *_, **__: None)
        with closing(sqlite3.connect(journal)) as other:
            other.execute("PRAGMA locking_mode = EXCLUSIVE")
            other.execute("BEGIN IMMEDIATE")
            if is_laid_out:
                other.execute("CREATE TABLE answers (position)")
                other.execute("COMMIT")
            outcome = run_job(job(nine), folder)
        assert outcome.state == "elsewhere"
        assert journal.exists()

    def test_one_that_another_process_ended_since_is_done(self, nine, job, folder, monkeypatch):
        run_job(job(nine), folder)
        looks = iter([None])
        before = benchmark_job.ended_before
        monkeypatch.setattr(benchmark_job, "ended_before", lambda *job: next(looks, before(*job)))
        monkeypatch.setattr(benchmark_job, "_was_begun", lambda out: False)
        assert run_job(job(nine), folder).state == "done"

    def test_an_optimizer_that_can_t_serve_the_scene_leaves_the_reason_in_a_word(self, nine, job, folder, monkeypatch):
        monkeypatch.setattr(RandomSearch, "needs", ("binary",))
        outcome = run_job(job(nine), folder)
        assert (outcome.state, outcome.word) == ("refused", "binary")
        assert files(folder) == ["nine/random-search/refused.json"]
        written = json.loads((folder / "nine" / "random-search" / "refused.json").read_text())
        assert (written["word"], written["sentence"]) == ("binary", outcome.sentence)
        monkeypatch.undo()
        assert run_job(job(nine, seed=1), folder).word == "binary"

    @pytest.mark.parametrize("is_damaged", [True, False])
    def test_it_is_asked_again_by_another_build_or_where_the_reason_is_damaged(
        self, nine, job, folder, monkeypatch, is_damaged
    ):
        with monkeypatch.context() as patched:
            patched.setattr(RandomSearch, "needs", ("binary",))
            run_job(job(nine), folder)
        if is_damaged:
            (folder / "nine" / "random-search" / "refused.json").write_text("{")
        else:
            monkeypatch.setattr("springopt.benchmark.outcome.build_of", lambda optimizer: {"numpy": "9.9"})
        assert run_job(job(nine), folder).state == "done"
        assert files(folder) == ["nine/random-search/seed0.h5"]

    @pytest.mark.parametrize(
        ("error", "word"), [(NotServed("too large.", word="memory"), "memory"), (UserError("not this."), "unsuited")]
    )
    def test_so_does_one_that_says_it_before_its_first_question(self, nine, job, folder, monkeypatch, error, word):
        def minimize(self, problem, rng):
            raise error

        monkeypatch.setattr(RandomSearch, "minimize", minimize)
        outcome = run_job(job(nine), folder)
        assert (outcome.state, outcome.word, outcome.sentence) == ("refused", word, str(error))

    def test_a_plugin_that_breaks_leaves_a_sentence_and_is_tried_again(self, nine, job, folder, monkeypatch):
        monkeypatch.setattr(RandomSearch, "minimize", broken)
        outcome = run_job(job(nine), folder)
        assert outcome.state == "failed"
        written = json.loads((folder / "nine" / "random-search" / "seed0.failed.json").read_text())
        assert written == {"sentence": outcome.sentence}
        assert "failed (ZeroDivisionError: its own mistake)" in outcome.sentence
        monkeypatch.undo()
        monkeypatch.setattr(RandomSearch, "minimize", lambda self, p, rng: p.evaluate(p.sample(rng, 3)))
        assert run_job(job(nine), folder).state == "done"
        assert files(folder) == ["nine/random-search/seed0.h5"]

    def test_a_name_that_is_no_folder_is_refused(self, nine, job):
        with pytest.raises(UserError, match=r"the label 'a/b' of a job can't be the name of a folder"):
            job(nine, label="a/b")


def test_results_are_the_same_only_to_the_last_bit(nine, job, folder):
    jobs = [job(nine, seed=seed) for seed in (0, 1)]
    first, second = (read(Path(run_job(each, folder).run)) for each in jobs)
    assert same_result(first, first)
    assert not same_result(first, second)
    nudged = np.nextafter(first.run.point, 11.0)
    assert not same_result(first, dataclasses.replace(first, run=dataclasses.replace(first.run, point=nudged)))


class TestManyJobs:
    def test_outcomes_come_in_the_order_of_the_jobs(self, nine, bits, job, folder):
        jobs = [job(scene, seed=seed) for scene in (nine, bits) for seed in (1, 0)]
        outcomes = run_jobs(jobs, folder)
        assert [(each.scene, each.seed) for each in outcomes] == [("nine", 1), ("nine", 0), ("bits", 1), ("bits", 0)]
        assert {each.state for each in outcomes} == {"done"}

    def test_progress_goes_round_by_seed_and_tells_the_time_left(self, nine, bits, job, folder):
        told = []
        run_jobs([job(scene, seed=s) for scene in (nine, bits) for s in (0, 1)], folder, progress=told.append)
        assert [(each.ended, each.jobs) for each in told] == [(1, 4), (2, 4), (3, 4), (4, 4)]
        assert [(each.newest.seed, each.newest.scene) for each in told] == [
            (0, "nine"),
            (0, "bits"),
            (1, "nine"),
            (1, "bits"),
        ]
        assert all(each.seconds_left > 0 for each in told[:3])
        assert told[3].seconds_left == 0

    def test_a_second_call_does_what_is_new_alone(self, nine, job, folder):
        run_jobs([job(nine)], folder)
        before = (folder / "nine" / "random-search" / "seed0.h5").stat().st_mtime_ns
        outcomes = run_jobs([job(nine, seed=seed) for seed in range(3)], folder)
        assert [each.state for each in outcomes] == ["done"] * 3
        assert (folder / "nine" / "random-search" / "seed0.h5").stat().st_mtime_ns == before

    @pytest.mark.parametrize(
        ("slip", "sentence"),
        [
            ({"optimizer": "random-serch"}, "Did you mean 'random-search'"),
            ({"options": {"bacth": 3}}, "random-search has no option 'bacth'"),
            ({"limits": {"solves": 0}}, "solves must be a positive whole number"),
            ({"start": "analitic"}, "Did you mean 'analytic'"),
        ],
    )
    def test_slips_are_told_before_any_work(self, nine, job, folder, slip, sentence):
        with pytest.raises(UserError, match=sentence):
            run_jobs([job(nine), job(nine, seed=1, **slip)], folder)
        assert not folder.exists()

    def test_two_jobs_with_one_place_are_refused_before_any_work(self, nine, job, folder):
        with pytest.raises(UserError, match=r"two jobs would write nine/random-search/seed0.h5"):
            run_jobs([job(nine), job(nine, options={"batch": 3})], folder)
        assert not folder.exists()
