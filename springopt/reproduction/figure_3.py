"""Figure 3: the errors of a model learned from finite elements, in training and in test load cases."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean

from springopt.benchmark import Job
from springopt.report.rows import draw_rows
from springopt.reproduction import baselines, paper
from springopt.reproduction.experiment import Experiment, Picture, Section, Table
from springopt.reproduction.extent import Extent
from springopt.reproduction.jobs import BASELINES, PAPER_GA, baseline_jobs, ga_jobs
from springopt.reproduction.runs import Runs
from springopt.reproduction.spread import Spread
from springopt.reproduction.table_1 import CALIBRATED, CLAMPED, readings
from springopt.reproduction.verdict import Comparison
from springopt.store import RunFile

#: Four of the twelve training load cases, two shears and two pulls, and three of the test load cases.
SHOWN = {
    CALIBRATED: ("shear right", "shear top", "pull right", "pull top", "pull corner", "pull askew", "bend right"),
    CLAMPED: (
        "shear right up",
        "shear right down",
        "pull right",
        "stretch",
        "pull corner",
        "bend right",
        "press between",
    ),
}
TRAINING = len(paper.TRAINING_ERRORS)


def _jobs(extent: Extent) -> list[Job]:
    scenes = readings().values()
    return [job for scene in scenes for job in ga_jobs(scene, extent) + baseline_jobs(scene, extent, BASELINES)]


def _section(runs: Runs, extent: Extent) -> Section:
    files = {name: runs.of(name, PAPER_GA) for name in SHOWN}
    best = min(files[CALIBRATED], key=lambda file: file.run.objective)
    return Section(
        paper="""Mean distance of the nodes over the smallest rest length, in four of twelve training load cases and in
            three others: the model does as well in what it was not shown.""",
        setting="""As Table 1, unrestricted, at the loads at which the homogeneous cost is the paper's. Which four and
            which three the paper shows is not told; here two shears and two pulls, as its errors come in pairs.""",
        tables=[_cases(files), _means(runs)],
        pictures=[
            Picture(
                "figure-3",
                draw_rows(best, SHOWN[CALIBRATED], [f"error {_error(best, name):.3f}" for name in SHOWN[CALIBRATED]]),
                "Training load cases (the first four) and test load cases; the seed with the lowest cost",
            )
        ],
        verdicts=_verdicts(files),
        explained="""Shear is what a spring model follows least, since its sides turn where those of a linear
            elastic body grow: the paper's errors have the same two sizes. Four errors of the mean 0.05 would make a
            cost of 0.60 of twelve load cases, and Table 1 has 0.58: the paper's cost is the sum over the load
            cases, as here.""",
    )


def _cases(files: dict[str, list[RunFile]]) -> Table:
    """Case by case, ours beside the paper's."""
    published = [*paper.TRAINING_ERRORS, *paper.TEST_ERRORS]
    roles = ["train"] * TRAINING + ["test"] * len(paper.TEST_ERRORS)
    rows = [
        (role, number.printed, *(f"{name}: {_errors(files[scene], name).said('.3f')}" for scene, name in names))
        for role, number, *names in zip(
            roles, published, *([(scene, name) for name in shown] for scene, shown in SHOWN.items()), strict=True
        )
    ]
    return Table(("", "paper", "here: sides taking turns", "here: one side held throughout"), rows)


def _means(runs: Runs) -> Table:
    """Means over all load cases of a role, and the baselines'."""
    rows: list[tuple[str, ...]] = [("the paper, the cases shown", "0.050", "0.033")]
    for name, scene in readings().items():
        rows.append((f"`paper-ga`, {name}", *_numbers(runs.of(scene.name, PAPER_GA)), *_spent(runs, scene.name)))
    rows += baselines.rows(runs, CALIBRATED, BASELINES, _numbers)
    note = "Means over all training and all test load cases, of the baselines at the loads of the second row:"
    return Table(("", "training", "test", *baselines.SPENT), rows, note)


def _spent(runs: Runs, scene: str) -> tuple[str, str]:
    return baselines.spent([file.run for file in runs.of(scene, PAPER_GA)])


def _numbers(files: Sequence[RunFile]) -> tuple[str, ...]:
    return tuple(Spread.of(mean_error(file, role) for file in files).said(".3f") for role in ("train", "test"))


def mean_error(file: RunFile, role: str) -> float:
    """The relative error, averaged over the load cases of a role."""
    return fmean(error["relative_distance"] for error in file.run.errors if error["role"] == role)


def _error(file: RunFile, name: str) -> float:
    return next(float(error["relative_distance"]) for error in file.run.errors if error["name"] == name)


def _errors(files: Sequence[RunFile], name: str) -> Spread:
    return Spread.of(_error(file, name) for file in files)


def _verdicts(files: dict[str, list[RunFile]]) -> list[str]:
    """Mean errors compared, since which case is which in the paper is not known."""
    published = {
        "train": paper.Published("0.05", "Figure 3, mean of the four"),
        "test": paper.Published("0.03", "Figure 3, mean of the three"),
    }
    names = {"train": "Mean training error", "test": "Mean test error"}
    ours = {role: {scene: _shown(found, scene, role) for scene, found in files.items()} for role in names}
    return [
        Comparison(
            names[role],
            published[role],
            ours[role][CALIBRATED],
            ".3f",
            {"one side held throughout": ours[role][CLAMPED]},
        ).said()
        for role in names
    ]


def _shown(files: Sequence[RunFile], scene: str, role: str) -> list[float]:
    names = SHOWN[scene][:TRAINING] if role == "train" else SHOWN[scene][TRAINING:]
    return [fmean(_error(file, name) for name in names) for file in files]


EXPERIMENT = Experiment("figure-3", "Figure 3: training and test errors", _jobs, _section)
