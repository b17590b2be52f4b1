"""Runs from start to end on a small scene of its own, and taken up again where they were cut short."""

import contextlib
import dataclasses
import json
import os
import signal
import sqlite3
import subprocess
import sys

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from springopt import journal, runner
from springopt.errors import NoEquilibrium, PluginError, RunFileError, UserError
from springopt.journal import Journal, journal_path
from springopt.optimizer import Optimizer
from springopt.random_search import RandomSearch
from springopt.runner import resume, solve
from springopt.scene import load_scene
from springopt.store import read, read_answers

SCENE = """
title = "Nine nodes, two load cases"
[lattice]
grid = [3, 3]
[reference]
kind = "spring"
stiffness = 5.0
[encoding]
kind = "real"
lower = 0.0
upper = 10.0
threshold = 0.5
[objective]
minimize = "least-squares"
[budget]
evaluations = 48
[optimizers.random-search]
batch = 16
[load_cases]
train = [
  { name = "pull", hold = "left", push = { on = "right", force = [0.3, 0.0] } },
  { name = "shear", hold = "left", push = { on = "right", force = [0.0, 0.1] } },
]
test = [{ name = "press", hold = "bottom", push = { on = "top", force = [0.0, -0.2] } }]
"""


@dataclasses.dataclass(frozen=True)
class Wanderer(Optimizer):
    """Asks for everything there is: values, two goals, gradients, Jacobians, the budget left; notes what it got."""

    name = "wanderer"
    needs = ("real", "jacobian")
    step: float = 0.5  #: of the way down the gradient

    def minimize(self, problem, rng):
        while problem.budget_left:
            points = problem.sample(rng, 5)
            point = points[np.argmin(problem.objectives(points)[:, 0])]
            try:
                _, gradient = problem.gradient(point)
                residuals, jacobian = problem.jacobian(point)
            except NoEquilibrium:
                continue
            newton = np.linalg.lstsq(jacobian, -residuals, rcond=None)[0]
            problem.note(slope=np.linalg.norm(gradient))
            problem.evaluate(np.clip([point - self.step * gradient, point + newton], problem.lower, problem.upper))


@dataclasses.dataclass(frozen=True)
class Failing(Optimizer):
    """Breaks after some answers."""

    name = "failing"
    answers: int = 10  #: before it breaks

    def minimize(self, problem, rng):
        problem.evaluate(problem.sample(rng, self.answers))
        raise ZeroDivisionError("a plugin's own mistake")


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "nine.toml"
    path.write_text(SCENE)
    return load_scene(path)


