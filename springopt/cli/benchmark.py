"""`springopt benchmark`: many optimizers on many scenes, each with several seeds."""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING

import click

from springopt.cli.bar import bar_over_runs
from springopt.cli.main import COMMANDS
from springopt.cli.names import split_names
from springopt.cli.results import print_table
from springopt.errors import UserError

if TYPE_CHECKING:
    from springopt.benchmark.job import Job
    from springopt.benchmark.outcome import Outcome
    from springopt.benchmark.request import Request

DEFAULT_SEEDS = 15
FAILURES_SHOWN = 10


@click.command("benchmark", short_help=COMMANDS["benchmark"])
@click.option("--scenes", multiple=True, metavar="NAME,...", help="Scenes, groups, TOML files.  [default: all bundled]")
@click.option("--optimizers", multiple=True, metavar="NAME,...", help="Which ones.  [default: all that are installed]")
@click.option(
    "--seeds",
    type=click.IntRange(min=1),
    help=f"How many runs of each; they have the seeds 0, 1, ...  [default: {DEFAULT_SEEDS}]",
)
@click.option("--evaluations", type=int, help="Candidate evaluations that each run may cost.")
@click.option("--seconds", type=float, help="Seconds that each run may take.")
@click.option("--solves", type=int, help="Forward solves that each run may cost.")
@click.option(
    "--quick", is_flag=True, help="The quick suite, where nothing else is said: within 10 minutes on 2 cores."
)
@click.option("--workers", type=click.IntRange(min=1), help="Processes that share the runs.  [default: 1]")
@click.option("--dask", metavar="ADDRESS", help="Run on the workers of this Dask scheduler, or scheduler file.")
@click.option("--out", required=True, metavar="FOLDER", help="Of the run files, FOLDER/SCENE/OPTIMIZER/seedN.h5.")
@click.option("--json", "as_json", is_flag=True, help="Print what came of each run as one JSON document.")
def command(
    scenes: tuple[str, ...],
    optimizers: tuple[str, ...],
    seeds: int | None,
    quick: bool,
    workers: int | None,
    dask: str | None,
    out: str,
    as_json: bool,
    **limits: float | None,
) -> int:
    """Run every optimizer on every scene, several times; where it can't serve one, the table says why in a word.

    --scenes and --optimizers take several names with commas between them, and may be repeated: --scenes paper,mine.toml
    --scenes "more/*.toml". Without a limit on evaluations, seconds or solves each scene's own budget holds.

    Interrupted or killed, the same command goes on where it stopped. More scenes, optimizers or seeds may be added to a
    folder; another budget or a scene that was changed needs another one. Exit code 0 if no run failed, else 1.
    """
    if dask is not None and workers is not None:
        raise UserError("--workers are processes of this machine and --dask has its own; give one of the two.")
    given = {name: limit for name, limit in limits.items() if limit is not None}
    with redirect_stdout(sys.stderr):  # standard output is ours: optimizers may print
        jobs, request = _jobs(
            _folder(out), split_names("--scenes", scenes), split_names("--optimizers", optimizers), seeds, given, quick
        )
        outcomes = _run(jobs, request, Path(out), workers or 1, dask)
    if as_json:
        click.echo(json.dumps([outcome.to_dict() for outcome in outcomes]))
    else:
        _print(outcomes, jobs)
        click.echo(f"Compare: springopt compare {out}")
    return 1 if any(outcome.state == "failed" for outcome in outcomes) else 0


def _jobs(
    folder: Path,
    scene_words: Sequence[str],
    optimizer_names: Sequence[str],
    seeds: int | None,
    limits: Mapping[str, float],
    quick: bool,
) -> tuple[list[Job], Request]:
    """All that is asked for, and the note of it."""
    from springopt.benchmark import suite
    from springopt.benchmark.request import make_request

    if quick:
        scene_words, limits = scene_words or suite.QUICK_SCENES, limits or suite.QUICK_LIMITS
        seeds = seeds or suite.QUICK_SEEDS
    scenes, optimizers = suite.choose_scenes(scene_words), suite.choose_optimizers(optimizer_names)
    jobs = suite.make_jobs(scenes, optimizers, seeds or DEFAULT_SEEDS, limits)
    request = make_request(folder, scenes, optimizers, seeds or DEFAULT_SEEDS, limits)
    if request.is_of_another_build:
        warnings.warn(
            f"{folder} has runs of another build of springopt or of an optimizer; to compare like with like choose "
            "another folder.",
            RuntimeWarning,
            stacklevel=2,
        )
    return jobs, request


def _run(jobs: Sequence[Job], request: Request, folder: Path, workers: int, dask: str | None) -> list[Outcome]:
    from springopt.benchmark import run_jobs

    with bar_over_runs() as progress:
        try:
            return run_jobs(jobs, folder, workers=workers, dask=dask, ready=request.note, progress=progress)
        except KeyboardInterrupt:
            anew = "" if dask is None else ", and what was under way on the cluster starts anew"
            click.echo(f"What ended is in {folder}; the same command goes on{anew}.", err=True)
            raise


def _folder(out: str) -> Path:
    from springopt.benchmark.request import REQUEST

    folder = Path(out)
    if folder.exists() and not folder.is_dir():
        raise UserError(f"{out} is a file and no folder; choose another one.")
    if folder.is_dir() and not (folder / REQUEST).exists() and any(folder.iterdir()):
        raise UserError(f"{out} holds other things than results of a benchmark; choose a new folder.")
    return folder


def _print(outcomes: Sequence[Outcome], jobs: Sequence[Job]) -> None:
    """How many runs of each optimizer have ended on each scene, and what failed."""
    from springopt.report.tables import benchmark_tables

    scenes = list(dict.fromkeys(job.scene_name for job in jobs))
    for table in benchmark_tables(scenes, _cells(outcomes)):
        print_table(table)
    elsewhere = sum(outcome.state == "elsewhere" for outcome in outcomes)
    if elsewhere:
        click.echo(f"Another process is at {elsewhere:,} of these runs; the same command goes on with what it leaves.")
    failures = [outcome for outcome in outcomes if outcome.state == "failed"]
    for outcome in failures[:FAILURES_SHOWN]:
        click.echo(f"{outcome.label} on {outcome.scene}, seed {outcome.seed}, failed: {outcome.sentence}")
    if len(failures) > FAILURES_SHOWN:
        click.echo(f"and {len(failures) - FAILURES_SHOWN:,} runs more; --json has them all.")


def _cells(outcomes: Sequence[Outcome]) -> dict[str, dict[str, str]]:
    """By optimizer and scene: how many runs have ended, of how many where some failed, or why there are none."""
    pairs: dict[tuple[str, str], list[Outcome]] = {}
    for outcome in outcomes:
        pairs.setdefault(outcome.pair, []).append(outcome)
    cells: dict[str, dict[str, str]] = {}
    for (scene, label), runs in pairs.items():
        cells.setdefault(label, {})[scene] = _cell(runs)
    return cells


def _cell(runs: Sequence[Outcome]) -> str:
    word = next((run.word for run in runs if run.word), None)
    if word:
        return word
    done = sum(run.state == "done" for run in runs)
    return f"{done}" if done == len(runs) else f"{done} of {len(runs)}"
