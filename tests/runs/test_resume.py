"""Runs that were interrupted or killed, and taken up again where they were cut short."""

import contextlib
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from nine_nodes import names, press_ctrl_c_after, require_same

from springopt import runner
from springopt.errors import RunFileError
from springopt.journal import Journal, journal_path
from springopt.random_search import RandomSearch
from springopt.runner import resume, solve
from springopt.store import read, read_answers


class TestInterrupted:
    def test_ctrl_c_leaves_a_run_file_that_is_complete_up_to_the_last_answer(self, scene, out, eager_progress):
        run = solve(scene, "random-search", out=out, progress=press_ctrl_c_after(16))
        assert (run.why_stopped, run.complete, run.run) == ("interrupted", False, str(out))
        assert names(out) == ["run.h5"]
        assert len(read_answers(out)) == run.evaluations == 32
        require_same(run, read(out).run)

    @pytest.mark.parametrize("taken", ["run.h5", "run.h5.journal"])
    def test_resumed_it_ends_as_if_it_had_never_stopped(self, scene, out, eager_progress, taken):
        solve(scene, "random-search", out=out, progress=press_ctrl_c_after(16))
        resumed = resume(out.with_name(taken))
        require_same(solve(scene, "random-search"), resumed)
        assert resumed.run == str(out)
        assert names(out) == ["run.h5"]
        require_same(resumed, read(out).run)

    def test_every_kind_of_answer_is_resumed_and_time_adds_up(self, scene, out, eager_progress, wanderer):
        whole = solve(scene, wanderer, evaluations=200)
        run = solve(scene, wanderer, evaluations=200, out=out, progress=press_ctrl_c_after(40))
        assert not run.complete
        for evaluations in (70, 100):
            last, run = run, resume(out, progress=press_ctrl_c_after(evaluations))
            assert run.evaluations > last.evaluations
            assert run.seconds > last.seconds
            assert run.processor_seconds > last.processor_seconds
        require_same(whole, resume(out))
        assert whole.notes

    def test_a_complete_run_file_keeps_no_payloads(self, scene, out, eager_progress, wanderer):
        solve(scene, wanderer, evaluations=200, out=out, progress=press_ctrl_c_after(100))
        assert any(answer.payload for answer in read_answers(out))
        resume(out)
        answers = read_answers(out)
        assert {answer.kind for answer in answers} > {"value", "gradient"}
        assert not any(answer.payload or answer.checksum for answer in answers)

    def test_a_run_limited_by_time_goes_on_with_the_time_that_is_left(self, scene, out, eager_progress, wanderer):
        run = solve(scene, wanderer, seconds=0.3, out=out, progress=press_ctrl_c_after(20))
        assert run.seconds < 0.3
        resumed = resume(out)
        assert resumed.why_stopped == "budget"
        assert 0.3 <= resumed.seconds < 3.0
        assert resumed.history[: len(run.history)] == run.history

    def test_ctrl_c_before_the_first_answer_leaves_nothing(self, scene, out, monkeypatch):
        def interrupted(self, problem, rng):
            os.kill(os.getpid(), signal.SIGINT)
            problem.evaluate(problem.sample(rng, 1))

        monkeypatch.setattr(RandomSearch, "minimize", interrupted)
        with pytest.raises(KeyboardInterrupt):
            solve(scene, "random-search", out=out)
        assert names(out) == []

    def test_without_a_run_file_the_run_so_far_is_returned(self, scene, eager_progress):
        run = solve(scene, "random-search", progress=press_ctrl_c_after(16))
        assert (run.why_stopped, run.evaluations, run.run) == ("interrupted", 32, None)


