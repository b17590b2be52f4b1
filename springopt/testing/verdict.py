"""What a check says of a plugin: passed, failed, or not judged, with the sentence that says what to mend."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, Literal

from threadpoolctl import threadpool_limits

from springopt.optimizer import Optimizer

Subject = type[Optimizer] | Optimizer
Check = Callable[[Subject], None]


class NotJudged(AssertionError):
    """A check can't be made before another fault is mended."""


@dataclass(frozen=True)
class Finding:
    """What one check found."""

    check: str  #: what a plugin does that passes it, in a few words
    verdict: Literal["passed", "failed", "not judged"]
    sentence: str = ""  #: what to mend, or what is in the way; empty where it passed


def as_in_a_run(check: Check) -> Check:
    """The check with one thread for linear algebra, as `springopt.execution` has it."""

    @wraps(check)
    def limited(optimizer: Subject) -> None:
        with threadpool_limits(1, user_api="blas"):
            check(optimizer)

    return limited


def find(check: Callable[..., None], *subject: Any) -> Finding:
    """What a check finds of its subject, said and not raised."""
    claim = check.__name__.removeprefix("check_").replace("_", " ")
    try:
        check(*subject)
    except NotJudged as obstacle:
        return Finding(claim, "not judged", str(obstacle))
    except AssertionError as fault:
        return Finding(claim, "failed", str(fault))
    return Finding(claim, "passed")


def require(claim: bool, sentence: str) -> None:
    """Raises AssertionError with the sentence unless the claim holds."""
    if not claim:
        raise AssertionError(sentence)


def told(error: BaseException) -> str:
    """An error as part of a sentence."""
    return f"{type(error).__name__}: {error}"
