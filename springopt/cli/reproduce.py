"""`springopt reproduce`: every figure and table of the paper, from nothing."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout
from pathlib import Path

import click

from springopt.cli.bar import bar_over_runs
from springopt.cli.main import COMMANDS

FOLDER = click.Path(file_okay=False, path_type=Path)


@click.command("reproduce", short_help=COMMANDS["reproduce"])
@click.option("--quick", is_flag=True, help="Two seeds and short runs: a first look, in 2 minutes.")
@click.option("--only", multiple=True, metavar="NAME", help="An experiment, as figure-1; repeatable.")
@click.option("--workers", type=click.IntRange(min=1), default=2, show_default=True, help="Processes.")
@click.option("--out", type=FOLDER, default="reproduction", show_default=True, help="Folder of the page.")
@click.option("--runs", type=FOLDER, help="Folder of the runs, kept for the next call.  [default: OUT/runs]")
def command(quick: bool, only: tuple[str, ...], workers: int, out: Path, runs: Path | None) -> None:
    """Make every figure and table of Bianchi et al. (2004) again, ours beside the paper's, on one page.

    Writes OUT/reproduction.md and the pictures in OUT/reproduction. A call that was cut short is continued by the next
    one with the same runs. The whole takes half an hour on two cores.
    """
    from springopt.reproduction.extent import FULL, QUICK
    from springopt.reproduction.reproduce import reproduce

    with redirect_stdout(sys.stderr), bar_over_runs() as progress:
        page = reproduce(out, QUICK if quick else FULL, only=only, runs=runs, workers=workers, progress=progress)
    click.echo(f"Page: {page}")
