"""Standard errors of parameters of effects, from cases that are known by hand."""

from pathlib import Path

import numpy as np
import pytest

from springopt.analysis.identifiability import Identifiability, identify
from springopt.analysis.point import choose_point
from springopt.scene import load_scene

STIFFNESS, MASS, GRAVITY, NOISE = 4.0, 0.05, 2.0, 1e-3
WEIGHED = """
title = "A weight on a spring"
effects = [{{ kind = "gravity", acceleration = [{gravity}, 0.0], mass = {mass} }}, {{ kind = "damping" }}]
[lattice]
nodes = [[0.0, 0.0], [1.0, 0.0]]
springs = [[0, 1]]
[reference]
kind = "spring"
stiffness = {stiffness}
[encoding]
kind = "real"
lower = 1.0
upper = 10.0
parameters = [{{ name = "{fitted}", lower = 0.0, upper = {upper} }}]
[load_cases]
train = [{cases}]
"""


def weighed(folder: Path, forces: list[float], fitted: str = "gravity.mass", upper: float = 1.0) -> Identifiability:
    hold = '[{ on = 0 }, { on = 1, axes = ["y"] }]'
    cases = ", ".join(
        f'{{ name = "{force}", hold = {hold}, push = {{ on = 1, force = [{force}, 0.0] }} }}' for force in forces
    )
    text = WEIGHED.format(gravity=GRAVITY, mass=MASS, stiffness=STIFFNESS, fitted=fitted, upper=upper, cases=cases)
    (folder / "weighed.toml").write_text(text)
    setup = load_scene(folder / "weighed.toml").build()
    return identify(setup, choose_point(setup), noise=NOISE)


@pytest.mark.parametrize("upper", [1.0, 1000.0])
def test_a_stiffness_and_a_mass_have_the_errors_of_their_two_by_two_problem(tmp_path: Path, upper: float) -> None:
    """u = (f + m g) / k; the interval's width, by which a parameter is counted, has no part in its error."""
    forces = [0.2, 0.8]
    found = weighed(tmp_path, forces, upper=upper)
    rows = [[-(f + MASS * GRAVITY) / STIFFNESS**2, GRAVITY / STIFFNESS] for f in forces]
    errors = NOISE * np.abs(np.linalg.inv(rows))
    (mass,) = found.parameters
    assert found.standard_errors == pytest.approx([np.linalg.norm(errors[0])], rel=1e-6)
    assert mass.standard_error == pytest.approx(np.linalg.norm(errors[1]), rel=1e-6)
    assert (mass.name, mass.value, found.rank, found.shared) == ("gravity.mass", MASS, 2, [])


def test_under_one_load_alone_a_mass_makes_up_for_the_spring(tmp_path: Path) -> None:
    found = weighed(tmp_path, [0.2])
    (shared,) = found.shared
    assert (shared.springs, shared.parameters, shared.free_directions) == ([0], ["gravity.mass"], 1)
    assert found.parameters[0].standard_error == np.inf


def test_what_no_load_case_feels_is_not_identified_and_disturbs_nothing(tmp_path: Path) -> None:
    """Damping at rest."""
    found = weighed(tmp_path, [0.2], fitted="damping.springs")
    (damping,) = found.parameters
    assert (damping.standard_error, damping.best_case) == (np.inf, -1)
    assert found.standard_errors == pytest.approx([NOISE * STIFFNESS**2 / (0.2 + MASS * GRAVITY)], rel=1e-6)
    assert found.shared == []
