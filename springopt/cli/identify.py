"""`springopt identify`: which springs the load cases of a scene identify, and how well."""

from __future__ import annotations

import json
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springopt.cli.design import designed, print_design
from springopt.cli.main import COMMANDS
from springopt.cli.outputs import FIGURE_ENDINGS, require_new
from springopt.cli.results import print_table
from springopt.cli.runs import names_run, read_run

if TYPE_CHECKING:
    from springopt.analysis.identifiability import Identifiability
    from springopt.analysis.point import Point
    from springopt.scene import Setup


@click.command("identify", short_help=COMMANDS["identify"])
@click.argument("source", metavar="SCENE|RUN.h5")
@click.option("--at", "place", type=click.Choice(["best", "reference", "start", "middle"]), help="Where; see above.")
@click.option("--noise", type=float, help="Of the reference's coordinates.  [default: 0.001 smallest rest lengths]")
@click.option("--figure", metavar="FILE", help="Draw the lattice coloured by standard errors; .png, .pdf or .svg.")
@click.option("--design", "count", type=click.IntRange(min=1), help="Pick so many load cases that help most.")
@click.option(
    "--criterion",
    type=click.Choice(["D", "E"]),
    default="D",
    show_default=True,
    help="D: the smallest volume of what is uncertain; E: the shortest longest axis.",
)
@click.option(
    "--candidates",
    "candidates",
    default="generated",
    show_default=True,
    metavar="generated|test|SCENE",
    help="To pick from: a load on a side or corner while a side is held, the test load cases, or another scene's.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")
def command(
    source: str,
    place: str | None,
    noise: float | None,
    figure: str | None,
    count: int | None,
    criterion: str,
    candidates: str,
    as_json: bool,
) -> None:
    """Say which springs the training load cases see, which not and why, and the standard error of each.

    Parameters of effects that the scene fits are unknowns beside the springs, and have a standard error, too.

    The answer holds near one stiffness: by default the best of a run, of a scene that of its mass-spring reference,
    where it has another reference the middle of the box. With --design also which load cases to add.
    """
    from springopt.analysis.identifiability import identify

    figure_path = None if figure is None else require_new(figure, FIGURE_ENDINGS)
    setup, point = _load(source, place)
    found = identify(setup, point, noise=noise)
    if figure_path is not None:
        _draw(figure_path, setup, found)
    answer = _document(setup, found)
    if count is not None:
        answer["design"] = designed(setup, point, found.noise, count, criterion, candidates)
    if as_json:
        click.echo(json.dumps(answer, allow_nan=False))
        return
    _print(answer)
    if count is not None:
        print_design(answer["design"])
    if figure_path is not None:
        click.echo(f"Figure: {figure_path}")


def _load(source: str, place: str | None) -> tuple[Setup, Point]:
    """The scene made ready, and the point at which it is looked at."""
    from springopt.analysis.point import choose_point
    from springopt.scene import Scene, load_scene

    if not names_run(source):
        setup = load_scene(source).build()
        return setup, choose_point(setup, place)
    contents = read_run(source)
    setup = Scene.from_json(contents.order.scene).build()
    return setup, choose_point(setup, place, best=contents.run.point)


def _document(setup: Setup, found: Identifiability) -> dict[str, Any]:
    """Everything; a standard error is null where a spring is not identified."""
    return {
        "scene": setup.scene.name,
        "at": found.at,
        "noise": found.noise,
        "unknowns": len(found.singular_values),
        "rank": found.rank,
        "condition": found.condition if found.rank else None,
        "singular_values": found.singular_values.tolist(),
        "springs": _springs(setup, found),
        "unseen": [asdict(unseen) for unseen in found.unseen],
        "shared": [asdict(shared) for shared in found.shared],
        "parameters": _parameters(setup, found),
    }


def _parameters(setup: Setup, found: Identifiability) -> list[dict[str, Any]]:
    training = [case.name for case in setup.cases if case.role == "train"]
    return [
        {
            "name": parameter.name,
            "value": parameter.value,
            "standard_error": parameter.standard_error if isfinite(parameter.standard_error) else None,
            "seen_best_in": training[parameter.best_case] if parameter.best_case >= 0 else None,
        }
        for parameter in found.parameters
    ]


def _springs(setup: Setup, found: Identifiability) -> list[dict[str, Any]]:
    training = [case.name for case in setup.cases if case.role == "train"]
    return [
        {
            "spring": spring,
            "nodes": nodes,
            "stiffness": stiffness,
            "standard_error": error if isfinite(error) else None,
            "seen_best_in": training[case] if case >= 0 else None,
        }
        for spring, (nodes, stiffness, error, case) in enumerate(
            zip(
                setup.lattice.springs.tolist(),
                found.stiffness.tolist(),
                found.standard_errors.tolist(),
                found.best_case.tolist(),
                strict=True,
            )
        )
    ]


def _print(answer: dict[str, Any]) -> None:
    from springopt.report.tables import parameter_precision_table, precision_table, unseen_table

    identified = [row for row in answer["springs"] if row["standard_error"] is not None]
    condition = "-" if answer["condition"] is None else f"{answer['condition']:.3g}"
    click.echo(f"{answer['scene']}, {answer['at']}")
    click.echo(
        f"rank {answer['rank']} of {answer['unknowns']} unknowns, condition {condition}; {len(identified)} of "
        f"{len(answer['springs'])} springs identified{_of_parameters(answer['parameters'])}; "
        f"noise of the reference's coordinates {answer['noise']:g}"
    )
    if answer["unseen"]:
        print_table(unseen_table(answer["unseen"], answer["springs"]))
    for shared in answer["shared"]:
        click.echo(_sentence(**shared))
    if identified:
        print_table(precision_table(identified))
    if answer["parameters"]:
        print_table(parameter_precision_table(answer["parameters"]))


def _of_parameters(parameters: list[dict[str, Any]]) -> str:
    identified = sum(row["standard_error"] is not None for row in parameters)
    return f", {identified} of {len(parameters)} parameters" if parameters else ""


def _sentence(springs: list[int], free_directions: int, parameters: list[str]) -> str:
    shown = ", ".join(map(str, springs[:20])) + (", ..." if len(springs) > 20 else "")
    ways = "one way" if free_directions == 1 else f"{free_directions} independent ways"
    members = " and ".join([f"{len(springs)} springs"] * bool(springs) + [", ".join(parameters)] * bool(parameters))
    if len(springs) + len(parameters) == 1:
        return f"\n{', '.join(parameters) or f'spring {springs[0]}'} is not identified, to rounding"
    named = f": {shown}" if springs else ""
    return f"\n{members} make up for each other in {ways}, so that none of them is identified{named}"


def _draw(path: Path, setup: Setup, found: Identifiability) -> None:
    from springopt.report.figures import save
    from springopt.report.identifiability import Identified, draw_identified

    title = f"{setup.scene.name}, {found.at}: rank {found.rank} of {len(found.singular_values)}, noise {found.noise:g}"
    save(draw_identified(Identified(title, setup.lattice, found.standard_errors, found.is_seen)), path)
