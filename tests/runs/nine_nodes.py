"""The small scene of these tests, an optimizer that asks for everything, Ctrl-C, and runs compared."""

import dataclasses
import os
import signal
from pathlib import Path

import numpy as np

from springopt.errors import NoEquilibrium
from springopt.optimizer import Optimizer

SCENE = (Path(__file__).parents[1] / "data" / "nine-nodes.toml").read_text()


@dataclasses.dataclass(frozen=True)
class Wanderer(Optimizer):
    """Asks for everything there is: values, two goals, gradients, Jacobians, the budget left; notes what it got."""

    name = "wanderer"
    needs = ("real", "jacobian")
    step: float = 0.5  #: of the way down the gradient

    def minimize(self, problem, rng):
        while problem.budget_left:
            points = problem.sample(rng, 5)
            point = points[np.argmin(problem.objectives(points)[:, 0])]
            try:
                _, gradient = problem.gradient(point)
                residuals, jacobian = problem.jacobian(point)
            except NoEquilibrium:
                continue
            newton = np.linalg.lstsq(jacobian, -residuals, rcond=None)[0]
            problem.note(slope=np.linalg.norm(gradient))
            problem.evaluate(np.clip([point - self.step * gradient, point + newton], problem.lower, problem.upper))


def require_same(run, other):
    """Two runs that went through the same answers, however often one of them was cut short."""
    facts, others = run.timeless(), other.timeless()
    for name in facts:
        np.testing.assert_equal(others[name], facts[name], name)


def names(out):
    return sorted(path.name for path in out.parent.iterdir())


def press_ctrl_c_after(evaluations):
    """A progress callback that presses Ctrl-C once."""
    pressed = []

    def progress(done, total, best, seconds):
        if done >= evaluations and not pressed:
            pressed.append(True)
            os.kill(os.getpid(), signal.SIGINT)

    return progress