@pytest.fixture
def out(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    return folder / "run.h5"


@pytest.fixture
def wanderer(monkeypatch):
    monkeypatch.setattr(runner, "load_optimizer", {"wanderer": Wanderer, "random-search": RandomSearch}.__getitem__)
    return Wanderer()


def require_same(run, other):
    """Two runs that went through the same answers, however often one of them was cut short."""
    facts, others = run.timeless(), other.timeless()
    for name in facts:
        np.testing.assert_equal(others[name], facts[name], name)


def names(out):
    return sorted(path.name for path in out.parent.iterdir())


def press_ctrl_c_after(evaluations):
    """A progress callback that presses Ctrl-C once."""
    pressed = []

    def progress(done, total, best, seconds):
        if done >= evaluations and not pressed:
            pressed.append(True)
            os.kill(os.getpid(), signal.SIGINT)

    return progress


@pytest.fixture
def eager_progress(monkeypatch):
    """Progress at every solve, not only ten times a second."""
    monkeypatch.setattr("springopt.execution.PROGRESS_SECONDS", 0.0)


class TestSolve:
    def test_a_run_tells_everything_about_itself(self, scene):
        run = solve(scene, "random-search", seed=3)
        assert (run.scene, run.optimizer, run.options, run.seed) == ("nine", "random-search", {"batch": 16}, 3)
        assert (run.evaluations, run.solves, run.why_stopped, run.complete) == (48, 96, "budget", True)
        assert run.run is None
        assert run.objective == min(improvement.value for improvement in run.history)
        assert [(error["name"], error["role"]) for error in run.errors] == [
            ("pull", "train"),
            ("shear", "train"),
            ("press", "test"),
        ]
        assert sum(error["least_squares"] for error in run.errors[:2]) == pytest.approx(run.objective)
        assert run.stiffness.shape == run.point.shape == (20,)
        assert run.objective_of_present != run.objective
        assert 0.0 < run.seconds < 60.0
        assert json.loads(run.to_json())["errors"][0]["status"] == "converged"

    def test_the_seed_alone_decides(self, scene):
        require_same(solve(scene, "random-search"), solve(scene, RandomSearch(batch=16)))
        assert solve(scene, "random-search", seed=1).objective != solve(scene, "random-search", seed=2).objective

    def test_the_number_of_threads_changes_nothing(self, scene):
        require_same(solve(scene, "random-search"), solve(scene, "random-search", threads=3))

    def test_limits_given_replace_those_of_the_scene(self, scene):
        assert solve(scene, "random-search", solves=7).evaluations == 3
        assert solve(scene, "random-search", target=1e9).why_stopped == "target"
        timed = solve(scene, "random-search", seconds=0.05)
        assert timed.why_stopped == "budget"
        assert timed.seconds >= 0.05

    def test_options_given_replace_those_of_the_scene(self, scene):
        assert solve(scene, "random-search", options={"batch": "5"}).options == {"batch": 5}

    def test_an_optimizer_may_be_content_before_the_budget_is_spent(self, scene):
        content = type("Content", (RandomSearch,), {"minimize": lambda self, p, rng: p.evaluate(p.sample(rng, 2))})
        assert solve(scene, content()).why_stopped == "optimizer finished"

    def test_the_run_file_has_everything_and_stands_alone(self, scene, out):
        run = solve(scene, "random-search", out=out)
        assert names(out) == ["run.h5"]
        contents = read(out)
        require_same(run, contents.run)
        assert (contents.run.run, contents.run.seconds) == (str(out), run.seconds)
        assert [case.name for case in contents.cases] == ["pull", "shear", "press"]
        assert contents.positions.shape == contents.reference_positions.shape == (3, 9, 2)
        assert contents.lattice.spring_count == 20
        assert len(read_answers(out)) == 48

    def test_the_linear_algebra_of_an_optimizer_has_one_thread(self, scene, monkeypatch):
        threads = set()

        def minimize(self, problem, rng):
            threads.update(pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas")
            problem.evaluate(problem.sample(rng, 1))

        monkeypatch.setattr(RandomSearch, "minimize", minimize)
        solve(scene, "random-search")
        assert threads == {1}

    def test_progress_ends_with_the_whole_budget(self, scene, eager_progress):
        told = []
        run = solve(scene, "random-search", progress=lambda *progress: told.append(progress))
        assert [progress[:2] for progress in told] == [(16, 48), (32, 48), (48, 48)]
        assert told[-1][2] == run.objective

    def test_progress_is_told_about_ten_times_a_second_at_most(self, scene):
        told = []
        run = solve(scene, "random-search", seconds=0.25, progress=lambda *progress: told.append(progress))
        assert 1 <= len(told) <= 2 + run.seconds / 0.1
        assert told[0][1] is None


class TestRefusals:
    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            ({"optimizer": "random-serch"}, r"Did you mean 'random-search'"),
            ({"options": {"bacth": 3}}, r"Did you mean 'batch'"),
            ({"options": {"batch": 0}}, r"batch of random-search is at least 1"),
            ({"optimizer": RandomSearch(), "options": {"batch": 3}}, r"options are for an optimizer given by name"),
            ({"seed": -1}, r"the seed must be a whole number from 0 on, not -1"),
            ({"seed": 0.5}, r"the seed must be a whole number from 0 on, not 0.5"),
            ({"evaluations": 0}, r"evaluations must be a positive whole number"),
        ],
    )
    def test_bad_input_is_refused_before_anything_is_made(self, scene, out, arguments, sentence):
        with pytest.raises(UserError, match=sentence):
            solve(scene, **{"optimizer": "random-search", "out": out} | arguments)
        assert names(out) == []

    def test_an_optimizer_that_the_scene_does_not_suit(self, scene, out):
        bits = type("Bits", (RandomSearch,), {"needs": ("binary",)})
        with pytest.raises(UserError, match="needs a binary encoding, which this scene does not supply"):
            solve(scene, bits(), out=out)
        assert names(out) == []

    def test_an_output_that_exists_is_left_as_it_is(self, scene, out):
        out.write_text("mine")
        with pytest.raises(RunFileError, match="exists already, and nothing is overwritten"):
            solve(scene, "random-search", out=out)
        assert out.read_text() == "mine"

    def test_an_output_with_the_name_of_a_journal(self, scene, out):
        with pytest.raises(RunFileError, match="is the name of a journal"):
            solve(scene, "random-search", out=journal_path(out))
        assert names(out) == []

    def test_an_output_that_appears_while_the_scene_is_built_is_left_as_it_is(self, scene, out, monkeypatch):
        monkeypatch.setattr(type(scene), "build", lambda self, threads: out.write_text("mine"))
        with pytest.raises(RunFileError, match="exists already, and nothing is overwritten"):
            solve(scene, "random-search", out=out)
        assert names(out) == ["run.h5"]

    def test_options_for_an_optimizer_that_is_not_installed_are_told(self, tmp_path):
        path = tmp_path / "nine.toml"
        path.write_text(SCENE.replace("[optimizers.random-search]", "[optimizers.random-serch]"))
        with pytest.warns(RuntimeWarning, match=r"optimizer 'random-serch', .* Did you mean 'random-search'"):
            solve(path, "random-search", evaluations=2)
        path.write_text(SCENE.replace("[optimizers.random-search]", "[optimizers.xyz]"))
        solve(path, "random-search", evaluations=2)

    def test_an_output_that_appears_during_the_run_is_left_as_it_is(self, scene, out):
        with pytest.raises(RunFileError, match="is no run file of springopt"):
            solve(scene, "random-search", out=out, progress=lambda *told: out.write_text("mine"))
        assert out.read_text() == "mine"
        out.unlink()
        require_same(solve(scene, "random-search"), resume(out))

    def test_a_journal_that_exists_is_left_as_it_is(self, scene, out):
        journal_path(out).write_text("mine")
        with pytest.raises(RunFileError, match="a run was cut short; resume it, or choose another output"):
            solve(scene, "random-search", out=out)
        assert journal_path(out).read_text() == "mine"

    def test_a_folder_that_can_not_be_written_to_is_refused_before_the_run(self, scene, tmp_path):
        (tmp_path / "file").write_text("")
        told = []
        for out in (tmp_path / "gone" / "run.h5", tmp_path / "file" / "run.h5"):
            with pytest.raises(RunFileError, match=r"can't be written .*choose another output"):
                solve(scene, "random-search", out=out, progress=lambda *progress: told.append(progress))
        assert told == []

    def test_an_optimizer_that_asks_nothing(self, scene, out):
        idle = type("Idle", (RandomSearch,), {"minimize": lambda self, problem, rng: None})
        with pytest.raises(PluginError, match="ended without the value of a single candidate"):
            solve(scene, idle(), out=out)
        assert names(out) == []

    def test_a_plugin_that_breaks_keeps_its_answers_in_the_journal(self, scene, out):
        sentence = r"optimizer failing .* failed .ZeroDivisionError: a plugin's own mistake.; mend it, .*run.h5.journal"
        with pytest.raises(PluginError, match=sentence):
            solve(scene, Failing(), out=out)
        assert names(out) == ["run.h5.journal"]
        with Journal.open(journal_path(out)) as journal:
            assert len(list(journal.answers())) == 10

    def test_a_journal_that_can_not_be_written_ends_the_run_whatever_the_optimizer_swallows(
        self, scene, out, monkeypatch
    ):
        def full(path):
            connection = connect(path)
            connection.set_authorizer(
                lambda action, table, *_: (
                    sqlite3.SQLITE_DENY if (action, table) == (sqlite3.SQLITE_INSERT, "answers") else sqlite3.SQLITE_OK
                )
            )
            return connection

        def minimize(self, problem, rng):
            while problem.budget_left:
                with contextlib.suppress(Exception):
                    problem.evaluate(problem.sample(rng, 1))

        connect = journal._connect
        monkeypatch.setattr(journal, "_connect", full)
        monkeypatch.setattr(journal, "COMMIT_SECONDS", 0.0)
        monkeypatch.setattr(RandomSearch, "minimize", minimize)
        with pytest.raises(RunFileError, match=r"run.h5.journal (is damaged|can't be written)"):
            solve(scene, "random-search", out=out)


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
