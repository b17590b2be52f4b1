"""`springopt list`: what there is to choose from."""

from __future__ import annotations

import json
import sys
from contextlib import redirect_stdout
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from springopt.cli.main import COMMANDS
from springopt.cli.results import print_table
from springopt.errors import UserError, did_you_mean

if TYPE_CHECKING:
    from springopt.effects.effect import Effect
    from springopt.optimizer import Optimizer
    from springopt.options import Option

#: What an effect may bring, by the method that it overrides.
BROUGHT = {
    "constant_forces": "constant forces",
    "rest_lengths": "rest lengths",
    "potential": "a potential",
    "dissipation": "a dissipation",
    "masses": "masses",
}


@click.command("list", short_help=COMMANDS["list"])
@click.argument("kind", type=click.Choice(["optimizers", "effects", "scenes"]))
@click.argument("name", required=False)
@click.option("--floors", is_flag=True, help="With each scene its unknowns, its start and the lowest value known.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")
def command(kind: str, name: str | None, floors: bool, as_json: bool) -> None:
    """List the optimizers, the effects or the scenes.

    With a NAME: the options of one optimizer or effect, one scene's text, or the scenes of one group.
    """
    if kind == "scenes":
        _scenes(name, floors, as_json)
    elif floors:
        raise UserError(f"--floors is of scenes, and {kind} have none; leave it out.")
    elif kind == "effects":
        _effects(name, as_json)
    else:
        _optimizers(name, as_json)


def _optimizers(name: str | None, as_json: bool) -> None:
    from springopt.registry import load_optimizer, optimizers

    with redirect_stdout(sys.stderr):  # a stranger's module may print while it is imported
        classes = {name: load_optimizer(name)} if name is not None else optimizers()
    entries = [_optimizer(name, optimizer) for name, optimizer in classes.items()]
    if as_json:
        click.echo(json.dumps(entries if name is None else entries[0]))
        return
    from springopt.report.tables import optimizers_table

    if name is None:
        print_table(optimizers_table(entries))
    else:
        _print_options(entries[0])


def _effects(name: str | None, as_json: bool) -> None:
    from springopt.registry import effects, load_effect

    with redirect_stdout(sys.stderr):  # a stranger's module may print while it is imported
        classes = {name: load_effect(name)} if name is not None else effects()
    entries = [_effect(name, effect) for name, effect in classes.items()]
    if as_json:
        click.echo(json.dumps(entries if name is None else entries[0]))
        return
    from springopt.report.tables import installed_effects_table

    if name is None:
        print_table(installed_effects_table(entries))
    else:
        _print_options(entries[0])


def _print_options(entry: dict[str, Any]) -> None:
    from springopt.report.tables import options_table

    click.echo(f"{entry['name']} ({entry['distribution']}): {entry['summary']}")
    print_table(
        options_table(
            option | {"default": "required" if option.get("required") else _as_set(option["default"])}
            for option in entry["options"]
        )
    )


def _as_set(default: Any) -> str:
    """A default as `--set` takes it."""
    if default is None or isinstance(default, bool):
        return str(default).lower()
    return ",".join(map(str, default)) if isinstance(default, tuple) else str(default)


def _optimizer(name: str, optimizer: type[Optimizer]) -> dict[str, Any]:
    from springopt.options import options_of

    options = [_option(option) for option in options_of(optimizer)]
    return {**_head(name, optimizer), "needs": sorted(optimizer.needs), "options": options}


def _effect(name: str, effect: type[Effect]) -> dict[str, Any]:
    from springopt.effects.effect import Effect
    from springopt.registry import effect_options

    options = [
        _option(option) | {"default": None if option.is_required else option.default, "required": option.is_required}
        for option in effect_options(effect)
    ]
    brings = [what for method, what in BROUGHT.items() if getattr(effect, method) is not getattr(Effect, method)]
    return {**_head(name, effect), "brings": brings, "options": options}


def _head(name: str, plugin: type[Optimizer] | type[Effect]) -> dict[str, Any]:
    from springopt.registry import distribution_of

    distribution = distribution_of(plugin)
    return {
        "name": name,
        "distribution": distribution.name if distribution else "unknown",
        "summary": (plugin.__doc__ or "").strip().partition("\n")[0],
    }


def _option(option: Option) -> dict[str, Any]:
    return {
        "name": option.name,
        "type": option.type_name,
        "default": option.default,
        "explanation": option.explanation,
    }


def _scenes(name: str | None, floors: bool, as_json: bool) -> None:
    from springopt.scene.bundled import bundled_scenes, scene_file

    heads = bundled_scenes()
    file = scene_file(name) if name is not None else None
    if name is not None and file is not None:
        text = file.read_text(encoding="utf-8")
        click.echo(json.dumps(asdict(heads[name]) | {"text": text}) if as_json else text, nl=as_json)
        return
    entries = [asdict(head) for head in heads.values() if name in (None, head.group)]
    if floors:
        entries = [entry | _floor(entry["name"]) for entry in entries]
    if not entries:
        groups = list(dict.fromkeys(head.group for head in heads.values() if head.group))
        raise UserError(
            f"there is no scene and no group of scenes {name!r}; the groups are {', '.join(groups)}."
            f"{did_you_mean(str(name), [*heads, *groups])} `springopt list scenes` names all scenes."
        )
    if as_json:
        click.echo(json.dumps(entries))
        return
    from springopt.report.tables import floors_table, scenes_table

    print_table(floors_table(entries) if floors else scenes_table(entries))


def _floor(name: str) -> dict[str, Any]:
    """Unknowns, start and floor of a scene; None where none is stored for its present state."""
    from springopt.analysis.known_floor import floor_file, read_floor
    from springopt.scene import load_scene

    scene, floor = load_scene(name), read_floor(floor_file(name))
    unknowns = scene.encoding.build(scene.lattice.build()).size
    if floor is None or floor.digest != scene.digest():
        return {"unknowns": unknowns, "start": None, "floor": None, "proven": None, "evidence": None}
    return {
        "unknowns": unknowns,
        "start": floor.start,
        "floor": floor.value,
        "proven": floor.proof is not None,
        "evidence": floor.evidence,
    }
