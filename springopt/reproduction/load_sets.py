"""Section 4.3: four, eight or twelve load cases to learn from, judged on the same others."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

import numpy as np

from springopt.analysis.identifiability import identify
from springopt.analysis.point import Point
from springopt.benchmark import Job
from springopt.report.dots import Dots, draw_dots
from springopt.reproduction import baselines
from springopt.reproduction.experiment import Experiment, Picture, Section, Table
from springopt.reproduction.extent import Extent
from springopt.reproduction.figure_3 import mean_error
from springopt.reproduction.jobs import BASELINES, PAPER_GA, baseline_jobs, ga_jobs
from springopt.reproduction.runs import Runs
from springopt.reproduction.spread import Spread
from springopt.scene import load_scene
from springopt.store import RunFile

SCENES = {4: "paper-fem-2d-4", 8: "paper-fem-2d-8", 12: "paper-fem-2d"}
SHOWN = (PAPER_GA, "gauss-newton", "balance", "analytic")


def _jobs(extent: Extent) -> list[Job]:
    scenes = [load_scene(name) for name in SCENES.values()]
    return [job for scene in scenes for job in ga_jobs(scene, extent) + baseline_jobs(scene, extent, BASELINES)]


def _section(runs: Runs, extent: Extent) -> Section:
    rows = [
        (f"{count}", *row)
        for label in (PAPER_GA, *BASELINES)
        for count, name in SCENES.items()
        for row in baselines.rows(runs, name, (label,), _numbers)
    ]
    shown = {(count, label): runs.of(name, label) for label in SHOWN for count, name in SCENES.items()}
    panels = [
        Dots(
            f"mean {what} error",
            {
                f"{label}, {count}": [mean_error(file, role) for file in files]
                for (count, label), files in shown.items()
            },
        )
        for role, what in (("train", "training"), ("test", "test"))
    ]
    told = _told(runs)
    return Section(
        paper="Sets of four, eight and twelve load cases were evaluated; the best results were obtained with twelve.",
        setting="""`paper-fem-2d-4`, `-8` and `paper-fem-2d`: the sides take turns as support, pulls and shears. All are
            judged on the same four load cases that none of them was shown. Errors are mean distances of the nodes over
            the smallest rest length, averaged over the load cases.""",
        tables=[Table(("load cases", "", "training", "test", *baselines.SPENT), rows), told],
        pictures=[Picture("load-sets", draw_dots(panels), "Training and test errors by load cases, a dot a seed")],
        verdicts=[_verdict(runs, label) for label in (PAPER_GA, "gauss-newton")],
        explained=_explained(runs, told),
    )


def _explained(runs: Runs, told: Table) -> str:
    few, many = (runs.of(SCENES[count], PAPER_GA) for count in (min(SCENES), max(SCENES)))
    fewer, more = (Spread.of(mean_error(file, "train") for file in files).middle for files in (few, many))
    return f"""Fewer load cases can be matched more closely, and tell less of each spring: from {min(SCENES)} to
        {max(SCENES)} the training error of `paper-ga` goes from {fewer:.4f} to {more:.4f}, and the largest standard
        error of a stiffness from {told.rows[0][-1]} to {told.rows[-1][-1]}."""


def _numbers(files: Sequence[RunFile]) -> tuple[str, ...]:
    return tuple(Spread.of(mean_error(file, role) for file in files).said(".4f") for role in ("train", "test"))


def _verdict(runs: Runs, label: str) -> str:
    """Which set has the lowest test error, in the median of the seeds, and whether by more than these differ."""
    sets = {count: runs.of(name, label) for count, name in SCENES.items()}
    errors = {count: Spread.of(mean_error(file, "test") for file in files) for count, files in sets.items()}
    said = ", ".join(f"{spread.said('.4f')} with {count}" for count, spread in errors.items())
    return f"Test error of `{label}`: {said}: {_judged(errors)}."


def _judged(errors: dict[int, Spread]) -> str:
    """Whether the most load cases do best, and whether the runner-up is told apart."""
    best, second, _ = sorted(errors, key=lambda count: errors[count].middle)
    alike = errors[second].least <= errors[best].greatest
    if best != max(SCENES) and not (alike and second == max(SCENES)):
        return f"**not as in the paper**, {best} do best; which load cases make a set is ours, and no other was tried"
    if alike:
        return f"**within the seeds' spread**, {best} and {second} are not told apart"
    return "**as in the paper**"


def _told(runs: Runs) -> Table:
    """What each set says of the springs at the best point known, as `springopt identify` has it."""
    rows = []
    for count, name in SCENES.items():
        file = min(runs.of(name, "gauss-newton"), key=lambda file: file.run.objective)
        known = identify(load_scene(name).build(), Point(file.run.point, "at the best point"))
        finite = known.standard_errors[np.isfinite(known.standard_errors)]
        numbers = f"{len(finite)} of 72", f"{median(finite):.2g}", f"{finite.max():.2g}"
        rows.append((f"{count}", *numbers))
    note = (
        "What they tell: standard errors of the stiffness if the reference's coordinates have noise of 0.001 spacings."
    )
    return Table(("load cases", "springs identified", "median standard error", "largest"), rows, note)


EXPERIMENT = Experiment("load-sets", "Section 4.3: four, eight or twelve load cases", _jobs, _section)
