"""How exactly equilibria are found: tolerance and engine of the forward solve, exact kinematics or small displacements.

Judged by equilibria that are found apart from the forward solve (`independent.equilibrium`), always with exact
kinematics.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from springopt.analysis.point import choose_point
from springopt.checks import Floats
from springopt.effects.lanes import LANE_COUNT
from springopt.errors import UserError
from springopt.forward.batch import Equilibria
from springopt.forward.choose import ENGINES
from springopt.forward.status import STATUSES, has_equilibrium
from springopt.model import Model
from springopt.scene import Scene, Setup
from springopt.tradeoff.errors import relative_errors
from springopt.tradeoff.independent.equilibrium import TOLERANCE, KnownEquilibria, known_equilibria, polish
from springopt.tradeoff.independent.system import System
from springopt.tradeoff.point import Axis, Findings, Request, Setting, measure_settings

TOLERANCES = tuple(float(f"1e-{digits}") for digits in range(2, 13))
FEW_TOLERANCES = 1e-4, 1e-8, 1e-12  # where an engine has no time for all
#: The point and candidates beside it; fewer where time is short.
MOST_CANDIDATES = 16
#: How often candidates are drawn for those without an equilibrium, and the share of bits that are flipped to draw one.
DRAWS = 4
FLIPPED = 0.02
#: Calls of a setting that there should be time for: of several candidates, and of one at least.
CALLS, LEAST_CALLS = 12, 6
LEAST_SHARE = 0.5  # of the seconds, that are left to the clock whatever was spent before
ELSEWHERE = 1e-3  # further from a known equilibrium than any tight solve should be
LARGEST = 30_000  # degrees of freedom: SciPy's factors of larger ones take minutes
LANES_MOST = 1e9  # operations of a factor, as in `forward.choose`: a hundred times what lanes are chosen for


def _missing(scene: Scene) -> str | None:
    if scene.load_cases.times is not None:
        return "its load cases have times; the axis 'stepping' measures what motion costs"
    size = scene.lattice.build().nodes.size
    if size > LARGEST:
        return (
            f"its equilibria are known apart from the forward solve up to {LARGEST:,} degrees of freedom, not {size:,}"
        )
    return None


@dataclass(frozen=True, eq=False)
class _Solves:
    """What every setting solves, and the answers that are known."""

    setup: Setup
    candidates: Floats  #: shape (m, s + f)
    known: KnownEquilibria

    @property
    def count(self) -> int:
        return len(self.candidates) * len(self.setup.cases)

    def first(self, count: int) -> _Solves:
        """Those of the first candidates alone."""
        known = self.known
        few = {name: getattr(known, name)[:count] for name in ("displacements", "is_known", "has_none", "why")}
        return replace(self, candidates=self.candidates[:count], known=replace(known, **few))

    def setting(self, series: str, name: str, model: Model, tolerance: float, **said: Any) -> Setting:
        return Setting(
            series=series,
            name=name,
            run=partial(model.find, model.groups(self.setup.cases), self.candidates, tolerance),
            judge=self.judge,
            solves=self.count,
            numbers={"candidates": len(self.candidates)},
            count=lambda answer: {"iterations": float(np.median(answer.iterations))},
            why=self.why,
            **said,
        )

    def judge(self, answer: Equilibria) -> Floats:
        """Of every answer that can be judged; inf where there is none, or one where no equilibrium is."""
        errors, has_none = self.errors(answer), self.known.has_none | ~has_equilibrium(answer.codes)
        return np.where(has_none, np.inf, errors)[has_none | self.known.is_known]

    def errors(self, answer: Equilibria) -> Floats:
        """Of all answers, nan where nothing is known, shape (m, c)."""
        nodes = self.setup.lattice.nodes.astype(np.longdouble)
        u = answer.displacements.reshape(self.known.displacements.shape)
        # Answers are displacements: in double precision positions would round them.
        return relative_errors(nodes + u, nodes + self.known.displacements, self.setup.lattice.nodes)

    def why(self, answer: Equilibria) -> str:
        failed = [str(STATUSES[code]) for code in answer.codes[~has_equilibrium(answer.codes)]]
        reasons = [f"{status} in {count} of {self.count} solves" for status, count in Counter(failed).most_common()]
        wrong = np.count_nonzero(self.known.has_none & has_equilibrium(answer.codes))
        return ", ".join([*reasons, *([f"{wrong} answers where there is no equilibrium"] if wrong else [])])


def _measure(setup: Setup, request: Request) -> Findings:
    end = time.perf_counter() + request.seconds
    chosen = _chosen(setup)
    ladders, left_out = _ladders(setup, request, chosen)
    most = max((ladder.count for ladder in ladders), default=MOST_CANDIDATES)
    candidates, notes = _draw(setup, most, request.seed, chosen)
    ladders = [_cut(setup, request, ladder, candidates) for ladder in ladders]
    candidates = candidates[: max((ladder.count for ladder in ladders), default=len(candidates))]
    begin = "sparse" if chosen == "lanes" else "lanes" if _suits_lanes(setup) else "iterative"
    solves = _Solves(setup, candidates, known_equilibria(setup.model, begin, candidates, setup.cases))
    is_own = partial(_is_own, setup, chosen)
    settings = [
        _exact(solves.first(ladder.count), ladder.engine, tolerance, is_stated=is_own(ladder.engine, tolerance))
        for ladder in ladders
        for tolerance in ladder.tolerances
    ]
    try:
        settings.append(_small(solves))
    except UserError as error:  # an effect has no expansion at rest
        left_out.append(f"There is no setting of linear kinematics: {error}")
    fewer = [
        f"The engine {ladder.engine} is slower: it solves the first {ladder.count} of these {len(candidates)} "
        "candidates alone."
        for ladder in ladders
        if ladder.count < len(candidates)
    ]
    others = [
        said
        for ladder in ladders
        if ladder.engine != begin
        for said in _other_equilibria(solves.first(ladder.count), ladder.engine, begin)
    ]
    notes = [*notes, *fewer, *_said_of(solves.known, begin), *others, *left_out]
    notes.append("No engine offers single precision: all compute in double precision, where errors end at some 1e-16.")
    left = max(end - time.perf_counter(), LEAST_SHARE * request.seconds)
    return Findings(measure_settings(settings, replace(request, seconds=left)), notes=notes)


def _tolerances(setup: Setup) -> list[float]:
    """The scene's own among them, from loose to tight."""
    return sorted({*TOLERANCES, setup.objective.tolerance}, reverse=True)


