"""Every installed optimizer on a scene of each group: it ends in a run, or says in a word why it can't serve it."""

import pytest

from springopt.benchmark import run_jobs
from springopt.benchmark.suite import QUICK_SCENES, choose_optimizers, choose_scenes, make_jobs
from springopt.scene import bundled_scenes


def test_the_quick_suite_has_a_scene_of_each_group():
    heads = bundled_scenes()
    assert {heads[name].group for name in QUICK_SCENES} == {head.group for head in heads.values()}


@pytest.mark.slow
@pytest.mark.parametrize("scene", QUICK_SCENES)
def test_every_optimizer_ends_in_a_run_or_a_word(scene, tmp_path):
    outcomes = run_jobs(make_jobs(choose_scenes([scene]), choose_optimizers([]), 1, {"evaluations": 20}), tmp_path)
    assert [(each.label, each.sentence) for each in outcomes if each.state == "failed"] == []
    assert all(" " not in each.word for each in outcomes if each.state == "refused")
