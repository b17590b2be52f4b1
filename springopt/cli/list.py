"""`springopt list`: what there is to choose from."""

from __future__ import annotations

import json
import sys
from contextlib import redirect_stdout
from typing import TYPE_CHECKING, Any

import click

from springopt.cli.main import COMMANDS
from springopt.cli.results import print_table
from springopt.errors import UserError, did_you_mean

if TYPE_CHECKING:
    from springopt.optimizer import Optimizer


@click.command("list", short_help=COMMANDS["list"])
@click.argument("kind", type=click.Choice(["optimizers", "scenes"]))
@click.argument("name", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")
def command(kind: str, name: str | None, as_json: bool) -> None:
    """List the optimizers or the bundled scenes; with a NAME, one optimizer's options or one scene's text."""
    {"optimizers": _optimizers, "scenes": _scenes}[kind](name, as_json)


def _optimizers(name: str | None, as_json: bool) -> None:
    from springopt.registry import load_optimizer, optimizers

    with redirect_stdout(sys.stderr):  # a stranger's module may print while it is imported
        classes = {name: load_optimizer(name)} if name is not None else optimizers()
    entries = [_optimizer(name, optimizer) for name, optimizer in classes.items()]
    if as_json:
        click.echo(json.dumps(entries if name is None else entries[0]))
        return
    from springopt.report.tables import optimizers_table, options_table

    if name is None:
        print_table(optimizers_table(entries))
    else:
        options = entries[0]["options"]
        click.echo(f"{name} ({entries[0]['distribution']}): {entries[0]['summary']}")
        print_table(options_table([option | {"default": _as_set(option["default"])} for option in options]))


def _as_set(default: Any) -> str:
    """A default as `--set` takes it."""
    if default is None or isinstance(default, bool):
        return str(default).lower()
    return ",".join(map(str, default)) if isinstance(default, tuple) else str(default)


def _optimizer(name: str, optimizer: type[Optimizer]) -> dict[str, Any]:
    from springopt.options import options_of
    from springopt.registry import distribution_of

    distribution = distribution_of(optimizer)
    return {
        "name": name,
        "distribution": distribution.name if distribution else "unknown",
        "summary": (optimizer.__doc__ or "").strip().partition("\n")[0],
        "needs": sorted(optimizer.needs),
        "options": [
            {
                "name": option.name,
                "type": option.type_name,
                "default": option.default,
                "explanation": option.explanation,
            }
            for option in options_of(optimizer)
        ],
    }


def _scenes(name: str | None, as_json: bool) -> None:
    from springopt.scene.bundled import bundled_scenes, bundled_text

    titles = bundled_scenes()
    if name is None:
        entries = [{"name": scene, "title": title} for scene, title in titles.items()]
        if as_json:
            click.echo(json.dumps(entries))
        else:
            from springopt.report.tables import scenes_table

            print_table(scenes_table(entries))
        return
    text = bundled_text(name)
    if text is None:
        raise UserError(
            f"there is no bundled scene {name!r}; name one of {', '.join(titles)}.{did_you_mean(name, titles)}"
        )
    click.echo(json.dumps({"name": name, "title": titles[name], "text": text}) if as_json else text, nl=as_json)