def _is_own(setup: Setup, chosen: str, engine: str, tolerance: float) -> bool:
    """Whether the scene states exact kinematics with this engine, or is given it, and this tolerance."""
    is_exact = setup.model.kinematics == "exact"
    return is_exact and engine == chosen and tolerance == setup.objective.tolerance


def _with_engine(setup: Setup, engine: str | None) -> Model:
    return replace(setup.model, kinematics="exact", engine=engine)


def _series(engine: str) -> str:
    return f"exact, {engine}"


def _name(tolerance: float) -> str:
    digits = f"{tolerance:.0e}".replace("e-0", "e-")
    return f"tolerance {digits if float(digits) == tolerance else f'{tolerance:g}'}"


def _exact(solves: _Solves, engine: str, tolerance: float, *, is_stated: bool) -> Setting:
    setup = solves.setup
    model = replace(setup.model, kinematics="exact", engine=engine)
    states = {"kinematics": "exact", "engine": engine, "objective.tolerance": tolerance}
    return solves.setting(_series(engine), _name(tolerance), model, tolerance, states=states, is_stated=is_stated)


def _small(solves: _Solves) -> Setting:
    """Small displacements, by the engine that they are given: a direct solve, which no tolerance makes shorter."""
    setup = solves.setup
    engine = setup.model.engine if setup.model.kinematics == "linear" else None
    model = replace(setup.model, kinematics="linear", engine=engine)
    solver = model.groups(setup.cases)[0].choice.solver
    return solves.setting(
        f"linear, {solver}",
        "small displacements",
        model,
        setup.objective.tolerance,
        states={"kinematics": "linear"},
        is_stated=setup.model.kinematics == "linear",
    )


