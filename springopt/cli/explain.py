"""`springopt explain`: what the forward solve makes of a scene, before anything is solved."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from springopt.cli.bar import counting_bar
from springopt.cli.main import COMMANDS
from springopt.cli.results import print_table

if TYPE_CHECKING:
    from springopt.scene import Scene


@click.command("explain", short_help=COMMANDS["explain"])
@click.argument("scene")
@click.option("--measure", is_flag=True, help="Solve, and say what each effect costs and what leaving it out changes.")
@click.option(
    "--accuracy",
    type=click.FloatRange(min=0, min_open=True),
    default=0.01,
    show_default=True,
    help="With --measure: name what changes positions by less, relative to the displacements.",
)
@click.option(
    "--seconds",
    type=click.FloatRange(min=0),
    default=5.0,
    show_default=True,
    help="With --measure: go on for so long.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")
def command(scene: str, measure: bool, accuracy: float, seconds: float, as_json: bool) -> None:
    """Say which effects a scene has, which kernels they call, which engine solves its load cases, and why.

    With --measure the load cases are solved at the stiffness of a mass-spring reference, or in the middle of the box:
    with everything, and without each effect in turn, over and over. An effect's share is what its absence saves of the
    processor's time.
    """
    from springopt.scene import load_scene
    from springopt.scene.explain import explain

    checked = load_scene(scene)
    answer = asdict(explain(checked))
    if measure:
        answer["measured"] = _measured(checked, accuracy, seconds)
    if as_json:
        click.echo(json.dumps(answer))
        return
    from springopt.report.tables import effects_table, engines_table

    click.echo(f"{answer['scene']}: {answer['title']}")
    click.echo(
        f"{answer['nodes']:,} nodes in {answer['dimension']} dimensions, {answer['springs']:,} springs, "
        f"{answer['kinematics']} kinematics"
    )
    if answer["motion"]:
        click.echo(_say_motion(**answer["motion"]))
    if answer["parameters"]:
        click.echo("fitted beside the stiffness: " + ", ".join(_say_parameter(**each) for each in answer["parameters"]))
    print_table(effects_table(answer["effects"]))
    print_table(engines_table(answer["supports"]))
    if measure:
        _print_measured(answer["measured"])


def _measured(scene: Scene, accuracy: float, seconds: float) -> dict[str, Any]:
    from springopt.analysis.effect_shares import effect_shares
    from springopt.analysis.point import choose_point

    setup = scene.build()
    with counting_bar() as show:
        point = choose_point(setup)
        return asdict(effect_shares(setup, point, accuracy=accuracy, seconds=seconds, progress=show))


def _print_measured(measured: dict[str, Any]) -> None:
    from springopt.report.tables import effect_shares_table

    click.echo(
        f"measured {measured['at']}, {measured['rounds']} rounds: {1e3 * measured['seconds']:.3g} ms of processor time "
        "for one candidate under all load cases"
    )
    if measured["shares"]:
        print_table(effect_shares_table(measured))
    for name, why in measured["left_out"].items():
        click.echo(f"{name} stays: {why}.")
    for sentence in measured["said"]:
        click.echo(sentence)


def _say_motion(integrator: str, step: float, times: list[float], steps: int | None) -> str:
    how = f"{steps:,} steps" if steps else "as many steps as their error takes,"
    moments = "1 time" if len(times) == 1 else f"{len(times):,} times"
    return f"motion until {times[-1]:g}, looked at {moments}: {how} of {step:g} at most, {integrator}"


def _say_parameter(name: str, numbers: int, lower: float, upper: float) -> str:
    count = f" ({numbers:,} numbers)" if numbers > 1 else ""
    return f"{name}{count} in [{lower:g}, {upper:g}]"
