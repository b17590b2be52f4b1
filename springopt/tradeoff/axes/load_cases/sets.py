"""Sets of training load cases: the first ones of a scene, and the first one with those that tell most beside it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from springopt.analysis.candidates import Candidate, generated
from springopt.analysis.design import design
from springopt.analysis.identifiability import NOISE
from springopt.analysis.point import Point, choose_point
from springopt.checks import Floats
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.objective import Objective
from springopt.scene import Setup
from springopt.scene.build import deformed

GIVEN, DESIGNED = "as given", "designed"
COUNTS = (1, 2, 4, 6, 8, 12, 16, 24, 32, 48)
FEW = 4  # given load cases: of more, a single one is not worth a setting
LARGEST_FACTOR, LEAST_DESIGNED = 1.5, 4  # so many more than are given are designed, and so many at least
#: Candidates times picks times cubed unknowns: some 5 s of eigenvalues; and what even few candidates may take.
MOST_WORK, TOO_MUCH_WORK = 1e10, 5e10
PARALLEL = 1e-9  # of forces: what is left when one is taken off the other, over its size


@dataclass(frozen=True, eq=False)
class CaseSet:
    """A scene that learns from these load cases; its test load cases are as ever."""

    series: str
    setup: Setup
    is_stated: bool

    @property
    def training(self) -> list[LoadCase]:
        return [case for case in self.setup.cases if case.role == "train"]

    @property
    def count(self) -> int:
        return len(self.training)

    @property
    def name(self) -> str:
        return name_of(self.count)


@dataclass(frozen=True, eq=False)
class Design:
    """What the load designer picked beside the first load case that is given."""

    at: str  #: which stiffness it was asked at
    picks: Sequence[LoadCase]  #: the best first
    candidates: int  #: that it had to choose from
    left_out: Sequence[str]  #: picks in which the reference has no answer


def name_of(count: int) -> str:
    return f"{count} load case{'s' if count > 1 else ''}"


def given(setup: Setup) -> Iterator[CaseSet]:
    """The first few of a scene's load cases, more and more of them until all."""
    training = [number for number, case in enumerate(setup.cases) if case.role == "train"]
    for count in _counts(len(training), len(training)):
        chosen = training[:count]
        yield CaseSet(GIVEN, _learning_from(setup, chosen, [], setup.reference_positions[:0]), count == len(training))


def designed(setup: Setup, found: Design) -> Iterator[CaseSet]:
    """The first load case and the first few picks, more and more of them until all."""
    reference = setup.objective.reference
    assert reference is not None  # of a scene that was built
    first = next(number for number, case in enumerate(setup.cases) if case.role == "train")
    positions = deformed(setup.scene, reference, found.picks) if found.picks else setup.reference_positions[:0]
    given_count = sum(case.role == "train" for case in setup.cases)
    for count in _counts(given_count, len(found.picks) + 1):
        if count > 1:
            added = found.picks[: count - 1]
            yield CaseSet(DESIGNED, _learning_from(setup, [first], added, positions[: count - 1]), False)


def run_design(setup: Setup) -> Design:
    """Picks by the criterion D, from the scene's other training load cases and from generated ones.

    No generated one is a load case of the scene, training or test, at another size of its load. Sensitivities are those
    at the analytic start or, where there is none, in the middle of the box: what is known before identification.

    Raises UserError where there are too many unknowns, or no derivatives.
    """
    training = [number for number, case in enumerate(setup.cases) if case.role == "train"]
    point = _point(setup)
    most = max(int(LARGEST_FACTOR * len(training)), LEAST_DESIGNED)
    wanted = _counts(len(training), most)[-1] - 1
    if 2 * wanted**2 * setup.encoding.size**3 > TOO_MUCH_WORK:
        raise UserError(
            f"{setup.encoding.size:,} unknowns are too many for a design of {wanted} load cases in reasonable time; "
            "choose a coarser lattice."
        )
    candidates = _candidates(setup, point, wanted)
    if not candidates:
        return Design(point.said, [], 0, [])
    first = _learning_from(setup, training[:1], [], setup.reference_positions[:0])
    noise = NOISE * setup.objective.smallest_rest_length
    picks = design(first, point, candidates, min(wanted, len(candidates)), criterion="D", noise=noise)
    picked = [pick.candidate.case for pick in picks]
    has_answer = [_has_answer(setup, case) for case in picked]
    good = [case for case, is_good in zip(picked, has_answer, strict=True) if is_good]
    left_out = [case.name for case, is_good in zip(picked, has_answer, strict=True) if not is_good]
    return Design(point.said, good, len(candidates), left_out)


def _counts(given_count: int, most: int) -> list[int]:
    """How many load cases a series has: those of `COUNTS`, and as many as are given."""
    least = 1 if given_count <= FEW else 2
    return sorted({count for count in (*COUNTS, given_count) if least <= count <= most} | {min(given_count, most)})


def _learning_from(setup: Setup, own: Sequence[int], added: Sequence[LoadCase], positions: Floats) -> Setup:
    """The setup with these training load cases of its own, and others whose positions are given, shape (a, ..., n, d).

    Weights of its own stay; others weigh 1.
    """
    tests = [number for number, case in enumerate(setup.cases) if case.role == "test"]
    objective = setup.objective
    cases = [*(setup.cases[number] for number in own), *added, *(setup.cases[number] for number in tests)]
    known = np.concatenate([setup.reference_positions[list(own)], positions, setup.reference_positions[tests]])
    weights = np.asarray(objective.weights)
    smaller = Objective(
        setup.model,
        cases,
        known,
        minimize=objective.minimize,
        weights=np.concatenate([weights[list(own)], np.ones(len(added)), weights[tests]]),
        tolerance=objective.tolerance,
        cost_cap=setup.scene.objective.cost_cap,
        reference=objective.reference,
    )
    return replace(setup, cases=cases, reference_positions=known, objective=smaller)


def _point(setup: Setup) -> Point:
    try:
        return choose_point(setup, "start")
    except UserError:
        return choose_point(setup, "middle")


def _candidates(setup: Setup, point: Point, wanted: int) -> list[Candidate]:
    """The scene's own, and as many generated ones, evenly chosen, as can be looked at in reasonable time."""
    own = [Candidate(case) for case in setup.cases if case.role == "train"][1:]
    try:
        new = generated(setup, setup.encoding.decode(point.numbers))
    except UserError:  # nothing moves, so that new loads have no size
        new = []
    names = {case.name for case in setup.cases}
    new = [each for each in new if each.case.name not in names]
    new = [each for each in new if not any(_is_same(each.case, case) for case in setup.cases)]
    room = max(2 * wanted, int(MOST_WORK / (max(wanted, 1) * setup.encoding.size**3))) - len(own)
    step = int(np.ceil(len(new) / max(room, 1))) if new else 1
    return [*own, *new[::step]]


def _is_same(case: LoadCase, other: LoadCase) -> bool:
    """Whether two load cases differ in the size of their load alone."""
    if not np.array_equal(case.supports, other.supports):
        return False
    a, b = (np.concatenate([each.forces.ravel(), each.prescribed.ravel()]) for each in (case, other))
    size = a @ a
    return bool(size > 0 and np.linalg.norm(b - (a @ b / size) * a) <= PARALLEL * np.linalg.norm(b))


def _has_answer(setup: Setup, case: LoadCase) -> bool:
    assert setup.objective.reference is not None
    try:
        setup.objective.reference.deform(case)
    except UserError:
        return False
    return True
