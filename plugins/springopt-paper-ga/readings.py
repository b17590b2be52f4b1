"""Tries the readings of what the paper leaves open on its own experiments, and prints the tables of README.md.

    ./run python plugins/springopt-paper-ga/readings.py [SCENE ...] > readings.md

All three scenes take about half an hour on one core; stderr says how far it is.
"""

import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

import springopt as so
from springopt.run import Run

READINGS: dict[str, dict[str, Any]] = {
    "**base**: tournament of two, uniform crossover, one elite, limits by clipping": {},
    "parents drawn uniformly (`tournament = 1`)": {"tournament": 1},
    '`selection = "rank"`': {"selection": "rank"},
    '`selection = "roulette"`': {"selection": "roulette"},
    '`crossover = "one-point"`': {"crossover": "one-point"},
    '`crossover = "two-point"`': {"crossover": "two-point"},
    "`elite = 0`": {"elite": 0},
    '`survival = "compete"`': {"survival": "compete"},
    '`mutation = "gene"`': {"mutation": "gene"},
    '`mutation = "individual"`': {"mutation": "individual"},
    "`limit_pmut = false`": {"limit_pmut": False},
    '`limit = "reflect"`': {"limit": "reflect"},
    '`limit = "redraw"`': {"limit": "redraw"},
}
CHOICE, REPORT = range(5), range(100, 105)  # seeds


@dataclass(frozen=True)
class Experiment:
    """An experiment of the paper, what it reports, and when a run has reached that."""

    scene: str
    heads: tuple[str, ...]
    reached: Callable[[Run], bool]
    numbers: Callable[[Run], tuple[float, ...]]
    formats: tuple[str, ...]
    target: float | None = None
    idle: tuple[str, ...] = ()  #: options that change nothing here, or nothing worth the time

    def run(self, options: dict[str, Any], seed: int) -> Run:
        budget = so.load_scene(self.scene).budget.evaluations
        run = so.solve(self.scene, "paper-ga", seed=seed, options=options, evaluations=budget, target=self.target)
        print(self.scene, options, seed, *self.numbers(run), f"{run.processor_seconds:.1f} s", file=sys.stderr)
        return run

    def cells(self, runs: list[Run]) -> list[str]:
        """The median of each number with the least and the greatest, and how many runs reached the paper's figures."""
        columns = zip(*(self.numbers(run) for run in runs), strict=True)
        spans = [_span(column, form) for column, form in zip(columns, self.formats, strict=True)]
        return [*spans, f"{sum(map(self.reached, runs))} of {len(runs)}"]


def _span(numbers: tuple[float, ...], form: str) -> str:
    low, middle, high = (format(number, form) for number in (min(numbers), median(numbers), max(numbers)))
    return middle if low == high else f"{middle} ({low} to {high})"


def topology(run: Run) -> tuple[float, ...]:
    """Springs found, the largest position error of a training load case in spacings, generations of 5."""
    return np.count_nonzero(run.stiffness), _position_error(run), run.evaluations / 5


def _position_error(run: Run) -> float:
    return max(error["relative_distance"] for error in run.errors if error["role"] == "train")


def stiffness(run: Run) -> tuple[float, ...]:
    """Springs present, the mean of their stiffness and its spread."""
    present = run.stiffness[run.stiffness > 0]
    return len(present), present.mean(), present.std()


def experiments() -> list[Experiment]:
    two_class = so.solve("paper-fem-2d-two-class", "paper-ga").objective
    return [
        Experiment(
            "paper-topology-3d",
            ("springs", "error", "generations"),
            lambda run: topology(run)[0] >= 463 and topology(run)[1] <= 1e-3,
            topology,
            (".0f", ".1g", ".0f"),
            target=1e-9,  # nothing is left to find
            # The others are about numbers; and 30 bits in a whole run, one an individual, can't mend 230.
            idle=("mutation", "limit_pmut", "limit"),
        ),
        Experiment(
            "paper-stiffness-2d",
            ("springs", "mean", "spread"),
            lambda run: len(run.stiffness) == stiffness(run)[0] and _is_five(*stiffness(run)[1:]),
            stiffness,
            (".0f", ".2f", ".2f"),
        ),
        Experiment(
            "paper-fem-2d",
            ("cost / two-class cost",),
            lambda run: run.objective < two_class,
            lambda run: (run.objective / two_class,),
            (".3f",),
        ),
    ]


def _is_five(mean: float, spread: float) -> bool:
    return 4.9 <= mean <= 5.1 and spread <= 0.65


def table(experiment: Experiment, readings: dict[str, dict[str, Any]], seeds: Iterable[int]) -> str:
    rows = [["reading", *experiment.heads, "reached"], ["---"] * (len(experiment.heads) + 2)]
    for name, options in readings.items():
        if not set(experiment.idle) & set(options):
            rows.append([name, *experiment.cells([experiment.run(options, seed) for seed in seeds])])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def main(scenes: list[str]) -> None:
    for experiment in experiments():
        if scenes and experiment.scene not in scenes:
            continue
        print(f"`{experiment.scene}`, seeds {CHOICE[0]} to {CHOICE[-1]}:\n")
        print(table(experiment, READINGS, CHOICE) + "\n")
        print(f"`{experiment.scene}`, seeds {REPORT[0]} to {REPORT[-1]}:\n")
        print(table(experiment, {"the default, which is base": {}}, REPORT) + "\n", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
