"""Results to compare: runs, and what stands in for a run that could not be made."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from springopt.comparison.failure import FAILED, Failure, failures_of, failures_told, without_run
from springopt.comparison.record import Record, record_of
from springopt.comparison.result_files import ResultFile, ResultFiles, find_results
from springopt.comparison.terms import kept_apart, on_equal_terms
from springopt.errors import RunFileError, UserError, did_you_mean
from springopt.journal import run_path
from springopt.run import Run
from springopt.scene import bundled_scenes
from springopt.store import read_run

Progress = Callable[[int, int], None]  #: runs read, of how many


@dataclass(frozen=True)
class Refusal:
    """A method that has no run on a scene: it can't serve it, or all its runs failed."""

    scene: str
    method: str
    word: str  #: the reason, for a table's cell
    sentence: str


@dataclass(frozen=True)
class LeftOut:
    """A run that is there, and not in the comparison."""

    path: str
    why: str


@dataclass(frozen=True)
class Results:
    """What is compared, by scene, method and seed."""

    records: list[Record]
    refusals: list[Refusal]
    failures: list[Failure]
    left_out: list[LeftOut]
    notes: list[str]  #: sentences that a reader must know

    @property
    def methods(self) -> list[str]:
        return sorted({each.method for each in self.records} | {each.method for each in self.refusals})


def read_results(
    paths: Iterable[str | Path],
    *,
    optimizers: Sequence[str] = (),
    scenes: Sequence[str] = (),
    progress: Progress | None = None,
) -> Results:
    """Reads folders of results and run files.

    In `FOLDER/<scene>/<label>/seed<N>.h5` the label is the method's name; any other run goes by its optimizer. Where
    settings differ under one label, they are in the name.

    Args:
        paths: folders, searched to their depth, and run files.
        optimizers, scenes: those to compare, optimizers by label or name, scenes by name or group; by default all.
        progress: called for each run that was read.
    """
    files = find_results(paths)
    chosen = _scenes(scenes, files) or files.scenes
    asked = files.of(chosen, {*optimizers, *map(_label_in, optimizers)} or files.labels)
    read, left_out = _read(asked.runs, progress)
    _require_known("scene", chosen if scenes else (), files.scenes | {each.scene for each in read})
    records, apart = kept_apart([each for each in read if not scenes or each.scene in chosen])
    known = files.labels | {each.label for each in records} | {each.method for each in records}
    _require_known("optimizer", optimizers, known)
    records = [each for each in records if not optimizers or each.label in optimizers or each.method in optimizers]
    if not records:
        raise UserError("there is no complete run of what is to be compared; give a folder of results, or runs.")
    notes = apart + on_equal_terms(records)
    failures = failures_of(asked.failures, records)
    refusals = [_refusal(file) for file in asked.refusals]
    refusals += [Refusal(each.scene, each.method, FAILED, each.sentence) for each in without_run(failures, records)]
    left_out += [LeftOut(str(file.path), _why_unfinished(file)) for file in asked.journals]
    left_out += [LeftOut(str(file.path), file.says("sentence")["sentence"]) for file in asked.failures]
    return Results(records, refusals, failures, left_out, notes + failures_told(failures))


def _read(files: Sequence[ResultFile], progress: Progress | None) -> tuple[list[Record], list[LeftOut]]:
    records: list[Record] = []
    left_out: list[LeftOut] = []
    for count, file in enumerate(files, start=1):
        try:
            order, run = read_run(file.path)
        except RunFileError as error:
            left_out.append(LeftOut(str(file.path), str(error)))
        else:
            if run.complete:
                records.append(record_of(order, run, file.path, _label(file.path, run)))
            else:
                left_out.append(LeftOut(str(file.path), f"interrupted; {_finish(file.path)}"))
        if progress:
            progress(count, len(files))
    return records, left_out


def _label(path: Path, run: Run) -> str:
    """The label, if the file lies in a folder of that name below one of the scene's."""
    label = path.absolute().parent
    return label.name if label.parent.name == run.scene else run.method


def _finish(path: Path) -> str:
    return f"finish it with springopt solve --resume {path}"


def _why_unfinished(journal: ResultFile) -> str:
    return f"going on, or killed; {_finish(run_path(journal.path))}"


def _refusal(file: ResultFile) -> Refusal:
    place = file.path.absolute().parent
    return Refusal(place.parent.name, place.name, **file.says("word", "sentence"))


def _scenes(words: Sequence[str], files: ResultFiles) -> set[str]:
    """The scenes that are named, groups spelled out: of a group those that there are results of."""
    heads = bundled_scenes() if set(words) - files.scenes else {}
    members = {word: {head.name for head in heads.values() if head.group == word} & files.scenes for word in words}
    return {scene for word in words for scene in members[word] or {word}}


def _label_in(name: str) -> str:
    """The label in the name of a method that is kept apart by its settings."""
    return name.partition(" (")[0]


def _require_known(what: str, names: Iterable[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            raise UserError(
                f"these results have no {what} {name!r}; name one of {', '.join(sorted(known))}."
                f"{did_you_mean(name, known)}"
            )
