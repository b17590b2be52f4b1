"""Threads share the work of a batch, and change no bit of it."""

import dataclasses

import numpy as np
import pytest

import springopt as so
from springopt.forward.threads import run_all

GRID = so.SpringLattice.grid((4, 4))
LEFT, BOTTOM = GRID.nodes[:, 0] == 0, GRID.nodes[:, 1] == 0
CASES = [
    so.LoadCase("pull", LEFT, np.where(GRID.nodes[:, :1] == 3, [[0.5, 0.1]], 0.0)),
    so.LoadCase("lift", BOTTOM, np.where(GRID.nodes[:, 1:] == 3, [[0.1, 0.4]], 0.0)),
    so.LoadCase("press", LEFT, np.where(GRID.nodes[:, :1] == 3, [[-0.9, 0.0]], 0.0)),
]
CANDIDATES = np.random.default_rng(4).uniform(0.1, 9.0, (50, GRID.spring_count))
CANDIDATES[::3] *= np.random.default_rng(5).random(CANDIDATES[::3].shape) > 0.4  # some of them mechanisms


@pytest.mark.parametrize(
    "options",
    [{}, {"branch": "followed"}, {"kinematics": "linear"}, {"engine": "sparse"}, {"engine": "iterative"}],
    ids=str,
)
def test_answers_have_the_same_bits_for_any_number_of_threads(options):
    candidates = CANDIDATES[1:3] if "engine" in options else CANDIDATES
    alone = so.Model(GRID, **options).solve_many(candidates, CASES).equilibria
    for threads in (2, 3, 7):
        together = so.Model(GRID, threads=threads, **options).solve_many(candidates, CASES).equilibria
        for item in dataclasses.fields(alone):
            np.testing.assert_array_equal(getattr(together, item.name), getattr(alone, item.name))


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2"])
def test_threads_are_a_whole_number(threads):
    with pytest.raises(so.UserError, match="threads must be a whole number from 1 on"):
        so.Model(GRID, threads=threads)


def test_the_error_of_a_thread_is_raised():
    def fails():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_all([lambda: None, fails, lambda: None], threads=2)
