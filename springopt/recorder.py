"""What a problem tells its recorder: every answer, so that a run can be replayed."""

from __future__ import annotations

import hashlib
import math
import struct
from collections.abc import Sequence
from typing import NamedTuple, Protocol

from springopt.checks import Floats


class Answer(NamedTuple):
    """One answer that an optimizer got; a batch leaves one for each of its candidates."""

    kind: str  #: "value", "raced", "gradient", "residuals", "jacobian", "linearize" or "budget_left"
    question: bytes  #: digest of the point that was asked; NO_QUESTION for "budget_left"
    tolerance: float  #: of the forward solve
    status: int  #: code of the candidate's worst status; NO_EQUILIBRIUM where an exception was the answer
    #: The objective, or the reading; None where an exception was the answer, or where a race dropped the candidate.
    value: float | None
    seconds: float  #: on the run's wall clock when it was given
    processor_seconds: float  #: the same in processor time
    solving_seconds: float  #: of these, within forward solves and derivatives
    #: Gradient, residuals or Jacobian as float64; the message without an equilibrium; of a race's candidate the
    #: equilibria that were sought, and its value by a loose tolerance where it was solved by that as well.
    payload: bytes | None = None
    checksum: bytes | None = None  #: digest of a payload too large to keep, which replay computes again

    def without_payload(self) -> Answer:
        """What is left for reading when the run will not be gone on with."""
        return self._replace(payload=None, checksum=None)

    @classmethod
    def raced(cls, question: bytes, outcome: Outcome, clock: tuple[float, float, float]) -> Answer:
        """The answer to one candidate of a race."""
        value = None if outcome.value == math.inf else outcome.value
        noted = _NOTED.pack(outcome.solves, outcome.loose_value)
        return cls(RACED, question, outcome.tolerance, outcome.code, value, *clock, noted)

    def outcome(self) -> Outcome:
        """What `raced` was made of."""
        assert self.payload is not None  # a complete run, which has none, is never gone on with
        solves, loose_value = _NOTED.unpack(self.payload)
        value = math.inf if self.value is None else self.value
        return Outcome(value, self.status, solves, self.tolerance, loose_value)

    def solves(self, each: int) -> int:
        """Equilibria that were sought for it, of a candidate's `each` where no race was."""
        return self.outcome().solves if self.kind == RACED else each


class Outcome(NamedTuple):
    """What came of one candidate of a race."""

    value: float  #: inf where it was dropped
    code: int  #: its worst status found
    solves: int  #: equilibria that were sought
    tolerance: float  #: by which the value was solved
    loose_value: float = math.nan  #: by a loose tolerance, where it was solved by both; inf where it was dropped then


RACED = "raced"
_NOTED = struct.Struct("<qd")
NO_EQUILIBRIUM = -1
NO_QUESTION = bytes(16)
LARGEST_PAYLOAD = 1_000_000  # bytes


def digest(array: Floats) -> bytes:
    """Sixteen bytes that tell arrays apart, by every bit of their numbers."""
    return hashlib.blake2b(array.tobytes(), digest_size=16).digest()


class Recorder(Protocol):
    """Keeps the answers of a run in order, and gives them again when the run is resumed."""

    def recorded(self, kind: str, questions: Sequence[bytes]) -> list[Answer]:
        """The next answers on record, as many as there are of those asked; empty once the record has ended.

        Raises RecordBroken where a question is not the recorded one.
        """

    def record(self, answers: Sequence[Answer]) -> None:
        """Adds answers to the end of the record. Raises RecordBroken where it can't be written."""


class NullRecorder:
    """Remembers nothing: for a problem that nobody resumes."""

    def recorded(self, kind: str, questions: Sequence[bytes]) -> list[Answer]:
        return []

    def record(self, answers: Sequence[Answer]) -> None:
        pass
