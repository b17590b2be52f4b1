"""Jobs shared among processes of this machine; one that is killed takes nothing with it but the job in its hands.

`concurrent.futures` ends the whole pool where one process dies; here each process has a line of its own to this one.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections import Counter, deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from multiprocessing import get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection, wait
from pathlib import Path

from springopt.benchmark.job import Job, run_job
from springopt.benchmark.outcome import Outcome, failed

DEATHS = 2  #: processes that a job may kill before it counts as failed
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")


class Worker:
    """A process that runs one job at a time; it changes itself because its job does.

    Attributes:
        number: of the job in its hands; None where there is none.
        connection: ready when the job has ended, or the process.
    """

    def __init__(self, folder: Path) -> None:
        context = get_context("spawn")
        self.number: int | None = None
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, folder), daemon=True)
        with _interrupts_blocked(), _environment(ONE_THREAD):
            self._process.start()
        theirs.close()

    def give(self, number: int, job: Job) -> None:
        """Has it run a job; if it died meanwhile, `take` tells."""
        self.number = number
        with suppress(OSError):
            self.connection.send(job)

    def take(self) -> Outcome | None:
        """What came of the job; None where the process died of it."""
        try:
            outcome: Outcome = self.connection.recv()
        except (EOFError, OSError):
            return None
        self.number = None
        return outcome

    def end(self) -> int | None:
        """Ends the process, whatever it is doing, and says how it ended: its journal survives."""
        self.connection.close()
        self._process.kill()
        self._process.join()
        return self._process.exitcode


def share(jobs: Mapping[int, Job], folder: Path, count: int) -> Iterator[tuple[int, Outcome]]:
    """Each job by its number as it ends; they begin in order.

    A job whose process died is taken up by another one, from its journal; the second time it has failed.
    """
    queue, deaths = deque(jobs), Counter[int]()
    workers = [Worker(folder) for _ in range(min(count, len(jobs)))]
    try:
        while queue or any(worker.number is not None for worker in workers):
            for worker in workers:
                if worker.number is None and queue:
                    number = queue.popleft()
                    worker.give(number, jobs[number])
            for i in _ready(workers):
                number = _number_of(workers[i])
                outcome = workers[i].take()
                if outcome is None:
                    exit_code = workers[i].end()
                    workers[i] = Worker(folder)
                    deaths[number] += 1
                    if deaths[number] < DEATHS:
                        queue.appendleft(number)
                        continue
                    outcome = failed(jobs[number], folder, _how_it_died(exit_code))
                yield number, outcome
    finally:
        for worker in workers:
            worker.end()


def _ready(workers: list[Worker]) -> list[int]:
    """The workers whose job has ended, one way or the other; waits for at least one."""
    ready = wait([worker.connection for worker in workers if worker.number is not None])
    return [i for i, worker in enumerate(workers) if worker.connection in ready]


def _number_of(worker: Worker) -> int:
    assert worker.number is not None
    return worker.number


def _how_it_died(exit_code: int | None) -> str:
    how = f"was killed by signal {-exit_code}" if exit_code and exit_code < 0 else f"ended with exit code {exit_code}"
    return f"its process {how}, {DEATHS} times, perhaps for want of memory; run fewer at a time, or leave it out."


def _serve(connection: Connection, folder: Path) -> None:
    """Runs jobs until the line is cut; standard output is the caller's, and optimizers may print."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    sys.stdout = sys.stderr
    with suppress(EOFError, OSError):
        while True:
            connection.send(run_job(connection.recv(), folder))


def _end_with_parent() -> None:
    """Ends this process at once where its parent is gone, killed perhaps: the journal survives."""
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Processes started in here are deaf to Ctrl-C, which the terminal sends to all: this one ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # which would be started beside the first process, and unblock them
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _environment(variables: Mapping[str, str]) -> Iterator[None]:
    """These environment variables, for the processes that are started in here."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
