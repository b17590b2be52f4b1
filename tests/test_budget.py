import numpy as np
import pytest

from springopt.budget import Budget
from springopt.errors import UserError


@pytest.mark.parametrize(
    ("limits", "sentence"),
    [
        ({}, "a run needs a limit and none came; give evaluations, seconds, solves or a target."),
        ({"evaluations": 0}, "evaluations must be a positive whole number, not 0"),
        ({"evaluations": 2.5}, "evaluations must be a positive whole number, not 2.5"),
        ({"solves": True}, "solves must be a positive whole number, not True"),
        ({"seconds": -1.0}, "seconds must be a positive number, not -1.0"),
        ({"seconds": float("nan")}, "seconds must be a positive number, not nan"),
        ({"target": float("inf")}, "target must be a finite number, not inf"),
        ({"target": "low"}, "target must be a finite number, not 'low'"),
    ],
)
def test_an_illegal_limit_is_refused_in_one_sentence(limits, sentence):
    with pytest.raises(UserError, match=sentence):
        Budget(**limits)


def test_numbers_of_numpy_become_plain_ones():
    budget = Budget(evaluations=np.int64(3), target=np.float64(-1.5))
    assert (type(budget.evaluations), type(budget.target)) == (int, float)
