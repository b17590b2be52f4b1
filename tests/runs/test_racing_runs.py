"""Runs whose candidates are raced, and runs whose selections may be loose: cut short, taken up again, shown."""

import json

import numpy as np
import pytest
from nine_nodes import press_ctrl_c_after, require_same

from springopt.cli.main import run as springopt
from springopt.errors import UserError
from springopt.journal import Journal, journal_path
from springopt.runner import resume, solve
from springopt.store import read, read_answers


@pytest.mark.parametrize("loosest", [None, 1e-3])
class TestRaced:
    @pytest.mark.parametrize("kept", [1, 16, 23, 40])
    def test_killed_anywhere_a_run_goes_on_as_if_it_had_never_stopped(self, scene, out, eager_progress, loosest, kept):
        whole = solve(scene, "random-search", evaluations=96, loosest_tolerance=loosest)
        solve(
            scene,
            "random-search",
            evaluations=96,
            loosest_tolerance=loosest,
            out=out,
            progress=press_ctrl_c_after(64),
        )
        order, answers = read(out).order, read_answers(out)
        assert any(answer.value is None for answer in answers)
        out.unlink()
        Journal.create(journal_path(out), order, answers[:kept]).close()
        require_same(whole, resume(out))

    def test_complete_it_is_read_and_shown_without_payloads(self, scene, out, loosest, capsys):
        run = solve(scene, "random-search", evaluations=96, loosest_tolerance=loosest, out=out)
        answers = read_answers(out)
        assert "raced" in {answer.kind for answer in answers}
        assert not any(answer.payload for answer in answers)
        assert min(answer.value for answer in answers if answer.value is not None) == run.objective
        require_same(run, read(out).run)
        require_same(run, resume(out))
        assert springopt(["show", str(out)]) == 0
        assert ("selections by tolerances up to 0.001" in capsys.readouterr().out) == (loosest is not None)


def test_the_run_tells_of_its_loose_selections(scene, out):
    run = solve(scene, "random-search", evaluations=96, loosest_tolerance=1e-3, out=out)
    loose = run.loose_selections
    assert loose.loosest_tolerance == 1e-3
    assert 6 >= loose.made >= loose.compared >= 2
    assert json.loads(run.to_json())["loose_selections"] == loose._asdict()
    assert read(out).order.loosest_tolerance == 1e-3
    assert solve(scene, "random-search").loose_selections is None


@pytest.mark.parametrize("tolerance", [0.0, -1e-3, 1e-8, 0.1, np.nan])
def test_a_tolerance_that_serves_nobody_is_refused(scene, tolerance):
    with pytest.raises(UserError, match=r"loosest_tolerance lies above the scene's own 1e-08 and is at most 0\.01"):
        solve(scene, "random-search", loosest_tolerance=tolerance)


def test_the_command_line_takes_it(scene, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    arguments = ["solve", "nine.toml", "--optimizer", "random-search", "--loosest-tolerance", "1e-3", "--json"]
    assert springopt(arguments) == 0
    assert json.loads(capsys.readouterr().out)["loose_selections"]["loosest_tolerance"] == 1e-3
