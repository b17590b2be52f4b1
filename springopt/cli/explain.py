"""`springopt explain`: what the forward solve makes of a scene, before anything is solved."""

from __future__ import annotations

import json
from dataclasses import asdict

import click

from springopt.cli.main import COMMANDS
from springopt.cli.results import print_table


@click.command("explain", short_help=COMMANDS["explain"])
@click.argument("scene")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")
def command(scene: str, as_json: bool) -> None:
    """Say which effects a scene has, and which engine solves its load cases, and why."""
    from springopt.scene import load_scene
    from springopt.scene.explain import explain

    answer = asdict(explain(load_scene(scene)))
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


def _say_motion(integrator: str, step: float, times: list[float], steps: int | None) -> str:
    how = f"{steps:,} steps" if steps else "as many steps as their error takes,"
    moments = "1 time" if len(times) == 1 else f"{len(times):,} times"
    return f"motion until {times[-1]:g}, looked at {moments}: {how} of {step:g} at most, {integrator}"


def _say_parameter(name: str, numbers: int, lower: float, upper: float) -> str:
    count = f" ({numbers:,} numbers)" if numbers > 1 else ""
    return f"{name}{count} in [{lower:g}, {upper:g}]"
