"""`springopt`: finds the command, runs it, and turns whatever went wrong into a sentence and an exit code."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from typing import Any

import click

from springopt.errors import UserError, did_you_mean

#: Each command lives in the module of its name; the help is here so that `--help` imports none of them.
COMMANDS = {
    "solve": "Find the mass-spring model that deforms like a scene's reference.",
    "benchmark": "Run many optimizers on many scenes, each with several seeds.",
    "simulate": "Deform a mass-spring model of given stiffness under a scene's load cases.",
    "explain": "Say which engine solves a scene's load cases, and why.",
    "identify": "Say which springs a scene's load cases identify, and how well.",
    "tradeoff": "Measure what accuracy costs in time, on a scene and this machine.",
    "floor": "Compute and store the lowest value known of a scene.",
    "reproduce": "Make every figure and table of the paper again, ours beside it.",
    "show": "Show what a run found, as tables and as a figure.",
    "compare": "Compare optimizers by their runs: how close, how fast, and how sure that is.",
    "list": "List the optimizers, effects and scenes that there are.",
    "check-plugin": "Check that an optimizer or an effect keeps the contract, and say what to mend.",
}


class LazyGroup(click.Group):
    """Imports a command's module when the command is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        return import_module(f"springopt.cli.{cmd_name.replace('-', '_')}").command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            known = ", ".join(COMMANDS)
            ctx.fail(f"There is no command {args[0]!r}; there are {known}.{did_you_mean(args[0], COMMANDS)}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="springopt")
def springopt() -> None:
    """Finds the mass-spring model that deforms like a given body: which nodes to connect, and how stiff each spring is.

    Start with `springopt solve`, which runs the main experiment of Bianchi et al. (2004).
    """


def main() -> None:
    """Entry point of the `springopt` command."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: Sequence[str]) -> int:
    """Run one command line; 0 when done, 2 for the user's mistake, 1 for our own fault, 130 after Ctrl-C.

    `check-plugin` ends with 1 for a fault that it found.
    """
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _warn_in_one_line
            code = springopt.main(list(arguments), prog_name="springopt", standalone_mode=False)
        return code if isinstance(code, int) else 0
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except UserError as error:
        if os.environ.get("SPRINGOPT_TRACEBACK") and error.__cause__:
            raise
        _say(f"Error: {error}")
        return 2
    except (KeyboardInterrupt, click.Abort):
        _say("Interrupted.")
        return 130
    except MemoryError as error:
        detail = f" ({error})" if str(error) else ""
        _say(f"Error: there is not enough memory for this{detail}; choose a smaller scene or batch.")
        return 2
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the reader left: nothing to flush at exit
        return 1
    except Exception as error:
        if os.environ.get("SPRINGOPT_TRACEBACK"):
            raise
        _say(
            f"springopt failed ({type(error).__name__}: {error}), and that is its own fault; "
            "set SPRINGOPT_TRACEBACK=1 to see where, and report it."
        )
        return 1


def _warn_in_one_line(message: Any, *_: Any, **__: Any) -> None:
    _say(f"Warning: {message}")


def _say(sentence: str) -> None:
    click.echo(sentence, err=True)
