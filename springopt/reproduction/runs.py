"""The finished runs of a reproduction, by scene and by what the optimizer is called there."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

from springopt.benchmark import Outcome
from springopt.errors import PluginError
from springopt.store import RunFile, read


class Runs:
    """Reads run files when they are asked for.

    Args:
        outcomes: what came of the jobs.
    """

    def __init__(self, outcomes: Iterable[Outcome]) -> None:
        self._outcomes: dict[tuple[str, str], list[Outcome]] = {}
        for outcome in outcomes:
            self._outcomes.setdefault(outcome.pair, []).append(outcome)

    def of(self, scene: str, label: str) -> list[RunFile]:
        """The runs of all seeds, at least one. Raises PluginError where one failed."""
        found = []
        for outcome in self._outcomes[scene, label]:
            if outcome.run is None:
                raise PluginError(
                    f"{label} on {scene} has no result ({outcome.sentence}); mend that, then call reproduce again."
                )
            found.append(_read(outcome.run))
        return found

    def word(self, scene: str, label: str) -> str | None:
        """Why an optimizer has no runs on a scene, in a word; None where it has."""
        first = self._outcomes[scene, label][0]
        return (first.word or first.state) if first.run is None else None


@lru_cache(512)
def _read(path: str) -> RunFile:
    return read(Path(path))
