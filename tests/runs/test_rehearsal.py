"""What the first run of a process would pay for all is no part of it."""

import dataclasses
import time
from typing import ClassVar

from springopt.optimizer import Optimizer
from springopt.runner import solve

LONG = 0.3  # seconds


@dataclasses.dataclass(frozen=True)
class LateImporter(Optimizer):
    """Is busy when it is first at work in a process, as with imports; prints, and asks for one value."""

    name = "late-importer"
    at_work: ClassVar[list[int]] = []

    def minimize(self, problem, rng):
        if not self.at_work:
            end = time.process_time() + LONG
            while time.process_time() < end:
                pass
        self.at_work.append(problem.size)
        print("at work")
        problem.evaluate(problem.sample(rng, 1))


@dataclasses.dataclass(frozen=True)
class Cornered(Optimizer):
    """Fails on small problems."""

    name = "cornered"

    def minimize(self, problem, rng):
        if problem.meter.budget.evaluations == 100:
            raise ZeroDivisionError
        problem.evaluate(problem.sample(rng, 1))


def test_imports_of_an_optimizer_at_work_are_not_charged_to_the_first_run(scene, capsys):
    runs = [solve(scene, LateImporter(), seed=seed) for seed in range(2)]
    assert all(run.processor_seconds < LONG / 2 for run in runs)
    assert len(LateImporter.at_work) == 3  # once before the first run alone
    assert capsys.readouterr().out == "at work\n" * 2


def test_what_goes_wrong_before_the_run_alone_does_not_matter(scene):
    assert solve(scene, Cornered()).evaluations == 1
