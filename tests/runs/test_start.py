"""Runs that begin at a first guess: what another optimizer finds first, or the best point of an earlier run."""

import dataclasses

import numpy as np
import pytest
from nine_nodes import SCENE, press_ctrl_c_after, require_same

from springopt import runner
from springopt.errors import PluginError, RunFileError, UserError
from springopt.optimizer import Optimizer
from springopt.random_search import RandomSearch
from springopt.runner import resume, solve
from springopt.store import read, read_answers


@dataclasses.dataclass(frozen=True)
class Middle(Optimizer):
    """Draws a number, as starts may, and asks for one point."""

    name = "middle"
    share: float = 0.5  #: of the box

    def minimize(self, problem, rng):
        problem.note(drawn=rng.random())
        problem.evaluate([problem.lower + self.share * (problem.upper - problem.lower)])


@pytest.fixture
def out(tmp_path, monkeypatch):
    monkeypatch.setattr(runner, "load_optimizer", {"middle": Middle, "random-search": RandomSearch}.__getitem__)
    monkeypatch.setattr("springopt.start.load_optimizer", runner.load_optimizer)
    return tmp_path / "run.h5"


def asked(path):
    return [answer.question for answer in read_answers(path)]


def test_the_first_point_that_is_drawn_is_the_start_and_the_others_are_as_without(scene, out):
    solve(scene, "random-search", out=out)
    solve(scene, "random-search", start="middle", out=out.with_name("from.h5"))
    plain, begun = asked(out), asked(out.with_name("from.h5"))
    assert len(plain) == len(begun) == 48
    assert begun[0] == begun[1] != plain[0]
    assert begun[2:] == plain[1:47]


def test_a_run_says_where_it_began(scene, out):
    run = solve(scene, RandomSearch(), start=Middle(share=0.25), out=out)
    assert (run.start, run.method) == ("middle", "random-search from middle")
    contents = read(out)
    assert (contents.run.start, contents.order.start) == ("middle", {"name": "middle", "options": {"share": 0.25}})
    assert solve(scene, "random-search").start is None


def test_it_is_never_worse_than_its_start(scene, out):
    begun = solve(scene, "random-search", start="middle", evaluations=5)
    assert begun.objective <= 1e-12
    assert begun.history[0].evaluations == 1


def test_the_best_point_of_a_run_is_asked_once_more(scene, out):
    first = solve(scene, "random-search", out=out)
    other = out.with_name("other.h5")
    run = solve(scene, "random-search", start=out, seed=1, evaluations=10, out=other)
    assert run.start == str(out)
    assert (run.history[0].evaluations, run.history[0].value) == (1, first.objective)
    assert len(asked(other)) == 10
    np.testing.assert_array_equal(read(other).order.start["options"]["point"], first.point)


def test_an_interrupted_run_goes_on_from_its_start(scene, out, eager_progress):
    for number, start in enumerate(["middle", str(out)]):
        path = out.with_name(f"{number}.h5")
        if start != "middle":
            solve(scene, "random-search", out=out)
        cut = solve(scene, "random-search", start=start, out=path, progress=press_ctrl_c_after(2))
        assert (cut.complete, cut.start) == (False, start)
        resumed = resume(path)
        require_same(solve(scene, "random-search", start=start), resumed)
        assert resumed.start == start


def test_an_old_order_without_a_start_is_read(scene, out):
    from springopt.run import Order

    text = '{"scene": "", "optimizer": "x", "options": {}, "seed": 0, "budget": {}, "origin": {}}'
    assert Order.from_json(text).start is None


class TestRefusals:
    def test_a_start_that_spends_the_whole_budget_is_told(self, scene, out):
        with pytest.warns(RuntimeWarning, match="start random-search spent the whole budget, and middle never began"):
            run = solve(scene, "middle", start="random-search")
        assert (run.evaluations, run.why_stopped) == (48, "budget")

    def test_a_start_that_reaches_the_target_is_all_that_is_needed(self, scene, out):
        run = solve(scene, "random-search", start="middle", target=1e-6)
        assert (run.evaluations, run.why_stopped) == (1, "target")

    def test_a_start_that_does_not_suit_the_scene(self, scene, out):
        bits = type("Bits", (Middle,), {"needs": ("binary",)})()
        with pytest.raises(UserError, match="middle needs a binary encoding, which this scene does not supply"):
            solve(scene, "random-search", start=bits, out=out)

    def test_a_start_that_breaks_is_blamed_by_name(self, scene, out):
        broken = type("Broken", (Middle,), {"minimize": lambda self, problem, rng: 1 / 0})()
        with pytest.raises(PluginError, match=r"optimizer middle .* failed \(ZeroDivisionError"):
            solve(scene, "random-search", start=broken)

    def test_a_run_file_that_is_not_there(self, scene, out):
        with pytest.raises(RunFileError, match=r"there is no run file gone\.h5"):
            solve(scene, "random-search", start="gone.h5")

    @pytest.mark.parametrize(
        ("encoding", "sentence"),
        [
            ('kind = "homogeneous"\nupper = 10.0', "has 20 numbers, but a point of this scene has 1"),
            ('kind = "real"\nupper = 0.1', r"is [\d.]+, and in this scene it must be in \[0, 0.1\]"),
            ('kind = "binary"\nstiffness = 5.0', r"is [\d.]+, and in this scene it must be 0 or 1"),
        ],
    )
    def test_the_best_point_of_a_scene_with_another_encoding(self, scene, out, tmp_path, encoding, sentence):
        solve(scene, "random-search", out=out)
        path = tmp_path / "other.toml"
        path.write_text(SCENE.replace('kind = "real"\nlower = 0.0\nupper = 10.0\nthreshold = 0.5', encoding))
        with pytest.raises(UserError, match=sentence):
            solve(path, "random-search", start=out, out=tmp_path / "new.h5")
        assert not (tmp_path / "new.h5.journal").exists()
