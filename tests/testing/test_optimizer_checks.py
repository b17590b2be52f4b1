"""The checks that plugin authors import find what they are for: each rogue here fails one of them."""

import re
import time
from dataclasses import dataclass

import numpy as np
import pytest

from springopt.errors import NoEquilibrium
from springopt.optimizer import Optimizer
from springopt.testing import check_optimizer


@dataclass(frozen=True)
class Descent(Optimizer):
    """Projected gradient descent from random starts: a sound optimizer that needs gradients."""

    name = "descent"
    needs = ("real", "gradient")
    step: float = 0.5  #: share of the gradient

    def minimize(self, problem, rng):
        while problem.budget_left:
            point = problem.sample(rng, 1)[0]
            for _ in range(10):
                try:
                    _, gradient = problem.gradient(point)
                except NoEquilibrium:
                    break
                point = np.clip(point - self.step * gradient, problem.lower, problem.upper)


@dataclass(frozen=True)
class Sampler(Optimizer):
    """What the rogues change."""

    name = "sampler"

    def minimize(self, problem, rng):
        while problem.budget_left:
            problem.evaluate(self.propose(problem, rng))

    def propose(self, problem, rng):
        return problem.sample(rng, 7)


@dataclass(frozen=True)
class Mute(Sampler):
    count: int = 3
    """Not the place for an explanation."""


@dataclass(frozen=True)
class Misused(Sampler):
    count: int = "three"  #: how many


@dataclass(frozen=True)
class Needy(Sampler):
    needs = ("gradients",)


class Plain(Sampler):
    def __init__(self):
        pass


@dataclass(frozen=True)
class Torn(Sampler):
    needs = ("real", "binary")


@dataclass(frozen=True)
class Lazy(Sampler):
    def minimize(self, problem, rng):
        pass


@dataclass(frozen=True)
class Forgetful(Sampler):
    def propose(self, problem, rng):
        return problem.sample(np.random.default_rng(), 7)


@dataclass(frozen=True)
class Sprawling(Sampler):
    def propose(self, problem, rng):
        return problem.sample(rng, 7) + 1e-9


@dataclass(frozen=True)
class Fragile(Descent):
    def minimize(self, problem, rng):
        while problem.budget_left:
            problem.gradient(problem.sample(rng, 1)[0])


@dataclass(frozen=True)
class Impatient(Sampler):
    def propose(self, problem, rng):
        return problem.sample(rng, 7) * (time.perf_counter_ns() % 1000 / 1000)


@dataclass(frozen=True)
class Remembering(Sampler):
    def propose(self, problem, rng):
        asked.append(None)
        return problem.sample(rng, 7) / len(asked)


asked: list[None] = []  # what Remembering carries over from run to run


def test_a_sound_optimizer_passes_as_a_class_and_made_ready():
    check_optimizer(Descent)
    check_optimizer(Descent(step=0.1))
    check_optimizer(Sampler)


@pytest.mark.parametrize(
    ("rogue", "sentence"),
    [
        (Mute, "option count of sampler has no explanation; put one behind #:."),
        (Misused, "option count of sampler is a whole number, not 'three'"),
        (Needy, "sampler has unknown needs {'gradients'}"),
        (Plain, "Plain must be a frozen dataclass"),
        (Torn, "sampler needs both a real and a binary encoding"),
        (Lazy, "sampler ended without a question on a budget of 1 evaluations."),
        (Forgetful, "sampler asks other questions with the same seed; draw from rng alone."),
        (Sprawling, "outside its interval"),
        (Fragile, "descent let NoEquilibrium through; catch it and try elsewhere."),
        (Impatient, "asks other questions with the same seed"),
        (Remembering, "asks other questions with the same seed"),
    ],
)
def test_a_rogue_is_told_what_is_wrong_in_one_sentence(rogue, sentence):
    with pytest.raises(AssertionError, match=re.escape(sentence)):
        check_optimizer(rogue)
