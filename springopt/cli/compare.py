"""`springopt compare`: optimizers beside each other, from their runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from springopt.cli.bar import counting_bar
from springopt.cli.main import COMMANDS
from springopt.cli.names import split_names
from springopt.cli.outputs import TABLE_ENDINGS, require_new, require_new_folder
from springopt.cli.results import print_table
from springopt.errors import UserError

if TYPE_CHECKING:
    from springopt.comparison import Comparison

LEFT_OUT_SHOWN = 10


@click.command("compare", short_help=COMMANDS["compare"])
@click.argument("paths", metavar="FOLDER|RUNS...", nargs=-1, required=True)
@click.option(
    "--scenes", multiple=True, metavar="NAME,...", help="Scenes, or groups of them.  [default: all that have runs]"
)
@click.option("--optimizers", multiple=True, metavar="NAME,...", help="Which ones.  [default: all that have runs]")
@click.option("--scene", "shown", metavar="NAME", help="Show this scene in full instead of all in short.")
@click.option(
    "--target",
    type=click.IntRange(1, 6),
    default=2,
    show_default=True,
    help="K: running times to 1e-K of the way from the start to the floor.",
)
@click.option("--csv", metavar="FILE.csv", help="Write every number as a row of one table.")
@click.option(
    "--figures", metavar="FOLDER", help="Draw it: budgets, profiles, running times, ranks, each scene's course."
)
@click.option("--json", "as_json", is_flag=True, help="Print all of it as one JSON document.")
def command(
    paths: Sequence[str],
    scenes: Sequence[str],
    optimizers: Sequence[str],
    shown: str | None,
    target: int,
    csv: str | None,
    figures: str | None,
    as_json: bool,
) -> None:
    """Compare optimizers by their runs: how close to the floor, how often, how fast, and how sure that is.

    FOLDER is what `springopt benchmark` fills; single run files do as well. A gap is the share that is left of the way
    from a scene's start, which needs no search, to its floor. Running times are counted in evaluations, forward solves
    and processor seconds.
    """
    on, chosen = _chosen_scenes(scenes, shown), split_names("--optimizers", optimizers)
    table = None if csv is None else require_new(csv, TABLE_ENDINGS)
    folder = None if figures is None else require_new_folder(figures)
    from springopt.comparison import compare

    with _bar() as progress:
        comparison = compare(paths, optimizers=chosen, scenes=on, target=target, progress=progress)
    if table:
        _write(comparison, table)
    if folder:
        _draw(comparison, folder)
    if as_json:
        click.echo(comparison.to_json())
    elif shown:
        _print_scenes(comparison)
    else:
        _print(comparison)


@contextmanager
def _bar() -> Iterator[Callable[[int, int], None] | None]:
    """A bar over the runs that have been read."""
    with counting_bar() as show:
        yield show and (lambda read, runs: show(read, runs, "runs read"))


def _chosen_scenes(scenes: Sequence[str], shown: str | None) -> list[str]:
    if shown is None:
        return split_names("--scenes", scenes)
    if scenes:
        raise UserError("--scene shows one scene and --scenes chooses several; give one of the two.")
    if not shown.strip():
        raise UserError("--scene is empty; name a scene, or leave it away.")
    return [shown]


def _write(comparison: Comparison, path: Path) -> None:
    from springopt.comparison.rows import write_csv

    write_csv(comparison, path)


def _draw(comparison: Comparison, folder: Path) -> None:
    from springopt.report.comparison.figures import comparison_figures
    from springopt.report.figures import save

    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in comparison_figures(asdict(comparison)):
        save(figure, folder / f"{name}.png")


def _print(comparison: Comparison) -> None:
    from rich.console import Console

    from springopt.report.comparison.tables import cost_table, gap_tables, ranking_table, running_time_table

    document, console = asdict(comparison), Console()
    for table in gap_tables(document, console.width if console.is_terminal else 160):
        print_table(table)
    print_table(running_time_table(document))
    if comparison.ranking:
        print_table(ranking_table(document))
    else:
        click.echo("\nNo ranks over scenes: they need two optimizers with runs on the same two scenes.")
    print_table(cost_table(document))
    _print_notes(comparison)


def _print_scenes(comparison: Comparison) -> None:
    from springopt.comparison.failure import FAILED
    from springopt.report.comparison.scene_tables import scene_tables

    for scene in asdict(comparison)["scenes"]:
        for table in scene_tables(scene, comparison.target):
            print_table(table)
    for refusal in comparison.refusals:
        click.echo(f"{'Failed' if refusal.word == FAILED else 'Not served'}: {refusal.sentence}")
    _print_notes(comparison)


def _print_notes(comparison: Comparison) -> None:
    """What a reader must know, and what is missing."""
    for note in comparison.notes:
        click.echo(f"Note: {note}")
    for run in comparison.left_out[:LEFT_OUT_SHOWN]:
        click.echo(f"Left out: {run.path} ({run.why.rstrip('.')})")
    if (more := len(comparison.left_out) - LEFT_OUT_SHOWN) > 0:
        click.echo(f"Left out: {more} more; --json names them.")
