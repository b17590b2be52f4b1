"""What springopt raises."""

from collections.abc import Iterable
from difflib import get_close_matches


class SpringoptError(Exception):
    """Root of the errors that springopt raises."""


class UserError(SpringoptError, ValueError):
    """Bad input, in one sentence: what was wanted, what came, what to do."""


class SceneError(UserError):
    """A scene that can't be read, or states something impossible."""


class RunFileError(UserError):
    """A run file or journal that is missing, foreign or damaged, or would be overwritten."""


class RunInUse(RunFileError):
    """A run that another process is at."""


class PluginError(UserError):
    """A plugin that is unknown, can't be loaded, or breaks its contract."""


class OutsideBox(UserError):
    """An optimizer asked for a point outside its problem's box."""


class NotServed(UserError):
    """An optimizer can't serve this scene.

    Attributes:
        word: the reason in a word, for a table's cell: what the scene does not supply, or "memory".
    """

    def __init__(self, sentence: str, *, word: str) -> None:
        super().__init__(sentence)
        self.word = word


class NoEquilibrium(SpringoptError):
    """A gradient or residual was asked for where the forward solve has no equilibrium."""


class BudgetSpent(BaseException):
    """The budget is spent: unwinds any optimizer's loop.

    No error, and a BaseException so that a foreign `except Exception` lets it pass.
    """


class RecordBroken(BaseException):
    """The record of a run can't be gone on with: unwinds any optimizer's loop, as `BudgetSpent` does.

    Attributes:
        error: what the user is told.
    """

    def __init__(self, error: RunFileError) -> None:
        super().__init__(str(error))
        self.error = error


def did_you_mean(word: str, candidates: Iterable[str]) -> str:
    """The hint " Did you mean 'x'?" if a candidate is close to the word, else ""."""
    matches = get_close_matches(word, list(candidates), n=1)
    return f" Did you mean {matches[0]!r}?" if matches else ""
