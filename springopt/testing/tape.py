"""A recorder in memory."""

from __future__ import annotations

from collections.abc import Sequence

from springopt.recorder import Answer


class Tape:
    """Keeps the answers of a run in a list; one that is made with answers gives them again first.

    Attributes:
        answers: all of the run, the given ones first.
        diverged: whether a question was not the recorded one; the tape answers nothing from there on.
    """

    def __init__(self, answers: Sequence[Answer] = ()) -> None:
        self.answers: list[Answer] = []
        self.diverged = False
        self._past = list(answers)

    def recorded(self, kind: str, questions: Sequence[bytes]) -> list[Answer]:
        start = len(self.answers)
        known = self._past[start : start + len(questions)]
        asked = [(kind, question) for question in questions]
        self.diverged |= any((answer.kind, answer.question) != asked[i] for i, answer in enumerate(known))
        if self.diverged:
            return []
        self.answers += known
        return known

    def record(self, answers: Sequence[Answer]) -> None:
        self.answers += answers
