"""The stability ladder: every rung is right or rightly refused, and none is silently wrong."""

from collections import defaultdict

import pytest
from ladder import RIGHT, RIGHTLY_REFUSED, SILENTLY_WRONG, climb, pressed

import springopt as so


@pytest.fixture(scope="module")
def verdicts():
    return climb()


def test_no_rung_is_silently_wrong(verdicts):
    assert len(verdicts) >= 200
    assert [verdict for verdict in verdicts if verdict.reading == SILENTLY_WRONG] == []


def test_what_can_be_solved_is_solved_in_every_family(verdicts):
    families = defaultdict(list)
    for verdict in verdicts:
        if verdict.is_solvable:
            families[verdict.family].append(verdict.reading == RIGHT)
    shares = {family: sum(members) / len(members) for family, members in families.items()}
    assert {family: share for family, share in shares.items() if share < 0.9} == {}
    everything = [is_right for members in families.values() for is_right in members]
    assert sum(everything) >= 0.99 * len(everything)


def test_what_cannot_be_solved_is_refused_with_the_right_status(verdicts):
    hopeless = [verdict for verdict in verdicts if not verdict.is_solvable]
    assert len(hopeless) >= 40
    assert [verdict for verdict in hopeless if verdict.reading != RIGHTLY_REFUSED] == []


def test_the_judge_tells_a_saddle_from_a_minimum():
    rung = next(rung for rung in pressed.rungs() if rung.name == "pendulum on its head, 1.0")
    solution = so.Model(rung.lattice).solve(rung.stiffness, [rung.case])
    upright = solution.batch.equilibria.displacements
    upright[:] = [0.0, 0.0, 0.0, -0.5]
    assert "saddle" in rung.fault(solution)
    upright[:] = [0.0, 0.0, 0.0, -0.4]
    assert "residual" in rung.fault(solution)
