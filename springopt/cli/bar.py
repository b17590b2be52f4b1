"""Bars on standard error, where that is a terminal: what a command is at, and how far."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Task
    from rich.text import Text

    from springopt.benchmark.execute import Progress, Standing


Show = Callable[[int, "int | None", str], None]  # how many are done, of how many, and a few words


@contextmanager
def counting_bar() -> Iterator[Show | None]:
    """A bar that counts, with a few words and the time elapsed; None where there is no terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[words]}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=None, words="getting ready")
        yield lambda done, total, words: bar.update(task, completed=done, total=total, words=words)


@contextmanager
def bar_over_runs() -> Iterator[Progress | None]:
    """A bar over many runs with the time left; None where there is no terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn

    class TimeLeft(ProgressColumn):
        def render(self, task: Task) -> Text:
            from rich.text import Text

            return Text(say_left(task.fields["end"]))

    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    columns = (BarColumn(), MofNCompleteColumn(), TimeLeft(), TextColumn("{task.fields[newest]}"))
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=None, end=None, newest="getting ready")

        def tell(standing: Standing) -> None:
            end, newest = time.monotonic() + standing.seconds_left, standing.newest
            bar.update(
                task, completed=standing.ended, total=standing.jobs, end=end, newest=f"{newest.label} on {newest.scene}"
            )

        yield tell


def say_left(end: float | None) -> str:
    """The time left until a moment of the monotonic clock, counted down between two runs."""
    if end is None:
        return ""
    left = max(0.0, end - time.monotonic())
    if left < 90:
        return f"about {left:.0f} s left"
    return f"about {left / 60:.0f} min left" if left < 5400 else f"about {left / 3600:.1f} h left"
