"""`springopt tradeoff`: what accuracy costs in time, on the user's own scene and machine."""

from __future__ import annotations

import json
import math
import shlex
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import click

from springopt.cli.bar import counting_bar
from springopt.cli.main import COMMANDS
from springopt.cli.names import split_names
from springopt.cli.outputs import require_new_page
from springopt.cli.results import print_table
from springopt.errors import UserError

SHARE_FOR_ANSWERS = 0.25  # of the seconds, to run again what answers the reverse question


class Finite(click.FloatRange):
    """A number of a range that is neither infinite nor nan, which no range keeps out."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number


@click.command("tradeoff", short_help=COMMANDS["tradeoff"])
@click.argument("scene")
@click.option(
    "--axis",
    "axes",
    multiple=True,
    metavar="NAME,...",
    help="solver, effects, stepping, reference, model, load-cases or optimizer.  [default: all]",
)
@click.option(
    "--seconds",
    type=Finite(min=0, min_open=True),
    default=120.0,
    show_default=True,
    help="For all axes together.",
)
@click.option(
    "--target-error",
    type=Finite(min=0, min_open=True),
    metavar="E",
    help="Name the cheapest setting of each axis whose error is at most E, and run it again to verify it.",
)
@click.option(
    "--time",
    type=Finite(min=0, min_open=True),
    metavar="T",
    help="Name the most accurate setting of each axis that takes at most T seconds, and run it again to verify it.",
)
@click.option(
    "--out",
    metavar="PAGE",
    help="Page to write, .html in one file or .md beside a folder of pictures.  [default: SCENE-tradeoff.html; with "
    "--json none]",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")
def command(
    scene: str,
    axes: Sequence[str],
    seconds: float,
    target_error: float | None,
    time: float | None,
    out: str | None,
    as_json: bool,
) -> None:
    """Measure error against time along each axis that SCENE has, and say what one digit more costs.

    \b
    solver      tolerance, engine, linear or exact kinematics
    effects     with and without each
    stepping    time step and integrator, where load cases have times
    reference   mesh refinement and element order of finite elements
    model       encodings, number of springs, lattice resolution; forward solves and real-time steps
    load-cases  so many of them, as given and by the load designer
    optimizer   the objective above the floor, of each optimizer

    Settings are run in turn until the interval of each time is narrow or the seconds are spent. Errors are judged by
    another code path than the one that is timed.
    """
    if target_error is not None and time is not None:
        raise UserError(
            "--target-error asks for the cheapest setting and --time for the most accurate; give one of them."
        )
    from springopt.scene import load_scene
    from springopt.tradeoff.axes import choose_axes

    names = split_names("--axis", axes)
    chosen, loaded = choose_axes(names), load_scene(scene)
    page = _page(out, loaded.name, as_json)
    is_asked = target_error is not None or time is not None
    with redirect_stdout(sys.stderr), counting_bar() as show:  # standard output is ours: optimizers may print
        from springopt.tradeoff.cheapest import find_cheapest
        from springopt.tradeoff.document import document
        from springopt.tradeoff.measure import measure

        setup = loaded.build()
        share = SHARE_FOR_ANSWERS if is_asked else 0.0
        found = measure(setup, chosen, seconds=(1 - share) * seconds, progress=show)
        each = share * seconds / len(found.measured)
        answers = [
            find_cheapest(setup, measured, target_error=target_error, time=time, seconds=each)
            for measured in found.measured
            if is_asked
        ]
        answer = document(loaded, found, answers)
    if page is not None:
        from springopt.report.tradeoff.page import write_tradeoff

        write_tradeoff(page, answer, _command_line(scene, names, seconds, target_error, time))
    if as_json:
        click.echo(json.dumps(answer, allow_nan=False))
        return
    _print(answer)
    click.echo(f"\nPage with figures: {page}")


def _page(out: str | None, name: str, as_json: bool) -> Path | None:
    if out is None and as_json:
        return None
    return require_new_page(out if out is not None else f"{name}-tradeoff.html")


def _command_line(
    scene: str, axes: Sequence[str], seconds: float, target_error: float | None, time: float | None
) -> str:
    """The command that makes the page again."""
    options = [f"--axis {name}" for name in axes]
    options += [f"--{name} {value:g}" for name, value in (("target-error", target_error), ("time", time)) if value]
    return " ".join(["springopt tradeoff", shlex.quote(scene), *options, f"--seconds {seconds:g}"])


def _print(answer: dict[str, Any]) -> None:
    from springopt.report.tradeoff.rows import sentences
    from springopt.report.tradeoff.tables import tradeoff_table

    click.echo(f"{answer['scene']}: {answer['title']}")
    for axis in answer["axes"]:
        print_table(tradeoff_table(axis))
        for sentence in sentences(axis):
            click.echo(sentence)
    for name, why in answer["missing"].items():
        click.echo(f"\n{name} is not measured: {why}.")
    said = [*answer["where_to_spend"], *(each["said"] for each in answer["answers"])]
    if said:
        click.echo("\n" + "\n".join(said))
