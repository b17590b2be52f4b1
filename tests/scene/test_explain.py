"""What a scene's solve is explained by, and that it tells the truth."""

import numpy as np
import pytest

from springopt.scene import load_scene
from springopt.scene.explain import explain

BIG = """
title = "Big"
extends = "paper-topology-3d"
kinematics = "{kinematics}"
[lattice]
grid = [8, 8, 8]
[[effects]]
kind = "gravity"
acceleration = [0.0, 0.0, -0.001]
"""


def test_every_load_case_is_explained_once_by_what_solves_it():
    scene = load_scene("paper-fem-2d")
    explanation, setup = explain(scene), scene.build()
    names = [name for note in explanation.supports for name in note.load_cases]
    assert sorted(names) == sorted(case.name for case in setup.cases)
    assert [note.engine for note in explanation.supports] == ["lanes"] * len(explanation.supports)
    for note, group in zip(explanation.supports, setup.model.groups(setup.cases), strict=True):
        assert note.why == group.choice.why
        assert note.unknowns == np.count_nonzero(setup.cases[group.cases[0]].free)
    assert (explanation.nodes, explanation.springs, explanation.kinematics) == (25, 72, "exact")
    assert [effect.name for effect in explanation.effects] == ["springs"]


@pytest.mark.parametrize(("kinematics", "engine"), [("exact", "sparse"), ("linear", "linear")])
def test_size_kinematics_and_effects_show(tmp_path, kinematics, engine):
    (tmp_path / "big.toml").write_text(BIG.format(kinematics=kinematics))
    explanation = explain(load_scene(tmp_path / "big.toml"))
    assert {(note.engine, note.solver) for note in explanation.supports} == {(engine, "band")}
    sentence = explanation.supports[0].why
    assert "1,344 unknowns with a half-bandwidth of 194" in sentence
    assert ("small" in sentence) == (kinematics == "linear")
    springs, gravity = explanation.effects
    assert (springs.name, gravity.name) == ("springs", "gravity")
    assert "costs nothing" in gravity.brings


def test_the_loop_is_the_one_that_solves(tmp_path):
    for kinematics, loop in (("exact", "find_equilibria"), ("linear", "solve_eights")):
        path = tmp_path / f"{kinematics}.toml"
        path.write_text(f'title = "Mine"\nextends = "paper-stiffness-2d"\nkinematics = "{kinematics}"\n')
        assert {note.loop for note in explain(load_scene(path)).supports} == {loop}


def test_a_scene_asks_for_an_engine_and_solves_with_it(tmp_path):
    text = 'title = "Mine"\nextends = "paper-topology-2d-isotropic"\nengine = "sparse"\n'
    (tmp_path / "mine.toml").write_text(text)
    scene, known = load_scene(tmp_path / "mine.toml"), load_scene("paper-topology-2d-isotropic")
    assert {note.engine for note in explain(scene).supports} == {"sparse"}
    ours, theirs = scene.build(), known.build()
    assert ours.model.engine == "sparse"
    np.testing.assert_allclose(ours.reference_positions, theirs.reference_positions, atol=1e-8)
