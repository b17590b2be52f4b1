"""Jobs on a Dask cluster: each is a task that runs in a folder of the worker's own and sends back what it wrote.

No disk need be shared. What an interrupted run left here travels with its task, which goes on from there.
"""

from __future__ import annotations

import json
import tempfile
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from springopt.benchmark.build import build_of
from springopt.benchmark.job import Job, run_job
from springopt.benchmark.outcome import Outcome, failed, refused, stopped
from springopt.errors import UserError
from springopt.interrupt import Interrupted

if TYPE_CHECKING:
    from distributed import Client, Future

RETRIES = 2  #: of a task that ends with an error; how many workers it may kill the scheduler's settings say
PATIENCE = 20.0  #: seconds for the scheduler to answer, and for a first worker

Files = dict[str, bytes]  # by name, of one job
Builds = dict[str, dict[str, str]]  # by optimizer


def share_on_cluster(
    jobs: Mapping[int, Job], folder: Path, address: str, begin: Callable[[], None]
) -> Iterator[tuple[int, Outcome]]:
    """Each job by its number as it ends; they begin in order. What is under way is cancelled if this one ends.

    Args:
        address: of the scheduler, as tcp://host:8786, or the path of its scheduler file.
        begin: called when the cluster is there and fit.
    """
    with _connected(address) as client:
        from distributed import as_completed

        names = sorted({job.optimizer for job in jobs.values()})
        build = builds_of(names)
        _require_same_build(client, names, build)
        begin()
        keys = [f"{job.scene_name}-{job.label}-seed{job.seed}-{uuid.uuid4()}" for job in jobs.values()]
        files = [_pack(job, folder) for job in jobs.values()]
        futures = client.map(_run_there, list(jobs.values()), files, build=build, key=keys, retries=RETRIES, pure=False)
        numbers = dict(zip(keys, jobs, strict=True))
        try:
            for future in as_completed(futures, loop=client.loop):
                number = numbers[future.key]
                yield number, _arrived(jobs[number], folder, future)
                future.release()
        finally:
            client.cancel(futures)


def builds_of(optimizers: Sequence[str]) -> Builds:
    """What must be the same wherever results are to be the same."""
    return {name: build_of(name) for name in optimizers}


@contextmanager
def _connected(address: str) -> Iterator[Client]:
    try:
        from distributed import Client
        from distributed.comm.addressing import resolve_address
    except ImportError:
        raise UserError("a Dask cluster needs the library distributed; install springopt[dask].") from None
    try:
        where = _scheduler(address)
        resolve_address(where)  # a client refuses it too, but half made it takes a minute to end
        client = Client(where, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise UserError(
            f"no Dask scheduler answers at {address!r} ({error}); give its address, as tcp://host:8786, or the path of "
            "its scheduler file."
        ) from None
    with client:
        yield client


def _scheduler(address: str) -> str:
    """Where it is by its file, if there is one of this name."""
    path = Path(address)
    return str(json.loads(path.read_text(encoding="utf-8"))["address"]) if path.is_file() else address


def _require_same_build(client: Client, names: Sequence[str], build: Builds) -> None:
    """Refuses a cluster that would give other results, or count the processor seconds of one run for another."""
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        raise UserError(
            "the Dask scheduler has no workers; start some, as by `dask worker ADDRESS --nthreads 1`."
        ) from None
    for worker, found in client.run(builds_of, names, on_error="return").items():
        if isinstance(found, Exception):
            raise UserError(
                f"worker {worker} can't run this ({type(found).__name__}: {found}); install the same there."
            )
        _require_same(worker, found, build)
    for worker, threads in client.nthreads().items():
        if threads > 1:
            raise UserError(
                f"worker {worker} runs {threads} tasks at once, whose processor seconds can't be told apart; start it "
                "with --nthreads 1, and more of them by --nworkers."
            )


def _require_same(worker: str, found: Builds, build: Builds) -> None:
    for name, facts in build.items():
        for what, here in facts.items():
            if found[name].get(what) != here:
                raise UserError(
                    f"on worker {worker} {what} is {found[name].get(what)} and here {here}, where results need not be "
                    "the same; install the same there."
                )


def _run_there(job: Job, files: Files, build: Builds) -> tuple[Outcome, str, Files]:
    """The task: what came of the job, the folder that its sentences name, and the files that it left."""
    from distributed import get_worker

    worker = get_worker()
    key = worker.get_current_task()

    def end_if_cancelled(*_: object) -> None:
        task = worker.state.tasks.get(key)
        if task is None or task.state == "cancelled":
            raise Interrupted

    _require_same(worker.address, builds_of(list(build)), build)  # it may have come later than the others
    with tempfile.TemporaryDirectory(prefix="springopt-") as name:
        place = Path(name)
        _unpack(job, place, files)
        try:
            outcome = run_job(job, place, progress=end_if_cancelled)
        except KeyboardInterrupt:
            outcome = stopped(job, "it was interrupted.")
        return outcome, name, _pack(job, place)


def _arrived(job: Job, folder: Path, future: Future[Any]) -> Outcome:
    """Writes down here what a task sent, or how it failed."""
    if future.status != "finished":
        return _lost(job, folder, future)
    outcome, there, files = future.result()
    _unpack(job, folder, files)
    sentence = outcome.sentence and outcome.sentence.replace(there, str(folder))
    match outcome.state:
        case "refused":
            refused(job, folder, outcome.word, sentence)
        case "failed" if f"seed{job.seed}.failed.json" in files:
            failed(job, folder, sentence)
    run = str(job.run_file(folder)) if outcome.state == "done" else None
    return replace(outcome, sentence=sentence, run=run)


def _lost(job: Job, folder: Path, future: Future[Any]) -> Outcome:
    from distributed.scheduler import KilledWorker

    if future.status != "error":
        return stopped(job, "its task was cancelled at the scheduler; the same command goes on.")
    error = future.exception()
    if isinstance(error, KilledWorker):
        return failed(
            job, folder, "its workers were killed, perhaps for want of memory; give them more, or leave it out."
        )
    return stopped(
        job, str(error) if isinstance(error, UserError) else f"its task failed ({type(error).__name__}: {error})."
    )


def _pack(job: Job, folder: Path) -> Files:
    """What lies here of a job: run file, journal with its log, or how it failed."""
    paths = job.pair_folder(folder).glob(f"seed{job.seed}.*")
    return {path.name: path.read_bytes() for path in paths if path.suffix != ".partial"}


def _unpack(job: Job, folder: Path, files: Files) -> None:
    """Puts these files in the place of those that were here; each is there whole or not at all."""
    place = job.pair_folder(folder)
    place.mkdir(parents=True, exist_ok=True)
    for name, contents in files.items():
        partial = place / f"{name}.partial"
        partial.write_bytes(contents)
        partial.replace(place / name)
    for name in _pack(job, folder).keys() - files.keys():
        (place / name).unlink()