class TestResume:
    def test_a_complete_run_is_only_read(self, scene, out):
        run = solve(scene, "random-search", out=out)
        before = out.read_bytes()
        require_same(run, resume(out))
        assert out.read_bytes() == before
        assert names(out) == ["run.h5"]

    @pytest.fixture
    def cut_short(self, scene, out, eager_progress):
        """An interrupted run, and beside it the journal as if the resumed run had been killed."""
        solve(scene, "random-search", out=out, progress=press_ctrl_c_after(16))
        Journal.create(journal_path(out), read(out).order, read_answers(out)).close()
        return out

    def test_of_run_file_and_journal_the_journal_is_the_newer(self, scene, cut_short):
        with Journal.open(journal_path(cut_short)) as journal:
            assert len(list(journal.answers())) == 32
        require_same(solve(scene, "random-search"), resume(cut_short))
        assert names(cut_short) == ["run.h5"]

    def test_a_journal_that_was_killed_before_it_began_counts_for_nothing(self, scene, cut_short):
        journal_path(cut_short).write_bytes(b"")
        require_same(solve(scene, "random-search"), resume(cut_short))
        assert names(cut_short) == ["run.h5"]

    def test_another_run_file_beside_a_journal_is_not_overwritten(self, scene, cut_short):
        cut_short.unlink()
        solve(scene, "random-search", seed=9, out=cut_short.with_name("other.h5"))
        cut_short.with_name("other.h5").rename(cut_short)
        with pytest.raises(RunFileError, match="holds another run than its journal; move one of the two away"):
            resume(cut_short)
        assert read(cut_short).run.seed == 9
        assert journal_path(cut_short).exists()

    def test_a_foreign_file_beside_a_journal_is_not_overwritten(self, cut_short):
        cut_short.write_text("mine")
        with pytest.raises(RunFileError, match="is no run file of springopt"):
            resume(cut_short)
        assert cut_short.read_text() == "mine"

    def test_another_build_or_processor_is_refused_in_one_sentence(self, cut_short, monkeypatch):
        here = runner.this_origin(RandomSearch)
        monkeypatch.setattr("springopt.origin.this_origin", lambda *kinds: here | {"processor": "another"})
        for _ in ("from the journal", "from the run file"):
            with pytest.raises(RunFileError, match=r"here it is another, .*resume it there, or start a new run\."):
                resume(cut_short)
            journal_path(cut_short).unlink(missing_ok=True)

    @pytest.mark.parametrize("swallowed", [(), (Exception,)])
    def test_an_optimizer_that_is_not_deterministic_is_found_out(self, cut_short, monkeypatch, swallowed):
        def minimize(self, problem, rng):
            while problem.budget_left:
                with contextlib.suppress(*swallowed):
                    problem.evaluate(problem.sample(np.random.default_rng(), 16))

        monkeypatch.setattr(RandomSearch, "minimize", minimize)
        with pytest.raises(RunFileError, match="random-search asked something else than in the recorded run"):
            resume(cut_short)
        assert len(names(cut_short)) == 2

    @pytest.mark.parametrize("content", [None, b"", b"notes"])
    def test_what_is_no_run_is_refused_in_one_sentence(self, out, content):
        if content is not None:
            out.write_bytes(content)
        with pytest.raises(RunFileError, match=r"there is no run file|is no run file of springopt"):
            resume(out)


def killed_at(evaluations, call):
    """Runs a call in a process of its own, and kills it when its progress has come so far."""
    code = f"from springopt.runner import resume, solve\n{call}progress=lambda *told: print(*told, flush=True))"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        for told in process.stdout:
            if int(told.split()[0]) > evaluations:
                break
        process.kill()
    assert process.returncode == -signal.SIGKILL


def test_a_run_killed_twice_ends_as_the_one_that_was_not(scene, out, tmp_path):
    """SIGKILL at some moment, then again while it is resumed: the answers before are all there, to the bit."""
    kept = [0]
    nine, evaluations = str(tmp_path / "nine.toml"), 24_000
    order = f"solve({nine!r}, 'random-search', evaluations={evaluations}, out={str(out)!r}, "
    for call in (order, f"resume({str(out)!r}, "):
        killed_at(kept[-1] + 4_000, call)
        assert "run.h5" not in names(out)
        with Journal.open(journal_path(out)) as journal:
            kept.append(len(list(journal.answers())))
    assert 0 < kept[1] < kept[2] < evaluations
    resumed = resume(journal_path(out))
    require_same(solve(scene, "random-search", evaluations=evaluations), resumed)
    assert names(out) == ["run.h5"]
