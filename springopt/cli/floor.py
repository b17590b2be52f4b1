"""`springopt floor`: the lowest value known of a scene, computed and stored."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from springopt.cli.bar import counting_bar
from springopt.cli.main import COMMANDS
from springopt.cli.runs import read_run
from springopt.errors import UserError

if TYPE_CHECKING:
    from springopt.analysis.floor_search import Progress
    from springopt.analysis.known_floor import Floor
    from springopt.scene import Scene


@click.command("floor", short_help=COMMANDS["floor"])
@click.argument("scene")
@click.option(
    "--starts", type=click.IntRange(min=1), default=20, show_default=True, help="From which it is looked for."
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the starts.")
@click.option("--from", "run", metavar="RUN.h5", help="Take the best point of a run instead, if it is lower.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")
def command(scene: str, starts: int, seed: int, run: str | None, as_json: bool) -> None:
    """Compute the lowest value known of SCENE in its own misfit, and store it; a stored one is replaced if beaten.

    A bundled scene's floor is stored in the package, that of a file of your own beside it, as SCENE.floor.json.
    """
    from springopt.analysis.known_floor import floor_file, store_floor
    from springopt.scene import load_scene

    loaded, path = load_scene(scene), floor_file(scene)
    found = _computed(loaded, starts, seed) if run is None else _of_run(loaded, run)
    stored = store_floor(path, found)
    if as_json:
        click.echo(json.dumps(asdict(stored) | {"file": str(path)}))
        return
    _print(stored)
    kept = "" if stored == found else f", which was kept: {found.value:.9g} is not lower"
    click.echo(f"Stored in {path}{kept}")


def _computed(scene: Scene, starts: int, seed: int) -> Floor:
    from springopt.analysis.floor import compute_floor

    with _progress_bar() as progress:
        return compute_floor(scene.build(), starts=starts, seed=seed, progress=progress)


def _of_run(scene: Scene, path: str) -> Floor:
    from springopt.analysis.floor import floor_at

    run = read_run(path).run
    if run.scene_digest != scene.digest():
        raise UserError(f"{path} is a run on another scene, or on another state of {scene.name}; give one on this.")
    source = f"{run.method}, seed {run.seed}, {run.evaluations} evaluations"
    return floor_at(scene.build(), run.point, source)


@contextmanager
def _progress_bar() -> Iterator[Progress | None]:
    """A bar over the descents, with the lowest value."""
    with counting_bar() as show:
        yield show and (lambda done, total, lowest: show(done, total, f"lowest {lowest:.6g}"))


def _print(floor: Floor) -> None:
    evidence = floor.evidence
    sure = "best known" if floor.proof is None else f"proven: {floor.proof}"
    click.echo(f"{floor.scene}: floor {floor.value:.12g} ({floor.minimize}), {sure}")
    if "starts" in evidence:
        click.echo(
            f"{evidence['agreed']} of {evidence['starts']} starts ended there, spread {evidence['spread']:.2g}; "
            f"{evidence['evaluations']:,} evaluations; {evidence['method']}"
        )
    else:
        click.echo(f"found by: {evidence['method']}")
    if floor.start is not None:
        click.echo(f"{floor.start_said} {floor.start:.6g}")
