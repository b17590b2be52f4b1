"""Where a run begins: at what another optimizer finds first, or at the best point of an earlier run."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from springopt.encoding import Encoding
from springopt.errors import UserError
from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt.registry import load_optimizer
from springopt.store import read


@dataclass(frozen=True)
class EarlierRun(Optimizer):
    """Asks for the value of one point: the best of an earlier run."""

    name: ClassVar[str] = "earlier-run"
    run: str = ""  #: path of the run file
    point: tuple[float, ...] = ()  #: its best

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        problem.evaluate([self.point])


def is_run(start: str | os.PathLike[str]) -> bool:
    """Whether a start looks like the path of a run file; else it is the name of an optimizer."""
    return not isinstance(start, str) or start.endswith(".h5") or os.sep in start


def read_start(path: str | os.PathLike[str]) -> EarlierRun:
    """The best point of a run file."""
    return EarlierRun(os.fspath(path), tuple(read(Path(path)).run.point.tolist()))


def load_start(name: str) -> type[Optimizer]:
    """The kind of start that an order names."""
    return EarlierRun if name == EarlierRun.name else load_optimizer(name)


def label(start: Optimizer) -> str:
    """What people call a start: the optimizer's name, or the path of the run."""
    return start.run if isinstance(start, EarlierRun) else start.name


def require_fits(start: EarlierRun, encoding: Encoding) -> None:
    """Refuses a point that is none of this encoding."""
    if len(start.point) != encoding.size:
        raise UserError(
            f"the best point of {start.run} has {len(start.point)} numbers, but a point of this scene has "
            f"{encoding.size}; start from a run of a scene with the same encoding."
        )
    point = np.array(start.point)
    fits = (point >= encoding.lower) & (point <= encoding.upper)
    if encoding.kind == "binary":
        fits &= (point == 0) | (point == 1)
    if not fits.all():
        i = int(np.argmin(fits))
        wanted = "0 or 1" if encoding.kind == "binary" else f"in [{encoding.lower[i]:g}, {encoding.upper[i]:g}]"
        raise UserError(
            f"number {i} of the best point of {start.run} is {point[i]:g}, and in this scene it must be {wanted}; "
            "start from a run of a scene with the same encoding."
        )
