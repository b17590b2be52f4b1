"""A job: one run of a benchmark. It is begun, taken up where it was cut short, or left alone where it is complete."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from springopt.benchmark.outcome import Outcome, done, elsewhere, failed, refused, refused_before, stopped
from springopt.budget import Budget
from springopt.errors import NotServed, PluginError, RunFileError, RunInUse, SceneError, UserError
from springopt.execution import Progress
from springopt.journal import Journal, holds_run, journal_path, require_unused
from springopt.optimizer import Optimizer
from springopt.options import make_optimizer
from springopt.registry import load_optimizer
from springopt.run import Order, Run
from springopt.runner import resume, solve
from springopt.scene import Scene, Setup
from springopt.start import is_run
from springopt.store import read_run

UNSUITED = "unsuited"  #: the word for a refusal that has none of its own
SCENES_AT_HAND = 8


@dataclass(frozen=True)
class Job:
    """One optimizer on one scene with one seed."""

    scene: str  #: the whole scene as JSON, as `Scene.to_json` writes it
    scene_name: str
    optimizer: str
    seed: int
    #: evaluations, seconds, solves, target; without any of them the scene's own budget holds
    limits: Mapping[str, float] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)  #: of the optimizer, over those of the scene
    label: str = ""  #: what the optimizer is called here; its name unless options differ
    start: str | None = None  #: the optimizer that runs first, or the run file whose best point is the first guess

    def __post_init__(self) -> None:
        if not self.label:
            object.__setattr__(self, "label", self.optimizer)
        for what, name in {"scene": self.scene_name, "label": self.label}.items():
            if name in (".", "..") or set(name) & set("/\\\0"):
                raise UserError(f"the {what} {name!r} of a job can't be the name of a folder; rename it.")

    @property
    def pair(self) -> tuple[str, str]:
        """The scene and the label, which all seeds share."""
        return self.scene_name, self.label

    def pair_folder(self, folder: Path) -> Path:
        """Where the runs of this optimizer on this scene lie."""
        return folder / self.scene_name / self.label

    def run_file(self, folder: Path) -> Path:
        """The run file that the job writes."""
        return self.pair_folder(folder) / f"seed{self.seed}.h5"


def require_legal(job: Job) -> None:
    """Refuses what no run could begin with: an unknown optimizer or start, illegal options or limits."""
    _optimizer(job)
    if job.start is not None and not is_run(job.start):
        _made(job.start, "{}")
    _budget(job)


def run_job(job: Job, folder: str | os.PathLike[str], *, progress: Progress | None = None) -> Outcome:
    """Runs a job to its end; a complete run file is left alone, and a run that was cut short is taken up.

    Raises KeyboardInterrupt after Ctrl-C; what the run found until then is in the folder.

    Args:
        folder: of results.
        progress: see `springopt.solve`.
    """
    place, began = Path(folder), time.perf_counter()
    outcome = ended_before(job, place) or _run(job, place, progress)
    return replace(outcome, took=time.perf_counter() - began)


def ended_before(job: Job, folder: Path) -> Outcome | None:
    """What came of a job, if that is in the folder; of a run that failed or was cut short nothing has come yet."""
    out = job.run_file(folder)
    try:
        if not out.exists():
            return refused_before(job, folder)
        order, run = read_run(out)
        _require_same(job, order, out)
    except RunFileError as error:
        return stopped(job, str(error))
    if not run.complete:
        return None
    for left in out.parent.glob(f"{journal_path(out).name}*"):  # by a process killed just after it wrote the run file
        left.unlink(missing_ok=True)
    return done(job, folder, run)


def at_work_elsewhere(job: Job, folder: Path) -> Outcome | None:
    """That another process is at this job; None where none is."""
    journal = journal_path(job.run_file(folder))
    try:
        if holds_run(journal):
            require_unused(journal)
    except RunInUse as error:
        return elsewhere(job, str(error))
    return None


def _run(job: Job, folder: Path, progress: Progress | None) -> Outcome:
    out = job.run_file(folder)
    try:
        run = _resumed(job, out, progress) if _was_begun(out) else _begun(job, out, progress)
    except NotServed as error:
        return refused(job, folder, error.word, str(error))
    except RunInUse as error:
        return elsewhere(job, str(error))
    except (SceneError, RunFileError) as error:
        # Another call with the same folder may have ended it since.
        return ended_before(job, folder) or stopped(job, str(error))
    except PluginError as error:
        return failed(job, folder, str(error))
    except UserError as error:
        asked = journal_path(out).exists()  # before its first question an optimizer says that a scene is not for it
        return failed(job, folder, str(error)) if asked else refused(job, folder, UNSUITED, str(error))
    except MemoryError as error:
        return failed(job, folder, f"there is not enough memory for this run ({error}); run fewer at a time.")
    except Exception as error:
        if os.environ.get("SPRINGOPT_TRACEBACK"):
            raise
        return failed(job, folder, f"springopt failed ({type(error).__name__}: {error}), and that is its own fault.")
    if not run.complete:
        raise KeyboardInterrupt
    return done(job, folder, run)


def _was_begun(out: Path) -> bool:
    return out.exists() or holds_run(journal_path(out))


def _begun(job: Job, out: Path, progress: Progress | None) -> Run:
    out.parent.mkdir(parents=True, exist_ok=True)
    if journal_path(out).exists():  # the empty file of a run that was killed before it began
        require_unused(journal_path(out))
        journal_path(out).unlink(missing_ok=True)
    limits: dict[str, Any] = dict(job.limits)
    with threadpool_limits(1, user_api="blas"):  # the reference's bits may depend on it too
        return solve(
            _scene(job.scene),
            _optimizer(job),
            start=job.start,
            seed=job.seed,
            out=out,
            setup=_setup(job.scene),
            progress=progress,
            **limits,
        )


def _resumed(job: Job, out: Path, progress: Progress | None) -> Run:
    if holds_run(journal_path(out)):
        with Journal.open(journal_path(out)) as journal:
            _require_same(job, journal.order, out)
    if not _was_begun(out):  # a journal without any answer was no run
        return _begun(job, out, progress)
    with threadpool_limits(1, user_api="blas"):
        return resume(out, progress=progress)


def _require_same(job: Job, order: Order, out: Path) -> None:
    """Refuses to take another job's result for this one's."""
    differs = {
        "scene": order.scene != job.scene and _digest(order.scene) != _digest(job.scene),
        "optimizer": order.optimizer != job.optimizer,
        "options": json.dumps(order.options) != json.dumps(asdict(_optimizer(job))),
        "seed": order.seed != job.seed,
        "budget": order.budget != asdict(_budget(job)),
        "start": _start_of(order) != job.start,
    }
    for what, other in differs.items():
        if other:
            raise RunFileError(f"{out} is a run with another {what}; choose another folder.")


def _start_of(order: Order) -> str | None:
    """What the start was called when it was asked for."""
    return str(order.start["options"].get("run") or order.start["name"]) if order.start else None


def _budget(job: Job) -> Budget:
    limits: dict[str, Any] = dict(job.limits) or _scene(job.scene).budget.model_dump()
    return Budget(**limits)


def _optimizer(job: Job) -> Optimizer:
    options = {**_scene(job.scene).optimizer_options(job.optimizer), **job.options}
    return _made(job.optimizer, json.dumps(options, sort_keys=True))


@lru_cache
def _made(name: str, options: str) -> Optimizer:
    """Kept, because finding it takes as long as a short run."""
    return make_optimizer(load_optimizer(name), json.loads(options))


@lru_cache(SCENES_AT_HAND)
def _scene(text: str) -> Scene:
    return Scene.from_json(text)


@lru_cache(SCENES_AT_HAND)
def _digest(scene: str) -> str:
    return _scene(scene).digest_with_tests()


@lru_cache(1)
def _setup(text: str) -> Setup:
    """Of the latest scene alone: it may be large, and jobs come scene by scene."""
    return _scene(text).build()
