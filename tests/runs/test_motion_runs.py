"""Runs on a scene in motion that fits parameters: interrupted, taken up again, and read back."""

from pathlib import Path

import numpy as np
from nine_nodes import press_ctrl_c_after, require_same

from springopt.runner import resume, solve
from springopt.scene import load_scene
from springopt.store import read

SCENE = load_scene(Path(__file__).parents[1] / "data" / "nine-nodes-in-motion.toml")


def test_every_kind_of_answer_is_resumed(out, eager_progress, wanderer):
    whole = solve(SCENE, wanderer, evaluations=60)
    run = solve(SCENE, wanderer, evaluations=60, out=out, progress=press_ctrl_c_after(20))
    assert not run.complete
    require_same(whole, resume(out))
    assert set(whole.parameters) == {"damping.springs", "inertia.density"}


def test_times_and_motions_come_back_from_the_run_file(out):
    run = solve(SCENE, "random-search", evaluations=16, out=out)
    file, setup = read(out), SCENE.build()
    require_same(run, file.run)
    np.testing.assert_array_equal(file.reference_positions, setup.reference_positions)
    solution = setup.objective.solution(setup.encoding.decode(run.point))
    np.testing.assert_array_equal(file.positions, solution.positions)
    for case, other in zip(setup.cases, file.cases, strict=True):
        np.testing.assert_array_equal(case.times, other.times)
