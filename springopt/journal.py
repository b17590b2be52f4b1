"""The journal: every answer of a run while it lasts, on disk, so that a killed run is resumed where it was."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Self

from springopt.errors import RecordBroken, RunFileError, RunInUse
from springopt.recorder import Answer
from springopt.run import Order

FORMAT = 2
COMMIT_SECONDS = 0.05

_APPLICATION_ID = 0x5350524F  # "SPRO", where SQLite files say whose they are
_COLUMNS = ", ".join(Answer._fields)
_INSERT = f"INSERT INTO answers ({_COLUMNS}) VALUES ({', '.join('?' * len(Answer._fields))})"
_SELECT = f"SELECT {_COLUMNS} FROM answers ORDER BY position"


class Journal:
    """A recorder on disk: answers are appended, and committed every 50 ms.

    It gives the answers that it was opened with again, in order, to the same questions. One process holds it at a time.

    Attributes:
        path: the file, `RUN.h5.journal`.
        order: what the run is asked to do.
    """

    def __init__(self, path: Path, order: Order, connection: sqlite3.Connection) -> None:
        self.path, self.order = path, order
        self._connection = connection
        self._is_open = True
        self._past = connection.execute(_SELECT)
        self._pending: list[Answer] = []
        self._committed = 0.0

    @classmethod
    def create(cls, path: Path, order: Order, answers: Iterable[Answer] = ()) -> Journal:
        """A new journal, with answers that are already known; raises RunFileError rather than overwrite a file.

        RunInUse is raised where another process is at the journal that is there.
        """
        try:
            path.open("x").close()
        except FileExistsError:
            require_unused(path)
            advice = "resume it" if holds_run(path) else "it had not begun: delete the file"
            raise RunFileError(
                f"{path} exists already: a run was cut short; {advice}, or choose another output."
            ) from None
        except OSError as error:
            raise RunFileError(f"{path} can't be written ({error.strerror}); choose another output.") from None
        with _in_one_sentence(path):
            connection = _connect(path)
            with connection:
                _lay_out(connection, order)
                connection.executemany(_INSERT, answers)
            # After the layout, so that the head of the file itself, not only its log, says whose it is.
            _write_ahead(connection)
            return cls(path, order, connection)

    @classmethod
    def open(cls, path: Path) -> Journal:
        """The journal of a run that was cut short; raises RunFileError if it is none or damaged, RunInUse if in use."""
        _require_journal(path)
        with _in_one_sentence(path):
            connection = _connect(path)
            _write_ahead(connection)
            (order,) = connection.execute("SELECT json FROM run_order").fetchone()
            return cls(path, Order.from_json(order), connection)

    def recorded(self, kind: str, questions: Sequence[bytes]) -> list[Answer]:
        """See `springopt.recorder.Recorder`."""
        with _unwinding(), _in_one_sentence(self.path):
            answers = [Answer(*row) for row in self._past.fetchmany(len(questions))]
        for answer, question in zip(answers, questions, strict=False):
            if (answer.kind, answer.question) != (kind, question):
                raise RecordBroken(
                    RunFileError(
                        f"optimizer {self.order.optimizer} asked something else than in the recorded run: it has "
                        "changed, or it depends on more than its seed and the answers; start a new run."
                    )
                )
        return answers

    def record(self, answers: Sequence[Answer]) -> None:
        """See `springopt.recorder.Recorder`."""
        self._pending += answers
        if time.perf_counter() - self._committed > COMMIT_SECONDS:
            with _unwinding():
                self._commit()

    def answers(self) -> Iterator[Answer]:
        """All answers from the start of the run."""
        self._commit()
        with _in_one_sentence(self.path):
            yield from (Answer(*row) for row in self._connection.execute(_SELECT))

    def close(self) -> None:
        """Commits and closes. The file stays, unless there is no answer in it."""
        if not self._is_open:
            return
        self._commit()
        with _in_one_sentence(self.path):
            is_empty = self._connection.execute("SELECT 1 FROM answers LIMIT 1").fetchone() is None
        if is_empty:
            self.delete()
        else:
            self._disconnect()

    def delete(self) -> None:
        """Removes the journal and what SQLite keeps beside it."""
        self._disconnect()
        for suffix in ("", "-wal", "-shm"):
            self.path.with_name(self.path.name + suffix).unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _disconnect(self) -> None:
        with _in_one_sentence(self.path):
            self._past.close()  # an open cursor would keep the file locked
            self._connection.close()
        self._is_open = False

    def _commit(self) -> None:
        # Handed over first: if Ctrl-C comes in between, answers get lost, which resuming mends, but never doubled.
        answers, self._pending = self._pending, []
        if answers:
            with _in_one_sentence(self.path), self._connection:
                self._connection.executemany(_INSERT, answers)
        self._committed = time.perf_counter()


def journal_path(run: Path) -> Path:
    """Where the journal of a run file lies."""
    return run.with_name(run.name + ".journal")


def run_path(path: Path) -> Path:
    """The run file that a journal becomes; a run file itself."""
    return path.with_name(path.name.removesuffix(".journal"))


def holds_run(path: Path) -> bool:
    """Whether there is more than the empty file of a run that was killed before it began."""
    return path.exists() and path.stat().st_size > 0


def require_unused(path: Path) -> None:
    """Raises RunInUse where another process is at this journal, also where that one is only laying it out."""
    with closing(_connect(path)) as connection:
        try:
            connection.execute("BEGIN EXCLUSIVE")
        except sqlite3.DatabaseError as error:
            _require_not_busy(path, error)


def _require_not_busy(path: Path, error: sqlite3.DatabaseError) -> None:
    if error.sqlite_errorcode == sqlite3.SQLITE_BUSY:
        raise RunInUse(f"{path} is in use by another process; wait until that run ends, or end it.") from None


def _connect(path: Path) -> sqlite3.Connection:
    connection = sqlite3.connect(path, timeout=0.2)
    connection.execute("PRAGMA locking_mode = EXCLUSIVE")
    return connection


def _write_ahead(connection: sqlite3.Connection) -> None:
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA synchronous = NORMAL")


def _lay_out(connection: sqlite3.Connection, order: Order) -> None:
    connection.execute("BEGIN")
    connection.execute(f"PRAGMA application_id = {_APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version = {FORMAT}")
    connection.execute("CREATE TABLE run_order (json TEXT NOT NULL)")
    connection.execute("INSERT INTO run_order VALUES (?)", [order.to_json()])
    connection.execute(f"CREATE TABLE answers (position INTEGER PRIMARY KEY, {_COLUMNS})")


def _require_journal(path: Path) -> None:
    """Refuses a foreign file by its head alone (sqlite.org/fileformat2.html), before SQLite could touch it."""
    try:
        with path.open("rb") as file:
            head = file.read(100)
    except OSError as error:
        raise RunFileError(f"{path} can't be read ({error.strerror}); give the journal of a run.") from None
    if not head.startswith(b"SQLite format 3\0") or int.from_bytes(head[68:72]) != _APPLICATION_ID:
        raise RunFileError(f"{path} is no journal of springopt; give RUN.h5 or RUN.h5.journal.")
    if (made := int.from_bytes(head[60:64])) != FORMAT:
        which = "a newer" if made > FORMAT else "the older"
        raise RunFileError(
            f"{path} has journal format {made}, and this springopt reads {FORMAT}; use {which} springopt."
        )


@contextmanager
def _unwinding() -> Iterator[None]:
    """Lets an error pass an optimizer that swallows exceptions."""
    try:
        yield
    except RunFileError as error:
        raise RecordBroken(error) from None


@contextmanager
def _in_one_sentence(path: Path) -> Iterator[None]:
    try:
        yield
    except sqlite3.OperationalError as error:
        _require_not_busy(path, error)
        raise RunFileError(f"{path} can't be written or read ({error}); free the disk, then resume the run.") from None
    except (sqlite3.DatabaseError, TypeError, ValueError) as error:
        raise RunFileError(f"{path} is damaged ({error}); start a new run.") from None
