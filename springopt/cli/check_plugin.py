"""`springopt check-plugin`: whether an optimizer keeps the contract, and if not, what to mend."""

from __future__ import annotations

import json
import sys
from contextlib import redirect_stdout
from dataclasses import asdict

import click

from springopt.cli.main import COMMANDS
from springopt.cli.results import print_table


@click.command("check-plugin", short_help=COMMANDS["check-plugin"])
@click.argument("name")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of a table.")
def command(name: str, as_json: bool) -> int:
    """Check on small problems that the installed optimizer NAME keeps the contract, and say what to mend.

    Exit code 0 if it passed every check, 1 if not, 2 if there is no such optimizer or it can't be loaded.
    """
    from springopt.registry import load_optimizer
    from springopt.testing import examine

    with redirect_stdout(sys.stderr):  # standard output is ours: optimizers may print
        findings = [asdict(finding) for finding in examine(load_optimizer(name))]
    passed = all(finding["verdict"] == "passed" for finding in findings)
    if as_json:
        click.echo(json.dumps({"optimizer": name, "passed": passed, "checks": findings}))
    else:
        from springopt.report.tables import checks_table

        print_table(checks_table(name, findings))
        click.echo(f"{name} keeps the contract." if passed else f"{name} does not keep the contract: mend what failed.")
    return 0 if passed else 1
