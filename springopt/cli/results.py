"""What `solve` and `show` print of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.table import Table

    from springopt.run import LooseSelections, Run

USUAL, WIDEST = 160, 240  # characters of a line


def print_run(run: Run, floor: str | None = None) -> None:
    """What came of it: its place above the floor, cost, errors, stiffness, parameters, front and run file."""
    from springopt.report.tables import classes_table, errors_table, front_table, parameters_table

    click.echo(f"{run.scene}, {run.method}, seed {run.seed}: objective {run.objective:.6g}")
    if floor is not None:
        click.echo(floor)
    if run.objective_of_present is not None:
        click.echo(f"objective {run.objective_of_present:.6g} if only the springs above the threshold are kept")
    click.echo(
        f"{run.evaluations:,} evaluations, {run.solves:,} solves, {run.seconds:.1f} s "
        f"({run.processor_seconds:.1f} s of processor time, {run.solving_seconds:.1f} s of it solving); "
        f"stopped by: {run.why_stopped}"
    )
    if run.loose_selections:
        click.echo(_told(run.loose_selections))
    print_table(errors_table(run.errors))
    print_table(classes_table(run.classes))
    if run.parameters:
        print_table(parameters_table(run.parameters, run.parameter_intervals, run.reference_parameters))
    if run.front:
        print_table(front_table(run.front, len(run.stiffness)))
    if run.run:
        click.echo(f"Run file: {run.run}")


def _told(loose: LooseSelections) -> str:
    return (
        f"{loose.made:,} selections by tolerances up to {loose.loosest_tolerance:g}; {loose.compared:,} of them were "
        f"compared with the scene's own, and {loose.differed:,} differed"
    )


def print_table(table: Table) -> None:
    """A table on standard output, never cut to a terminal's width where there is none."""
    from rich.console import Console
    from rich.measure import Measurement

    console = Console()
    if not console.is_terminal:
        console.width = WIDEST
        console.width = max(USUAL, Measurement.get(console, console.options, table).maximum)
    console.print()
    console.print(table)