def _chosen(setup: Setup) -> str:
    """The engine that exact kinematics have in this scene, in most of its load cases."""
    counts: Counter[str] = Counter()
    for group in _with_engine(setup, setup.model.engine).groups(setup.cases):
        counts[group.choice.engine] += len(group.cases)
    return counts.most_common(1)[0][0]


def _suits_lanes(setup: Setup) -> bool:
    choices = [group.choice for group in _with_engine(setup, None).groups(setup.cases)]
    return all(choice.unknowns * choice.half_bandwidth**2 <= LANES_MOST for choice in choices)


@dataclass(frozen=True)
class _Ladder:
    """What there is time for with one engine."""

    engine: str
    tolerances: Sequence[float]  #: from loose to tight
    count: int  #: of the candidates


def _ladders(setup: Setup, request: Request, chosen: str) -> tuple[list[_Ladder], list[str]]:
    """(a ladder for each engine that there is time for, what is said of the others and of short ladders)."""
    ladders, notes = [], []
    candidate = setup.encoding.decode(choose_point(setup).numbers)[None]
    for engine in ENGINES:
        tolerances = [each for each in _tolerances(setup) if request.wants(_series(engine), _name(each))]
        if not tolerances:
            continue
        if engine == "lanes" and not _suits_lanes(setup):
            notes.append("The engine lanes is left out: factors of this size take it minutes.")
            continue
        seconds = _seconds(setup, engine, candidate)
        there_is = request.seconds / len(ENGINES) / (LEAST_CALLS * seconds)
        is_slow = f"{seconds:.2g} s for one candidate under all load cases are too long"
        # Settings that are asked for by name are measured, whatever that takes.
        if len(tolerances) > there_is and not request.only:
            own = [setup.objective.tolerance] if engine == chosen else []
            tolerances = [each for each in tolerances if each in (*FEW_TOLERANCES, *own)]
            if len(tolerances) > there_is and engine != chosen:
                notes.append(f"The engine {engine} is left out: {is_slow} for a third of {request.seconds:.3g} s.")
                continue
            notes.append(f"The engine {engine} is measured at few tolerances: {is_slow} for more of them.")
        count = _affordable(setup, request, _Ladder(engine, tolerances, MOST_CANDIDATES), seconds)
        ladders.append(_Ladder(engine, tolerances, count))
    return ladders, notes


