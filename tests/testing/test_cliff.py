import numpy as np
import pytest

from springopt.errors import NoEquilibrium
from springopt.forward.status import MECHANISM
from springopt.testing import Bowl, Cliff

BEFORE, BEHIND = np.array([1.0, 3.0]), np.array([2.5, 3.0])
BOWL = Bowl(np.zeros(2))
CLIFF = Cliff(BOWL, 2.0, cap=100.0)


def test_behind_the_edge_values_are_at_the_cap_and_before_it_those_of_the_objective():
    evaluation = CLIFF.evaluate(np.array([BEFORE, BEHIND]))
    assert evaluation.values.tolist() == [5.0, 100.0]
    assert evaluation.codes.tolist() == [0, MECHANISM]


@pytest.mark.parametrize("name", ["gradient", "residuals", "jacobian", "linearize"])
def test_derivatives_end_at_the_edge(name):
    getattr(CLIFF, name)(BEFORE)
    with pytest.raises(NoEquilibrium, match="where the first stiffness is above 2"):
        getattr(CLIFF, name)(BEHIND)


def test_everything_else_is_the_objective_s():
    assert CLIFF.cases is BOWL.cases
    assert not hasattr(CLIFF, "model")
