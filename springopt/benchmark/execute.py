"""Jobs at work, here, in several processes or on a cluster: the folder is filled, and continued where it stopped."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from springopt.benchmark.job import Job, at_work_elsewhere, ended_before, require_legal, run_job
from springopt.benchmark.outcome import Outcome
from springopt.benchmark.pace import Pace
from springopt.benchmark.workers import share
from springopt.errors import UserError
from springopt.interrupt import termination_as_interrupt


class Standing(NamedTuple):
    """How far the jobs are."""

    ended: int
    jobs: int
    seconds_left: float  #: an estimate
    newest: Outcome


Progress = Callable[[Standing], None]
Ended = Iterator[tuple[int, Outcome]]  # the number of a job, and what came of it


def run_jobs(
    jobs: Iterable[Job],
    folder: str | os.PathLike[str],
    *,
    workers: int = 1,
    dask: str | None = None,
    ready: Callable[[], None] | None = None,
    progress: Progress | None = None,
) -> list[Outcome]:
    """Runs all jobs that have not ended yet, and says of each what came of it, in their order.

    The first seeds of all scenes and optimizers come first: what is there after Ctrl-C can be compared. Raises
    KeyboardInterrupt then, and after SIGTERM; the same call goes on. Of a run that another process is at, it says so.

    Args:
        folder: of results, `FOLDER/<scene>/<label>/seed<N>.h5`; it is made.
        workers: processes; 1 is this one.
        dask: the address of a Dask scheduler, or its scheduler file: the jobs run on its workers instead.
        ready: called once, when nothing can be refused any more, before the first run.
        progress: called after each job.
    """
    queue, place = list(jobs), Path(folder)
    for job in queue:
        require_legal(job)
    _require_apart(queue)

    def begin() -> None:
        _make(place)
        if ready:
            ready()

    outcomes: dict[int, Outcome] = {}
    pace = Pace(queue)
    with termination_as_interrupt():
        for number, outcome in _ended(queue, place, workers, dask, begin):
            outcomes[number] = outcome
            pace.note(outcome)
            if progress:
                progress(Standing(len(outcomes), len(queue), pace.seconds_left(), outcome))
    return [outcomes[number] for number in range(len(queue))]


def _ended(jobs: Sequence[Job], folder: Path, workers: int, dask: str | None, begin: Callable[[], None]) -> Ended:
    """Each job as it ends; first those that ended in an earlier call."""
    waiting = {}
    for number in sorted(range(len(jobs)), key=lambda number: jobs[number].seed):
        before = ended_before(jobs[number], folder)
        if dask is not None:
            before = before or at_work_elsewhere(jobs[number], folder)  # its journal is not ours to send
        if before:
            yield number, before
        else:
            waiting[number] = jobs[number]
    if waiting and dask is not None:
        from springopt.benchmark.cluster import share_on_cluster

        yield from share_on_cluster(waiting, folder, dask, begin)
        return
    begin()
    if waiting and workers > 1:
        yield from share(waiting, folder, workers)
    else:
        for number, job in waiting.items():
            yield number, run_job(job, folder)


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"{folder} can't be written ({error.strerror}); choose another folder.") from None


def _require_apart(jobs: Sequence[Job]) -> None:
    """Refuses two jobs with the same place in the folder."""
    places: set[Path] = set()
    for job in jobs:
        place = job.run_file(Path())
        if place in places:
            raise UserError(f"two jobs would write {place}; give one of them another label.")
        places.add(place)
