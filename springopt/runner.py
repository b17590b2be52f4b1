"""Runs: a new one from its order to its end, and one that was cut short from there on."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from dataclasses import asdict
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

from springopt.budget import Budget
from springopt.errors import RunFileError, UserError, did_you_mean
from springopt.execution import Progress, execute
from springopt.journal import Journal, holds_run, journal_path, run_path
from springopt.optimizer import Optimizer
from springopt.options import make_optimizer
from springopt.origin import require_this_origin, this_origin
from springopt.registry import installed, load_optimizer
from springopt.run import Order, Run
from springopt.start import EarlierRun, is_run, load_start, read_start, require_fits
from springopt.store import read, read_answers, require_same_run

if TYPE_CHECKING:
    from springopt.scene import Scene, Setup

__all__ = ["Progress", "resume", "solve"]

LOOSEST = 0.01  # a tolerance; beyond it an equilibrium is not near enough to be told from a saddle, which takes longer


def solve(
    scene: Scene | str | os.PathLike[str] = "paper-fem-2d",
    optimizer: str | Optimizer = "paper-ga",
    *,
    start: str | os.PathLike[str] | Optimizer | None = None,
    seed: int = 0,
    evaluations: int | None = None,
    seconds: float | None = None,
    solves: int | None = None,
    target: float | None = None,
    options: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | None = None,
    setup: Setup | None = None,
    threads: int = 1,
    loosest_tolerance: float | None = None,
    progress: Progress | None = None,
) -> Run:
    """Runs an optimizer on a scene until its budget is spent, and says what came of it.

    Ctrl-C ends the run between two answers: the run file is then complete up to the last answer, and the Run says so.

    Args:
        scene: a scene, its path, or the name of a bundled one.
        optimizer: its name, or one made ready.
        start: what gives the optimizer its first guess: another one that runs first, on the same budget, until it is
            content (its name, or one made ready), or a run file whose best point it is.
        seed: of all randomness.
        evaluations, seconds, solves, target: see `Budget`; without any of them the scene's own budget holds.
        options: of a named optimizer, over those of the scene.
        out: the run file to write. Beside it lies `<out>.journal` while the run lasts, for `resume`.
        setup: of the same scene, made ready by an earlier `scene.build()`: no bit of the run depends on it.
        threads: that share the forward solves of a batch; no bit of the run depends on their number.
        loosest_tolerance: of the forward solve, by which an optimizer that asks for the best of a batch may get them
            while their values are spread; up to 0.01. Then these are no longer those of the scene's own tolerance to
            the bit, but the best value, its history and the target always rest on that; the Run says how often
            selections were loose, were compared, and differed. By default all solves have the scene's own.
        progress: called up to ten times a second with the evaluations spent, of how many (None if they are not
            limited), the best value and the seconds.
    """
    from springopt.scene import load_scene

    if isinstance(scene, str | os.PathLike):
        scene = load_scene(scene)
    optimizer = _ready(optimizer, scene, options)
    first = None if start is None else _first(start, scene)
    limits = {"evaluations": evaluations, "seconds": seconds, "solves": solves, "target": target}
    order = _order(scene, optimizer, first, seed, limits, loosest_tolerance)
    if out is not None:
        _require_new(Path(out))
    if setup is not None and setup.scene != scene:
        raise UserError(f"the setup is of scene {setup.scene.name}, not of {scene.name}; give the one of this scene.")
    setup = setup or scene.build(threads=threads)
    if loosest_tolerance is not None:
        _require_loosest(loosest_tolerance, setup.objective.tolerance)
    if isinstance(first, EarlierRun):
        require_fits(first, setup.encoding)
    if out is None:
        return execute(order, setup, optimizer, start=first, progress=progress)
    with Journal.create(journal_path(Path(out)), order) as journal:
        _require_new(Path(out))  # once more: another run may have ended here since
        return execute(order, setup, optimizer, journal, start=first, progress=progress)


def resume(path: str | os.PathLike[str], *, threads: int = 1, progress: Progress | None = None) -> Run:
    """Takes up a run that was interrupted or killed, as if it had never stopped; a complete one is only read.

    Args:
        path: the run file or its journal; where both are there, the journal is the newer.
        threads, progress: see `solve`.
    """
    from springopt.scene import Scene

    out = run_path(Path(path))
    if not holds_run(journal_path(out)):
        contents = read(out)
        if contents.run.complete:
            return contents.run
        _write_journal(out, contents.order)
    with Journal.open(journal_path(out)) as journal:
        order = journal.order
        kind, first = _kinds(order)
        require_this_origin(order.origin, str(out), kind, first)
        require_same_run(out, order)
        optimizer = make_optimizer(kind, order.options)
        start = make_optimizer(first, order.start["options"]) if first and order.start else None
        setup = Scene.from_json(order.scene).build(threads=threads)
        return execute(order, setup, optimizer, journal, start=start, progress=progress)


def _ready(optimizer: str | Optimizer, scene: Scene, options: Mapping[str, Any] | None) -> Optimizer:
    if isinstance(optimizer, str):
        _warn_of_strangers(scene)
        return make_optimizer(load_optimizer(optimizer), {**scene.optimizer_options(optimizer), **(options or {})})
    if options:
        raise UserError("options are for an optimizer given by name; set those of one made ready when it is made.")
    return optimizer


def _order(
    scene: Scene,
    optimizer: Optimizer,
    first: Optimizer | None,
    seed: int,
    limits: Mapping[str, Any],
    loosest_tolerance: float | None,
) -> Order:
    """What is asked for; without any limit the scene's own budget holds."""
    unlimited = all(limit is None for limit in limits.values())
    return Order(
        scene=scene.to_json(),
        optimizer=optimizer.name,
        options=asdict(optimizer),
        seed=_require_seed(seed),
        budget=asdict(Budget(**(scene.budget.model_dump() if unlimited else limits))),
        origin=this_origin(type(optimizer), type(first) if first else None),
        start={"name": first.name, "options": asdict(first)} if first else None,
        loosest_tolerance=loosest_tolerance,
    )


