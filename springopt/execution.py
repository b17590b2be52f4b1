"""An optimizer at work on a scene that is ready: it runs, and what came of it is written down."""

from __future__ import annotations

import contextlib
import math
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from threadpoolctl import threadpool_limits

from springopt.budget import Budget
from springopt.checks import Floats
from springopt.errors import BudgetSpent, NoEquilibrium, PluginError, RecordBroken, SpringoptError
from springopt.interrupt import Interrupted, held_interrupts
from springopt.journal import Journal, run_path
from springopt.meter import Meter, Times
from springopt.optimizer import Optimizer, require_supplies
from springopt.problem import Problem
from springopt.rehearsal import rehearse
from springopt.run import Order, Run, WhyStopped
from springopt.start import label
from springopt.store import RunFile, write

if TYPE_CHECKING:
    from springopt.scene import Setup

Progress = Callable[[int, int | None, float, float], None]  # evaluations, of how many, best value, seconds

PROGRESS_SECONDS = 0.1


def execute(
    order: Order,
    setup: Setup,
    optimizer: Optimizer,
    journal: Journal | None = None,
    *,
    start: Optimizer | None = None,
    progress: Progress | None = None,
) -> Run:
    """Runs the start, if there is one, and then the optimizer to its end; a run file takes the journal's place then.

    An optimizer's linear algebra has one thread: its bits depend on their number, and on matrices of this size more of
    them only wait for each other.
    """
    with held_interrupts() as pressed, threadpool_limits(1, user_api="blas"):
        budget, watch = Budget(**order.budget), _watcher(progress, pressed)
        loosest = order.loosest_tolerance
        problem = Problem(setup.objective, setup.encoding, budget, journal, watch=watch, loosest_tolerance=loosest)
        for ready in (start, optimizer):
            if ready:
                require_supplies(ready, problem.supplies)
                rehearse(ready, setup)
        problem.meter.clock.set(Times(0.0, 0.0, 0.0))
        why = _begin(start, optimizer, problem, order.seed, journal) if start else None
        if why is None:
            why = _minimize(optimizer, problem, np.random.default_rng(order.seed), journal)
        if progress:
            _tell(progress, problem.meter)
        path = run_path(journal.path) if journal else None
        run = _result(order, setup, problem, why, path, start)
        if journal and path:
            answers = journal.answers()
            # Payloads serve resuming alone; without them thousands of complete runs stay small.
            kept = (answer.without_payload() for answer in answers) if run.complete else answers
            write(path, _run_file(order, setup, run), kept)
            journal.delete()
        return run


def _begin(
    start: Optimizer, optimizer: Optimizer, problem: Problem, seed: int, journal: Journal | None
) -> WhyStopped | None:
    """Has the start find the optimizer's first guess; says why where the run ends with it, else None.

    The optimizer draws what it would draw without a start: this one has a stream of its own.
    """
    why = _minimize(start, problem, np.random.default_rng([seed, 1]), journal)
    if why == "budget":
        warnings.warn(
            f"the start {label(start)} spent the whole budget, and {optimizer.name} never began; "
            "give more budget, or a start that ends by itself.",
            RuntimeWarning,
            stacklevel=4,
        )
    if why != "optimizer finished":
        return why
    if problem.best_point is not None:
        problem.start_at(problem.best_point)
    return None


def _minimize(optimizer: Optimizer, problem: Problem, rng: np.random.Generator, journal: Journal | None) -> WhyStopped:
    meter = problem.meter
    try:
        with _blamed_on(optimizer, journal):
            optimizer.minimize(problem, rng)
        spent = problem.budget_left < 1  # recorded under a time limit, so that a resumed run ends or goes on alike
    except BudgetSpent:
        spent = True
    except RecordBroken as broken:
        raise broken.error from None
    except Interrupted:
        if meter.best_point is None:
            raise KeyboardInterrupt from None
        return "interrupted"
    if meter.target_reached:
        return "target"
    return "budget" if spent else "optimizer finished"


@contextlib.contextmanager
def _blamed_on(optimizer: Optimizer, journal: Journal | None) -> Iterator[None]:
    """Tells an optimizer's own fault from springopt's, and where its answers are."""
    try:
        yield
    except MemoryError:
        raise
    except Exception as error:
        if isinstance(error, SpringoptError) and not isinstance(error, NoEquilibrium):
            raise
        advice = f", then go on from {journal.path}, which has its answers so far" if journal else ""
        raise PluginError(
            f"optimizer {optimizer.name} ({type(optimizer).__module__}) failed ({type(error).__name__}: {error}); "
            f"mend it{advice}, or choose another. SPRINGOPT_TRACEBACK=1 shows where."
        ) from error


def _watcher(progress: Progress | None, pressed: Callable[[], bool]) -> Callable[[Meter], None]:
    """Looks at the keyboard before each solve, and tells the progress now and then."""
    told = -math.inf

    def watch(meter: Meter) -> None:
        nonlocal told
        if pressed():
            raise Interrupted
        if progress and meter.history and time.perf_counter() - told >= PROGRESS_SECONDS:
            told = time.perf_counter()
            _tell(progress, meter)

    return watch


def _tell(progress: Progress, meter: Meter) -> None:
    progress(meter.evaluations, meter.budget.evaluations, meter.best_value, meter.clock.read().seconds)


def _result(
    order: Order, setup: Setup, problem: Problem, why: WhyStopped, path: Path | None, start: Optimizer | None
) -> Run:
    meter, point = problem.meter, problem.best_point
    if point is None:
        raise PluginError(
            f"optimizer {order.optimizer} ended without the value of a single candidate; "
            "give it more budget, or choose another."
        )
    times = meter.clock.read()
    row = setup.encoding.decode(point)
    return Run(
        objective=meter.best_value,
        evaluations=meter.evaluations,
        solves=meter.solves,
        **times._asdict(),
        stiffness=row[: setup.lattice.spring_count],
        point=point,
        parameters=setup.encoding.parameters(point),
        parameter_intervals=setup.encoding.parameter_intervals(),
        reference_parameters=setup.reference_parameters(),
        classes=setup.encoding.describe(point),
        errors=[asdict(error) | {"status": str(error.status)} for error in setup.objective.errors(row)],
        optimizer=order.optimizer,
        start=label(start) if start else None,
        options=order.options,
        scene=setup.scene.name,
        scene_digest=setup.scene.digest(),
        seed=order.seed,
        run=None if path is None else str(path),
        complete=why != "interrupted",
        why_stopped=why,
        history=meter.history,
        notes=problem.notes,
        objective_of_present=_value_of_present(setup, point),
        front=problem.front,
        loose_selections=problem.loose_selections,
    )


def _value_of_present(setup: Setup, point: Floats) -> float | None:
    row, present = setup.encoding.decode(point), setup.encoding.present(point)
    springs = slice(0, len(present))
    if present[row[springs] > 0].all():
        return None
    row[springs] = np.where(present, row[springs], 0.0)
    return float(setup.objective.evaluate(row[None]).values[0])


def _run_file(order: Order, setup: Setup, run: Run) -> RunFile:
    return RunFile(
        order=order,
        run=run,
        lattice=setup.lattice,
        cases=setup.cases,
        reference_positions=setup.reference_positions,
        positions=setup.objective.solution(setup.encoding.decode(run.point)).positions,
    )
