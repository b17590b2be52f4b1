"""Scenes of other readings of the paper."""

import numpy as np
import pytest

from springopt.analysis.identifiability import identify
from springopt.analysis.point import choose_point
from springopt.reproduction.larger_meshes import larger
from springopt.reproduction.variants import calibrated, clamped, limited, scaled
from springopt.runner import solve
from springopt.scene import load_scene


def test_with_one_side_held_throughout_four_springs_are_unseen() -> None:
    setup = clamped("paper-stiffness-2d").build()
    assert sum(case.role == "train" for case in setup.cases) == 12
    held = np.all([case.supports for case in setup.cases], axis=0)
    assert (setup.lattice.nodes[held.all(axis=1), 0] == 0).all()
    assert [unseen.spring for unseen in identify(setup, choose_point(setup)).unseen] == [1, 18, 35, 52]


def test_calibrated_loads_have_the_paper_s_homogeneous_cost() -> None:
    scene = calibrated("paper-fem-2d")
    assert scene.name == "paper-fem-2d-calibrated"
    assert scene.load_cases.scale == pytest.approx(2.564, abs=1e-3)
    homogeneous = limited(scene, "homogeneous")
    assert homogeneous.name == "paper-fem-2d-calibrated-homogeneous"
    assert solve(homogeneous, "random-search", evaluations=300).objective == pytest.approx(0.85, abs=1e-3)


def test_limitations_are_the_bundled_scenes() -> None:
    for limitation in ("homogeneous", "two-class", "three-class"):
        made = limited(load_scene("paper-fem-2d"), limitation)
        bundled = load_scene(f"paper-fem-2d-{limitation}")
        assert (made.name, made.digest()) == (bundled.name, bundled.digest())


def test_scaled_loads_multiply_those_that_were_scaled_before() -> None:
    twice = scaled(load_scene("paper-fem-2d"), "twice", 2.0)
    assert scaled(twice, "four", 2.0).load_cases.scale == 4.0


@pytest.mark.parametrize("side", [5, 9])
def test_larger_meshes_have_the_same_mean_strain(side: int) -> None:
    setup = larger(side).build()
    pull = setup.reference_positions[0] - setup.lattice.nodes
    right = setup.lattice.nodes[:, 0] == side - 1
    assert pull[right, 0].mean() / (side - 1) == pytest.approx(0.0395, rel=0.05)  # corners are loaded as other nodes