def _affordable(setup: Setup, request: Request, ladder: _Ladder, seconds: float) -> int:
    """How many candidates, up to those of the ladder, an engine has time for that takes so many seconds for each."""
    least = 1
    if ladder.engine == "lanes":  # they hold load cases with the same supports, and are to be full as in a population
        groups = _with_engine(setup, ladder.engine).groups(setup.cases)
        least = -(-LANE_COUNT * len(groups) // len(setup.cases))
    there_are = request.seconds / len(ENGINES) / (CALLS * len(ladder.tolerances) * max(seconds, 1e-9))
    return min(max(least, int(min(there_are, MOST_CANDIDATES))), ladder.count)


def _cut(setup: Setup, request: Request, ladder: _Ladder, candidates: Floats) -> _Ladder:
    """The ladder for candidates that were drawn: they may be harder than the point is."""
    own = candidates[: ladder.count]
    seconds = _seconds(setup, ladder.engine, own) / len(own)
    return replace(ladder, count=_affordable(setup, request, replace(ladder, count=len(own)), seconds))


def _seconds(setup: Setup, engine: str, candidates: Floats) -> float:
    """Of a tight solve that is not the first one, which may compile."""
    model = _with_engine(setup, engine)
    groups = model.groups(setup.cases)
    model.find(groups, candidates[:1], TOLERANCE)
    begin = time.perf_counter()
    model.find(groups, candidates, TOLERANCE)
    return time.perf_counter() - begin


def _draw(setup: Setup, count: int, seed: int, chosen: str) -> tuple[Floats, list[str]]:
    """(candidates (m, s + f), what is said of them): the point, and others that have all equilibria."""
    point, model, rng = choose_point(setup), _with_engine(setup, chosen), np.random.default_rng(seed)
    groups, rows, tried = model.groups(setup.cases), [setup.encoding.decode(point.numbers)], 0
    for _ in range(DRAWS):
        if len(rows) == count:
            break
        drawn = _others(setup, point.numbers, rng, count - len(rows))
        answers = model.find(groups, drawn, TOLERANCE)
        assert isinstance(answers, Equilibria)  # load cases with times have motions
        rows += list(drawn[has_equilibrium(answers.codes).all(axis=1)])
        tried += len(drawn)
    said = f"Solved are all load cases ({len(setup.cases)}) of one candidate, {point.said}"
    if len(rows) > 1:
        kind = "flipping few of its bits" if setup.encoding.kind == "binary" else "chance from the box"
        said += f", and of others drawn by {kind} (seed {seed})"
    lost = tried - (len(rows) - 1)
    return np.array(rows), [f"{said}.", *([f"Of {tried} that were drawn {lost} had no equilibrium."] if lost else [])]


def _others(setup: Setup, point: Floats, rng: np.random.Generator, count: int) -> Floats:
    """Candidates (count, s + f); of bits most draws would be mechanisms, but for those near the point."""
    encoding = setup.encoding
    if encoding.kind != "binary":
        return encoding.decode(encoding.sample(rng, count))
    flips = max(1, round(FLIPPED * encoding.size))
    points = np.tile(point, (count, 1))
    for row in points:
        at = rng.choice(encoding.size, flips, replace=False)
        row[at] = 1.0 - row[at]
    return encoding.decode(points)


def _other_equilibria(solves: _Solves, engine: str, begin: str) -> list[str]:
    """What is said of an engine that ends elsewhere than the known equilibria were begun, in equilibria as well."""
    setup, known = solves.setup, solves.known
    model = _with_engine(setup, engine)
    answers = model.find(model.groups(setup.cases), solves.candidates, TOLERANCE)
    assert isinstance(answers, Equilibria)  # load cases with times have motions
    is_apart = known.is_known & has_equilibrium(answers.codes) & (solves.errors(answers) > ELSEWHERE)
    others = 0
    for candidate, case in zip(*np.nonzero(is_apart), strict=True):
        system = System.of(model, solves.candidates[candidate])
        ended = answers.displacements[candidate, case].reshape(setup.lattice.nodes.shape)
        others += not polish(system, setup.cases[case], ended).why
    if not others:
        return []
    return [
        f"In {others} of {solves.count} solves {engine} ends in another equilibrium than {begin}, however tight: there "
        "are several, and the error is the distance between them."
    ]


def _said_of(known: KnownEquilibria, begin: str) -> Sequence[str]:
    said = []
    if known.is_known.any():
        said.append(
            f"Errors are measured against equilibria that the engine {begin} begins and SciPy polishes, with forces "
            f"summed in long double precision until corrections are {known.doubt:.0e} of the displacements."
        )
    for why, count in Counter(known.why[known.why != ""]).items():
        where = f"In {count} of {known.why.size} solves"
        is_open = "so that any answer fails" if why.startswith("there is no") else "so that answers are not judged"
        said.append(f"{where} {why}, {is_open}.")
    return said


AXIS = Axis(
    name="solver",
    title="Tolerance, kinematics and engine of the forward solve",
    error="distance from the equilibrium / displacement",
    time="one forward solve",
    missing=_missing,
    measure=_measure,
    shown=("iterations",),
)
