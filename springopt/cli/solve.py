"""`springopt solve`: one run from start to end, or one that was cut short from there on."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springopt.cli.bar import counting_bar
from springopt.cli.floors import place_of, with_floor
from springopt.cli.main import COMMANDS
from springopt.cli.results import print_run
from springopt.cli.runs import require_no_folder
from springopt.cli.settings import settings_of
from springopt.errors import UserError

if TYPE_CHECKING:
    from springopt.execution import Progress
    from springopt.run import Run

DEFAULT_SCENE = "paper-fem-2d"
DEFAULT_OPTIMIZER = "paper-ga"


@click.command("solve", short_help=COMMANDS["solve"])
@click.argument("scene", default=DEFAULT_SCENE)
@click.option("--optimizer", default=DEFAULT_OPTIMIZER, show_default=True, help="See `springopt list optimizers`.")
@click.option("--set", "settings", multiple=True, metavar="NAME=VALUE", help="An option of the optimizer; repeatable.")
@click.option("--start", metavar="NAME|RUN.h5", help="Begin at what this optimizer finds, or at a run's best point.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of all randomness.")
@click.option("--evaluations", type=int, help="Candidate evaluations that the run may cost.")
@click.option("--seconds", type=float, help="Seconds that the run may take.")
@click.option("--solves", type=int, help="Forward solves that the run may cost.")
@click.option("--target", type=float, help="Objective at which the run may stop.")
@click.option("--out", metavar="RUN.h5", help="Run file to write.  [default: SCENE-OPTIMIZER-seedN.h5 in this folder]")
@click.option("--resume", "resumed", metavar="RUN.h5", help="Go on with a run that was interrupted or killed.")
@click.option(
    "--threads",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help="That share the forward solves of a batch; the result is the same to the bit.",
)
@click.option(
    "--loosest-tolerance",
    type=float,
    metavar="TOLERANCE",
    help="Up to which solves may be loose while the values of a batch are spread, as 1e-3.  [default: the scene's own]",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")
@click.pass_context
def command(ctx: click.Context, /, resumed: str | None, threads: int, as_json: bool, **order: Any) -> int:
    """Find the mass-spring model that deforms like the reference of SCENE, a TOML file or a bundled scene's name.

    Without SCENE: the main experiment of Bianchi et al. (2004). Without a limit on evaluations, seconds, solves or a
    target the scene's own budget holds.
    """
    if resumed is not None:
        _require_alone(ctx)
    run = _resume(resumed, threads) if resumed is not None else _solve(threads=threads, **order)
    place = place_of(run, [Path(str(run.run if resumed else order["scene"])).parent])
    if as_json:
        click.echo(with_floor(run, place))
    else:
        print_run(run, place.said)
        click.echo(f"Look at it: springopt show {run.run} --figure {str(run.run).removesuffix('.h5')}.png")
    if not run.complete:
        click.echo(f"Interrupted; go on with: springopt solve --resume {run.run}", err=True)
    return 0 if run.complete else 130


def _solve(
    scene: str,
    optimizer: str,
    settings: tuple[str, ...],
    start: str | None,
    seed: int,
    out: str | None,
    threads: int,
    loosest_tolerance: float | None,
    **limits: int | float | None,
) -> Run:
    from springopt.runner import solve
    from springopt.scene import load_scene

    options = settings_of(settings)
    loaded = load_scene(scene)
    path = out if out is not None else _default_out(f"{loaded.name}-{optimizer}{_from(start)}-seed{seed}.h5")
    with redirect_stdout(sys.stderr), _progress_bar() as progress:  # standard output is ours: optimizers may print
        return solve(
            loaded,
            optimizer,
            start=start,
            seed=seed,
            options=options,
            out=path,
            threads=threads,
            loosest_tolerance=loosest_tolerance,
            progress=progress,
            **limits,  # type: ignore[arg-type]
        )


def _resume(path: str, threads: int) -> Run:
    from springopt.runner import resume

    with redirect_stdout(sys.stderr), _progress_bar() as progress:
        return resume(require_no_folder(path), threads=threads, progress=progress)


def _require_alone(ctx: click.Context) -> None:
    """A resumed run keeps its scene, optimizer, seed and budget: setting them again is refused, not ignored."""
    given = [
        param.opts[0]
        for param in ctx.command.params
        if param.name not in ("resumed", "threads", "as_json", "help")
        and ctx.get_parameter_source(str(param.name)) is click.core.ParameterSource.COMMANDLINE
    ]
    if given:
        raise UserError(f"--resume goes on with the run as it was ordered; leave out {', '.join(given)}.")


def _default_out(name: str) -> str:
    if Path(name).exists():
        raise UserError(f"{name} exists already, and nothing is overwritten; name another run file with --out.")
    return name


def _from(start: str | None) -> str:
    """What a run file's name says of a start."""
    return f"-from-{Path(start).stem}" if start else ""


@contextmanager
def _progress_bar() -> Iterator[Progress | None]:
    """A bar over the evaluations, with the best value."""
    with counting_bar() as show:
        yield show and (lambda done, total, best, seconds: show(done, total, f"best {best:.4g}"))
