"""Runs from start to end on a small scene of its own."""

import contextlib
import dataclasses
import json
import sqlite3

import pytest
from nine_nodes import SCENE, names, require_same
from threadpoolctl import threadpool_info

from springopt import journal
from springopt.errors import PluginError, RunFileError, UserError
from springopt.journal import Journal, journal_path
from springopt.optimizer import Optimizer
from springopt.random_search import RandomSearch
from springopt.runner import resume, solve
from springopt.store import read, read_answers


@dataclasses.dataclass(frozen=True)
class Failing(Optimizer):
    """Breaks after some answers."""

    name = "failing"
    answers: int = 10  #: before it breaks

    def minimize(self, problem, rng):
        problem.evaluate(problem.sample(rng, self.answers))
        raise ZeroDivisionError("a plugin's own mistake")


class TestSolve:
    def test_a_run_tells_everything_about_itself(self, scene):
        run = solve(scene, "random-search", seed=3)
        assert (run.scene, run.optimizer, run.options, run.seed) == ("nine", "random-search", {"batch": 16}, 3)
        assert (run.evaluations, run.why_stopped, run.complete) == (48, "budget", True)
        assert 48 < run.solves < 96  # of two load cases the second was solved where the first one left a doubt
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

    def test_a_setup_of_another_scene(self, scene):
        setup = scene.model_copy(update={"name": "other"}).build()
        with pytest.raises(UserError, match="the setup is of scene other, not of nine"):
            solve(scene, "random-search", setup=setup)

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
