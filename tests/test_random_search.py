import numpy as np
import pytest

from springopt.budget import Budget
from springopt.errors import BudgetSpent, UserError
from springopt.problem import Problem
from springopt.random_search import RandomSearch
from springopt.testing import CHECKS, Bowl, Box


@pytest.mark.parametrize("check", CHECKS)
def test_random_search_keeps_the_contract(check):
    check(RandomSearch)


def test_it_samples_the_whole_box_evenly():
    box = Box(np.array([0.0, 5.0]), np.array([10.0, 6.0]))
    problem = Problem(Bowl(np.array([10.0, 5.0])), box, Budget(evaluations=4000))
    with pytest.raises(BudgetSpent):
        RandomSearch(batch=48).minimize(problem, np.random.default_rng(0))
    assert problem.meter.evaluations == 4000
    # The closest of 4000 even draws is off by about sqrt(10 / (4000 pi / 4)) = 0.06 in the corner.
    np.testing.assert_allclose(problem.best_point, [10.0, 5.0], atol=0.3)


def test_an_empty_batch_is_refused():
    with pytest.raises(UserError, match="option batch of random-search is at least 1, not 0"):
        RandomSearch(batch=0)
