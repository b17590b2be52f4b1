"""Elements of a reference on nested meshes: tried as far as there is time, and judged by the finest of them.

All bear one load, see `springopt.reference.refinement`, and are compared at the lattice's own nodes. What judges are
second-order elements on a mesh finer than those of second order that are judged, and as fine as the finest of first
order, which share no shape function with them; where there are three meshes of them, extrapolated to cells of no size
(Richardson 1911), since corners make even them converge slowly.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.checks import Floats
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.reference import Reference
from springopt.reference.refinement import Refinement
from springopt.scene import Setup
from springopt.scene.lattice_tables import GridTable
from springopt.scene.reference_tables import FemTable
from springopt.tradeoff.errors import relative_errors
from springopt.tradeoff.point import Request

SERIES = {1: "first order", 2: "second order"}
MOST_UNKNOWNS = {2: 100_000, 3: 20_000}  # by dimension: factors are of some gigabytes then
MOST_UNKNOWNS_IN_MOTION = 3_000  # all modes are found, with full matrices
MOST_LEVELS = 20
#: The power of the unknowns that time grows with, from the assembly's to the factor's, by dimension and order.
GROWTH = {(2, 1): 1.2, (2, 2): 1.2, (3, 1): 1.2, (3, 2): 1.5}
GROWTH_IN_MOTION = 3.0
LEAST_RUNS = 4  # of what is measured: two that warm up, one that is timed, one that is judged
LEAST_RATIO, MOST_RATIO = 1.5, 50.0  # of the last two steps, for an extrapolation to be worth anything

Answer = Floats | UserError


@dataclass(frozen=True, eq=False)
class Trial:
    """Elements that were tried once."""

    order: int
    level: int  #: how often the cells of the lattice are divided
    table: FemTable
    answers: Sequence[Answer]  #: positions [length], (n, d) or (t, n, d), or why there are none, a load case each
    unknowns: int
    seconds: float

    @property
    def is_complete(self) -> bool:
        return not any(isinstance(answer, UserError) for answer in self.answers)

    @property
    def why(self) -> str:
        """The first load case that failed."""
        return next((str(answer) for answer in self.answers if isinstance(answer, UserError)), "")


@dataclass(frozen=True, eq=False)
class Judge:
    """The finest elements that answer every load case."""

    trial: Trial
    positions: Sequence[Floats]  #: extrapolated where that is worth anything, a load case each
    extrapolated: int  #: how many are

    def is_finer(self, trial: Trial) -> bool:
        return (trial.level, trial.order) < (self.trial.level, self.trial.order)


def try_elements(setup: Setup, request: Request) -> list[Trial]:
    """Both orders on finer and finer meshes, as far as there is time left to measure all but the finest elements."""
    begun = time.perf_counter()
    steps = [[(1, 0)], [(2, 0)], *([(1, level), (2, level)] for level in range(1, MOST_LEVELS))]
    # A setting that is asked for needs a finer one that judges it: of second order on the same mesh, or the next one.
    needed = max(level + order - 1 for order, level in _asked(setup, request))
    needed = max(needed, request.before.get("judge_refinements", 0))
    trials: list[Trial] = []
    for step in steps:
        foreseen = [_foreseen(setup, trials, order) for order, _ in step] if trials else [(0, 0.0)]
        seconds = time.perf_counter() - begun + sum(seconds for _, seconds in foreseen)
        seconds += LEAST_RUNS * (sum(trial.seconds for trial in trials) + foreseen[0][1] * (len(step) - 1))
        if seconds > request.seconds and step[-1][1] > needed:
            break
        if max(unknowns for unknowns, _ in foreseen) > _most(setup):
            break
        for order, level in step:
            if request.progress:
                request.progress(len(trials), None, f"trying {', '.join(key_of(setup, order, level))}")
            trials.append(_tried(setup, order, level))
    return trials


def _asked(setup: Setup, request: Request) -> list[tuple[int, int]]:
    """Order and level of what is asked for by name, and of what the scene states."""
    known = [(order, level) for level in range(MOST_LEVELS) for order in SERIES]
    own = (stated_table(setup).order, stated_table(setup).refinements)
    return [own, *(entry for entry in known if key_of(setup, *entry) in request.only)]


def _foreseen(setup: Setup, trials: Sequence[Trial], order: int) -> tuple[int, float]:
    """Unknowns, at most, and seconds of the next elements of an order, from the last ones."""
    before = [trial for trial in trials if trial.order == order] or trials
    factor = 2**setup.lattice.dimension  # for cells divided once, and for elements of second order
    is_static = setup.scene.load_cases.times is None
    growth = GROWTH[setup.lattice.dimension, order] if is_static else GROWTH_IN_MOTION
    return before[-1].unknowns * factor, before[-1].seconds * factor**growth


def _most(setup: Setup) -> int:
    is_static = setup.scene.load_cases.times is None
    return MOST_UNKNOWNS[setup.lattice.dimension] if is_static else MOST_UNKNOWNS_IN_MOTION


def _tried(setup: Setup, order: int, level: int) -> Trial:
    table = table_of(setup, order, level)
    begun = time.perf_counter()
    answers = deformed(setup, table)
    seconds = time.perf_counter() - begun
    unknowns = refinement_of(setup, level, order).node_count * setup.lattice.dimension
    return Trial(order, level, table, answers, unknowns, seconds)


def table_of(setup: Setup, order: int, level: int) -> FemTable:
    changes: dict[str, Any] = {"order": order, "refinements": level}
    if order == 2:  # both are for first-order elements, and no part of the body that they stand for
        changes |= {"formulation": "standard", "lumped": False}
    return stated_table(setup).model_copy(update=changes)


def stated_table(setup: Setup) -> FemTable:
    assert isinstance(setup.scene.reference, FemTable)  # else the axis is missing
    return setup.scene.reference


def deformed(setup: Setup, table: FemTable) -> list[Answer]:
    """From nothing: assembly and factors are a part of it."""
    reference = table.build(setup.model)
    return [_answer(reference, case) for case in setup.cases]


def _answer(reference: Reference, case: LoadCase) -> Answer:
    try:
        return reference.deform(case)
    except UserError as error:
        return error


def judge_of(trials: Sequence[Trial]) -> Judge | None:
    """Of second order if any of them are complete; None where there is nothing to judge."""
    complete = [trial for trial in trials if trial.is_complete]
    best = max(complete, key=lambda trial: (trial.order, trial.level), default=None)
    if best is None or best is trials[0]:
        return None
    limits = limits_of(trials, best.order)
    pairs = list(zip(limits or best.answers, best.answers, strict=True))
    positions = [_positions(answer if limit is None else limit) for limit, answer in pairs]
    return Judge(best, positions, sum(limit is not None for limit in limits))


def limits_of(trials: Sequence[Trial], order: int) -> list[Floats | None]:
    """What elements of an order tend to as their cells shrink, a load case each: None where three meshes don't tell.

    The error is taken to shrink at the rate of the last steps, (u2 - u1) / (u3 - u2), whatever makes it that.
    """
    last = [trial.answers for trial in trials if trial.order == order and trial.is_complete][-3:]
    return [_limit(*map(_positions, answers)) for answers in zip(*last, strict=True)] if len(last) == 3 else []


def _limit(coarse: Floats, middle: Floats, fine: Floats) -> Floats | None:
    step = np.linalg.norm(fine - middle)
    ratio = np.linalg.norm(middle - coarse) / step if step else np.inf
    if not LEAST_RATIO <= ratio <= MOST_RATIO:
        return None
    return fine + (fine - middle) / (ratio - 1.0)


def _positions(answer: Answer) -> Floats:
    assert not isinstance(answer, UserError)  # of what is complete
    return answer


def errors_of(setup: Setup, judge: Judge, trial: Trial, answers: Sequence[Answer]) -> Floats:
    """Of each load case, inf where there is no answer, or nothing that judges it."""
    if not judge.is_finer(trial):
        return np.full(len(answers), np.inf)
    return np.array([error_of(setup, *pair) for pair in zip(answers, judge.positions, strict=True)])


def error_of(setup: Setup, answer: Answer, known: Floats) -> float:
    """The moments of a motion are taken as more nodes."""
    if isinstance(answer, UserError):
        return np.inf
    nodes = np.broadcast_to(setup.lattice.nodes, known.shape)
    positions, known, nodes = (array.reshape(-1, nodes.shape[-1]) for array in (answer, known, nodes))
    return float(relative_errors(positions, known, nodes))


def key_of(setup: Setup, order: int, level: int) -> tuple[str, str]:
    """Series and name: the cells along each axis of a grid of blocks, else their number."""
    table = setup.scene.lattice
    if isinstance(table, GridTable) and setup.lattice.cell_type in ("quad", "hexahedron"):
        cells = " x ".join(str((count - 1) * 2**level) for count in table.grid)
    else:
        cells = f"{cell_count(setup, level):,}"
    return SERIES[order], f"{cells} cells"


def cell_count(setup: Setup, level: int) -> int:
    assert setup.lattice.cells is not None  # else there are no elements
    return len(setup.lattice.cells) * 2 ** (setup.lattice.dimension * level)


def refinement_of(setup: Setup, level: int, order: int) -> Refinement:
    lattice = setup.lattice
    assert lattice.cells is not None
    assert lattice.cell_type is not None
    return Refinement((lattice.nodes, lattice.cells, lattice.cell_type), level, order)
