from dataclasses import dataclass

import pytest

from springopt.errors import PluginError, UserError
from springopt.optimizer import Optimizer, require_supplies


@dataclass(frozen=True)
class Idle(Optimizer):
    name = "idle"

    def minimize(self, problem, rng):
        pass


def needing(*words):
    return type("Needing", (Idle,), {"needs": words})()


def test_an_optimizer_without_needs_suits_every_problem():
    require_supplies(Idle(), frozenset())


def test_a_problem_that_lacks_what_is_needed_is_refused_in_one_sentence():
    require_supplies(needing("real", "gradient"), {"real", "gradient"})
    with pytest.raises(UserError, match="idle needs a binary encoding, which this scene does not supply"):
        require_supplies(needing("binary"), {"real", "gradient"})


def test_a_need_that_nobody_knows_is_the_plugin_authors_mistake():
    with pytest.raises(PluginError, match=r"unknown need 'gradients'.* Did you mean 'gradient'"):
        require_supplies(needing("gradients"), {"real", "gradient"})
