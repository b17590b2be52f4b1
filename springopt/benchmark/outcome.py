"""What came of a job, as it is told to people and as it lies in a folder of results."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from springopt.benchmark.build import build_of
from springopt.errors import UserError
from springopt.run import Run

if TYPE_CHECKING:
    from springopt.benchmark.job import Job

REFUSED = "refused.json"


@dataclass(frozen=True)
class Outcome:
    """What came of one job."""

    scene: str
    label: str
    seed: int
    state: Literal["done", "refused", "failed", "elsewhere"]  #: elsewhere: another process is at this run
    run: str | None = None  #: path of the run file
    objective: float | None = None
    evaluations: int | None = None
    seconds: float | None = None  #: of the run
    took: float = 0.0  #: seconds of this call, with all that is around the run
    word: str | None = None  #: why the optimizer can't serve the scene
    sentence: str | None = None  #: the same in a sentence, or how the run failed, or who is at it

    @property
    def pair(self) -> tuple[str, str]:
        """As of its job."""
        return self.scene, self.label

    def to_dict(self) -> dict[str, Any]:
        """What is known of it, for JSON."""
        return {name: value for name, value in asdict(self).items() if value is not None}


def done(job: Job, folder: Path, run: Run) -> Outcome:
    """A run that has ended; what was written of an earlier failure goes."""
    _failed_file(job, folder).unlink(missing_ok=True)
    return Outcome(
        *_names(job),
        state="done",
        run=str(job.run_file(folder)),
        objective=run.objective,
        evaluations=run.evaluations,
        seconds=run.seconds,
    )


def refused(job: Job, folder: Path, word: str, sentence: str) -> Outcome:
    """Writes that an optimizer can't serve a scene, whatever the seed."""
    write_json(_refused_file(job, folder), {"word": word, "sentence": sentence, "build": build_of(job.optimizer)})
    return Outcome(*_names(job), state="refused", word=word, sentence=sentence)


def refused_before(job: Job, folder: Path) -> Outcome | None:
    """The refusal that lies in the folder; one by another build, or damaged, goes: the optimizer is asked again."""
    path = _refused_file(job, folder)
    if not path.exists():
        return None
    try:
        stated = json.loads(path.read_text(encoding="utf-8"))
        word, sentence, build = (stated[name] for name in ("word", "sentence", "build"))
    except (OSError, ValueError, KeyError, TypeError):
        build = None
    if build != build_of(job.optimizer):
        path.unlink(missing_ok=True)
        return None
    return Outcome(*_names(job), state="refused", word=str(word), sentence=str(sentence))


def failed(job: Job, folder: Path, sentence: str) -> Outcome:
    """Writes that a run failed; the next call tries it again."""
    write_json(_failed_file(job, folder), {"sentence": sentence})
    return stopped(job, sentence)


def stopped(job: Job, sentence: str) -> Outcome:
    """A run that can't go on for a reason outside it, of which nothing is written."""
    return Outcome(*_names(job), state="failed", sentence=sentence)


def elsewhere(job: Job, sentence: str) -> Outcome:
    """A run that another process is at, of which nothing is written."""
    return Outcome(*_names(job), state="elsewhere", sentence=sentence)


def write_json(path: Path, contents: dict[str, Any]) -> None:
    """Writes a document under a temporary name, so that at no time there is half a file."""
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.write_text(json.dumps(contents, indent=1) + "\n", encoding="utf-8")
        partial.replace(path)
    except OSError as error:
        raise UserError(f"{path} can't be written ({error.strerror}); choose another folder.") from None


def _refused_file(job: Job, folder: Path) -> Path:
    return job.pair_folder(folder) / REFUSED


def _failed_file(job: Job, folder: Path) -> Path:
    return job.pair_folder(folder) / f"seed{job.seed}.failed.json"


def _names(job: Job) -> tuple[str, str, int]:
    return job.scene_name, job.label, job.seed
