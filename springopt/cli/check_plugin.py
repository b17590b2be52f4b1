"""`springopt check-plugin`: whether an optimizer or an effect keeps the contract, and if not, what to mend."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from springopt.cli.main import COMMANDS
from springopt.cli.results import print_table
from springopt.cli.settings import settings_of
from springopt.errors import PluginError, did_you_mean

if TYPE_CHECKING:
    from springopt.testing import Finding


@click.command("check-plugin", short_help=COMMANDS["check-plugin"])
@click.argument("name")
@click.option("--set", "settings", multiple=True, metavar="OPTION=VALUE", help="Set an option of the plugin.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of a table.")
def command(name: str, settings: tuple[str, ...], as_json: bool) -> int:
    """Check on small problems that the installed optimizer or effect NAME keeps the contract, and say what to mend.

    An effect whose options have no defaults needs them by --set: gravity in two dimensions is

        springopt check-plugin gravity --set acceleration=0,-9.81

    Exit code 0 if it passed every check, 1 if not, 2 if there is no such plugin or it can't be loaded.
    """
    options = settings_of(settings)
    with redirect_stdout(sys.stderr):  # standard output is ours: plugins may print
        kind, found = _examine(name, options)
    findings = [asdict(finding) for finding in found]
    passed = all(finding["verdict"] == "passed" for finding in findings)
    if as_json:
        click.echo(json.dumps({kind: name, "passed": passed, "checks": findings}))
    else:
        from springopt.report.tables import checks_table

        print_table(checks_table(name, findings))
        click.echo(f"{name} keeps the contract." if passed else f"{name} does not keep the contract: mend what failed.")
    return 0 if passed else 1


def _examine(name: str, options: Mapping[str, str]) -> tuple[str, list[Finding]]:
    """The kind of plugin that has this name, an optimizer before an effect, and what its checks find."""
    from springopt.options import make_optimizer, make_plugin
    from springopt.registry import effect_options, installed, installed_effects, load_effect, load_optimizer

    optimizers, effects = installed(), installed_effects()
    if name in optimizers:
        from springopt.testing import examine

        optimizer = load_optimizer(name)
        return "optimizer", examine(make_optimizer(optimizer, options) if options else optimizer)
    if name not in effects:
        names = [*optimizers, *effects]
        raise PluginError(
            f"there is no optimizer {name!r}, nor an effect; installed: {', '.join(names)}.{did_you_mean(name, names)}"
        )
    from springopt.testing import examine_effect

    effect = load_effect(name)
    return "effect", examine_effect(make_plugin(effect, name, effect_options(effect), options))