def _first(start: str | os.PathLike[str] | Optimizer, scene: Scene) -> Optimizer:
    """What runs before the optimizer, made ready."""
    if isinstance(start, Optimizer):
        return start
    return read_start(start) if is_run(start) else _ready(os.fspath(start), scene, None)


def _kinds(order: Order) -> tuple[type[Optimizer], type[Optimizer] | None]:
    """The optimizer that an order names, and its start."""
    return load_optimizer(order.optimizer), load_start(order.start["name"]) if order.start else None


def _warn_of_strangers(scene: Scene) -> None:
    """One line for each table of options whose optimizer is not installed, where its name is likely a slip."""
    known = installed()
    for name in scene.optimizers:
        if name not in known and (hint := did_you_mean(name, known)):
            warnings.warn(
                f"the scene sets options of optimizer {name!r}, which is not installed.{hint}",
                RuntimeWarning,
                stacklevel=4,
            )


def _require_seed(seed: int) -> int:
    if isinstance(seed, bool) or not isinstance(seed, Integral) or seed < 0:
        raise UserError(f"the seed must be a whole number from 0 on, not {seed!r}; give another.")
    return int(seed)


def _require_loosest(tolerance: float, own: float) -> None:
    if not own < tolerance <= LOOSEST:
        raise UserError(
            f"loosest_tolerance lies above the scene's own {own:g} and is at most {LOOSEST:g}, not {tolerance!r}; "
            "give one between them."
        )


def _require_new(out: Path) -> None:
    if out.suffix == ".journal":
        raise RunFileError(f"{out} is the name of a journal, and journals end so; choose another, as RUN.h5.")
    if out.exists():
        raise RunFileError(f"{out} exists already, and nothing is overwritten; choose another output.")


def _write_journal(out: Path, order: Order) -> None:
    """The journal of an interrupted run again, from the answers in its run file."""
    require_this_origin(order.origin, str(out), *_kinds(order))
    journal_path(out).unlink(missing_ok=True)
    Journal.create(journal_path(out), order, read_answers(out)).close()
