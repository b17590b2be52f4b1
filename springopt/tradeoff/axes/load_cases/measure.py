"""From sets of load cases to points of test error over the time of an identification."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from springopt.analysis.identifiability import RANK_TOLERANCE
from springopt.analysis.point import choose_point
from springopt.analysis.sensitivity import objective_of, sensitivity
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.scene import Scene, Setup
from springopt.tradeoff.axes.load_cases.identification import (
    LEAST_SEEDS,
    SHORTEST,
    Identification,
    choose_method,
    identify,
)
from springopt.tradeoff.axes.load_cases.sets import (
    DESIGNED,
    GIVEN,
    CaseSet,
    Design,
    designed,
    given,
    name_of,
    run_design,
)
from springopt.tradeoff.errors import say_least
from springopt.tradeoff.point import Findings, Point, Request

LEAST_SHARE = 0.25  # of the seconds: what the design leaves at least for runs
HELPS = 0.9  # a factor of the error from which more load cases are worth it
MOST_NAMES = 5  # of picks, in a sentence
MOST_WORK = 1e10  # residuals of all sets times squared unknowns: some 5 s of singular values


def why_missing(scene: Scene) -> str | None:
    """Why a scene has no such axis, in words that follow "because"; None if it has."""
    if not scene.load_cases.test:
        return "it has no test load cases, and those that a model learned from judge nothing"
    return None


def measure(setup: Setup, request: Request) -> Findings:
    """Sets as given and designed, all identified alike; see `sets` and `identification`."""
    begun = time.perf_counter()
    sets, notes, numbers = _sets(setup, request)
    spent = time.perf_counter() - begun
    seconds = max(request.seconds - spent, LEAST_SHARE * request.seconds)
    wanted = [each for each in sets if request.wants(each.series, each.name)]
    if not wanted:
        return Findings([], notes=notes, numbers=numbers)
    unit = seconds / (LEAST_SEEDS * sum(each.count for each in wanted))
    unit = request.before.get("seconds_a_load_case", unit)  # what verifies a setting is to be the same one
    limits = [max(unit * each.count, SHORTEST) for each in wanted]
    largest = max(wanted, key=lambda each: each.count)
    method = choose_method(largest.setup, max(limits))
    method = replace(method, evaluations=request.before.get("evaluations_of_a_run", method.evaluations))
    # What compiles and imports is no part of the first round.
    until = max(begun + request.seconds, time.perf_counter() + LEAST_SHARE * request.seconds)
    found = identify(wanted, method, limits, request, until)
    unidentified = _unidentified(setup, wanted)
    points = [
        _point(each, its, method.warm_up, unidentified.get(number))
        for number, (each, its) in enumerate(zip(wanted, found, strict=True))
    ]
    notes = [
        f"Identified by {method.said}, once for each seed.",
        *notes,
        *_say_cut(wanted, found),
        *say_least((point.errors for point in points), setup.objective.tolerance),
        *_say_enough(points),
        *_say_equal(points),
    ]
    numbers |= {"identified_by": method.optimizer.name, "evaluations_of_a_run": method.evaluations}
    return Findings(points, notes=notes, numbers=numbers | {"seconds_a_load_case": unit})


def _sets(setup: Setup, request: Request) -> tuple[list[CaseSet], list[str], dict[str, Any]]:
    """All of them, what to know of the design, and the design in numbers."""
    sets = list(given(setup))
    if request.only and all(series == GIVEN for series, _ in request.only):
        return sets, [], {}
    if request.progress:
        request.progress(0, None, "load cases are designed")
    begun = time.perf_counter()
    try:
        found = run_design(setup)
    except UserError as error:
        return sets, [f"There is no series {DESIGNED}: {error}"], {}
    numbers = {
        "design_seconds": time.perf_counter() - begun,
        "designed_at": found.at,
        "candidates": found.candidates,
        "picks": [case.name for case in found.picks],
    }
    return [*sets, *designed(setup, found)], _say_design(setup, found), numbers


def _point(chosen: CaseSet, found: Sequence[Identification], warm_up: float, unidentified: int | None) -> Point:
    runs = [each.run for each in found if each.run is not None]
    numbers: dict[str, float] = {"load_cases": chosen.count, "cut_by_time": sum(each.is_cut for each in found)}
    if runs:
        numbers |= {
            "evaluations": float(np.median([run.evaluations for run in runs])),
            "solves": float(np.median([run.solves for run in runs])),
            "objective": float(np.median([run.objective for run in runs])),
            "objective_per_case": float(np.median([run.objective for run in runs])) / chosen.count,
        }
    if unidentified is not None:
        numbers["unidentified"] = unidentified
    return Point(
        series=chosen.series,
        name=chosen.name,
        errors=np.concatenate([each.errors for each in found]),
        processor=np.array([each.processor for each in found]),
        wall=np.array([each.wall for each in found]),
        warm_up=warm_up,
        is_stated=chosen.is_stated,
        numbers=numbers,
        why=next((each.why for each in found if each.why), ""),
    )


def _unidentified(setup: Setup, sets: Sequence[CaseSet]) -> dict[int, int]:
    """How many directions of the unknowns each set tells nothing of, by its place; empty where that is too much work.

    At the point of `choose_point`, from the Jacobians of all load cases, each of which is made once.
    """
    residuals = sum(each.count for each in sets) * setup.reference_positions[0].size
    if residuals * setup.encoding.size**2 > MOST_WORK:
        return {}
    cases: dict[str, LoadCase] = {case.name: case for each in sets for case in each.training}
    try:
        objective = objective_of(setup.objective, list(cases.values()))
        known = sensitivity(objective, setup.encoding, choose_point(setup))
    except UserError:
        return {}
    rows = dict(zip(cases, known.unknowns.reshape(len(cases), -1, known.unknowns.shape[1]), strict=True))
    found = {}
    for number, each in enumerate(sets):
        values = np.linalg.svd(np.vstack([rows[case.name] for case in each.training]), compute_uv=False)
        rank = int(np.count_nonzero(values > RANK_TOLERANCE * values[0]))
        found[number] = known.unknowns.shape[1] - rank
    return found


def _say_design(setup: Setup, found: Design) -> list[str]:
    own = {case.name for case in setup.cases}
    names = "; ".join(f"{case.name}{' (given)' if case.name in own else ''}" for case in found.picks[:MOST_NAMES])
    names += "; and so on" if len(found.picks) > MOST_NAMES else ""
    first = next(case.name for case in setup.cases if case.role == "train")
    said = [f"Designed {found.at}, of {found.candidates} candidates: {first}; then {names}."] if found.picks else []
    if not found.picks:
        said.append(f"There is no series {DESIGNED}: there was nothing to choose from.")
    if found.left_out:
        said.append(f"The reference has no answer to {', '.join(found.left_out)}, which were picked and left out.")
    return said


def _say_cut(sets: Sequence[CaseSet], found: Sequence[Sequence[Identification]]) -> list[str]:
    cut = [f"{each.series}, {each.name}" for each, its in zip(sets, found, strict=True) if any(i.is_cut for i in its)]
    return [f"The time ended runs of {'; '.join(cut)}: more --seconds let them end by themselves."] if cut else []


def _say_enough(points: Sequence[Point]) -> list[str]:
    """From how many load cases on more of them do not help."""
    said = []
    for series, its in _medians(points).items():
        enough = min(count for count, error in its.items() if all(HELPS * error <= e for e in _beyond(its, count)))
        if enough < max(its):
            said.append(f"{series}: beyond {name_of(enough)} more do not help (test error {its[enough]:.2g}).")
    return said


def _say_equal(points: Sequence[Point]) -> list[str]:
    """How many designed load cases are worth all that are given."""
    medians = _medians(points)
    if GIVEN not in medians or DESIGNED not in medians:
        return []
    own = medians[GIVEN]
    count, error = max(own), own[max(own)]
    as_good = [number for number, its in medians[DESIGNED].items() if HELPS * its <= error]
    if as_good:
        return [f"{name_of(min(as_good))} designed are as good as the {count} given ones (test error {error:.2g})."]
    best = min(medians[DESIGNED].items(), key=lambda item: item[1])
    return [
        f"No number of designed load cases is as good as the {count} given ones (test error {error:.2g}); the best, "
        f"{name_of(best[0])}, come to {best[1]:.2g}."
    ]


def _beyond(medians: Mapping[int, float], count: int) -> list[float]:
    return [error for other, error in medians.items() if other > count]


def _medians(points: Sequence[Point]) -> dict[str, dict[int, float]]:
    """Test error by number of load cases, by series; of points with all answers."""
    found: dict[str, dict[int, float]] = {}
    for point in points:
        if point.is_good and point.error is not None:
            found.setdefault(point.series, {})[int(point.numbers["load_cases"])] = point.error.value
    return found
