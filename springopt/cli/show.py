"""`springopt show`: a run file, for people."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from springopt.cli.floors import place_of, with_floor
from springopt.cli.main import COMMANDS
from springopt.cli.outputs import FIGURE_ENDINGS, require_new
from springopt.cli.results import print_run
from springopt.cli.runs import read_run

if TYPE_CHECKING:
    from springopt.store import RunFile


@click.command("show", short_help=COMMANDS["show"])
@click.argument("run", metavar="RUN.h5")
@click.option("--figure", metavar="FILE", help="Draw load cases, convergence, front and stiffness; .png, .pdf or .svg.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")
def command(run: str, figure: str | None, as_json: bool) -> None:
    """Show what a run found: errors, classes of springs, the front, and a figure of every load case."""
    figure_path = None if figure is None else require_new(figure, FIGURE_ENDINGS)
    contents = read_run(run)
    if figure_path is not None:
        _draw(contents, figure_path)
    place = place_of(contents.run, [Path(run).parent, Path()])
    if as_json:
        click.echo(with_floor(contents.run, place))
        return
    print_run(contents.run, place.said)
    if figure_path is not None:
        click.echo(f"Figure: {figure_path}")


def _draw(contents: RunFile, path: Path) -> None:
    from springopt.report.deformation import deformations
    from springopt.report.figures import Learned, draw, save

    run = contents.run
    title = (
        f"{run.scene}, {run.method}, seed {run.seed}, {run.evaluations:,} evaluations: objective {run.objective:.4g}"
    )
    learned = Learned(
        title=title,
        lattice=contents.lattice,
        stiffness=run.stiffness,
        deformations=deformations(contents.cases, contents.reference_positions, contents.positions, run.errors),
        history=run.history,
        evaluations=run.evaluations,
        front=run.front,
    )
    save(draw(learned), path)
