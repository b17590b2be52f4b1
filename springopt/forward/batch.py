"""All candidates under all load cases: grouped by their supports, every group handed to the engine that suits it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from springopt.effects.lanes import LANE_COUNT
from springopt.forward.choose import Choice, choose, make_engine
from springopt.forward.counter import make_counter
from springopt.forward.engine import Engine
from springopt.forward.floating import net_forces_on_floating_parts
from springopt.forward.followed import MINIMUM, follow
from springopt.forward.plan import Plan, make_plan
from springopt.forward.state import Answers, Jobs
from springopt.forward.status import MECHANISM
from springopt.forward.terms import Terms
from springopt.forward.threads import run_all
from springopt.load_case import LoadCase


@dataclass(frozen=True)
class Group:
    """Load cases with the same supports: one plan, one engine."""

    terms: Terms
    plan: Plan
    choice: Choice  #: which engine, and why
    engine: Engine
    cases: NDArray[np.int64]  #: which of the load cases, shape (g,)
    forces: NDArray[np.float64]  #: 0 where supports take them up, shape (g, n d)
    work: NDArray[np.float64]  #: of the forces that supports take up, on their prescribed way, shape (g,)
    prescribed: NDArray[np.float64]  #: shape (g, n d)
    times: NDArray[np.float64]  #: when a motion is looked at, shape (g, t); without times (g, 0)

    def part(self, few: slice) -> "Group":
        """Some of its load cases alone, numbered from 0; the plan and the engine are the same."""
        return replace(
            self,
            cases=np.arange(len(self.cases[few])),
            forces=self.forces[few],
            work=self.work[few],
            prescribed=self.prescribed[few],
            times=self.times[few],
        )


@dataclass(frozen=True)
class Equilibria:
    """Answers of the forward solve for m candidates and c load cases."""

    displacements: NDArray[np.float64]  #: [length], shape (m, c, n d)
    codes: NDArray[np.int8]  #: see `status`, shape (m, c)
    residuals: NDArray[np.float64]  #: largest out-of-balance force of a free degree of freedom, shape (m, c)
    energies: NDArray[np.float64]  #: strain energy less forces . displacements, shape (m, c)
    iterations: NDArray[np.int64]  #: shape (m, c)


def group_by_supports(
    terms: Terms,
    cases: Sequence[LoadCase],
    *,
    kinematics: str = "exact",
    engine: str | None = None,
) -> tuple[Group, ...]:
    """One group for each set of supports, in the order of their first load case; options as in `choose`."""
    members: dict[bytes, list[int]] = {}
    for number, case in enumerate(cases):
        members.setdefault(case.supports.tobytes(), []).append(number)
    return tuple(
        _group(terms, [(number, cases[number]) for number in numbers], kinematics, engine)
        for numbers in members.values()
    )


def _group(
    terms: Terms,
    numbered: Sequence[tuple[int, LoadCase]],
    kinematics: str,
    engine: str | None,
) -> Group:
    supports = numbered[0][1].supports
    plan = make_plan(terms, supports)
    choice = choose(plan, kinematics, engine)
    whole = make_plan(terms, np.zeros_like(supports)) if kinematics == "linear" else None
    constant = terms.constant_forces
    forces = np.array([(case.forces + constant).ravel() for _, case in numbered])
    prescribed = np.array([case.prescribed.ravel() for _, case in numbered])
    return Group(
        terms=terms,
        plan=plan,
        choice=choice,
        engine=make_engine(choice, plan, whole),
        cases=np.array([number for number, _ in numbered], dtype=np.int64),
        forces=np.where(supports.ravel(), 0.0, forces),
        work=(forces * prescribed).sum(axis=1),
        prescribed=prescribed,
        times=np.array([() if case.times is None else case.times for _, case in numbered], dtype=float),
    )


def find(
    groups: Sequence[Group],
    candidates: NDArray[np.float64],
    *,
    tolerance: float,
    branch: str = MINIMUM,
    threads: int = 1,
) -> Equilibria:
    """The equilibria of all candidates, (m, s) or with parameters (m, s + f), on one of `followed.BRANCHES`.

    Threads share the work equilibrium by equilibrium (in large systems candidate by candidate); the answers are the
    same to the bit whatever their number.
    """
    candidate_count = len(candidates)
    rows = groups[0].terms.rows(candidates) if groups else candidates
    case_count = sum(len(group.cases) for group in groups)
    unknown_count = groups[0].plan.nodes.size if groups else 0
    equilibria = _make_equilibria((candidate_count, case_count), unknown_count)
    jobs_of = [_balanced_jobs(group, rows, tolerance, equilibria) for group in groups]
    if groups:
        with groups[0].terms.failures_raised():
            answers_of = _search(groups, jobs_of, tolerance, branch, threads)
    else:
        answers_of = []
    for group, jobs, answers in zip(groups, jobs_of, answers_of, strict=True):
        at = (jobs.candidate, group.cases[jobs.case])
        equilibria.displacements[at] = answers.displacements
        equilibria.codes[at] = answers.codes
        equilibria.residuals[at] = answers.residuals
        equilibria.energies[at] = answers.energies - group.work[jobs.case]
        equilibria.iterations[at] = answers.iterations
    return equilibria


def _make_equilibria(shape: tuple[int, int], unknown_count: int) -> Equilibria:
    return Equilibria(
        displacements=np.zeros((*shape, unknown_count)),
        codes=np.zeros(shape, dtype=np.int8),
        residuals=np.zeros(shape),
        energies=np.zeros(shape),
        iterations=np.zeros(shape, dtype=np.int64),
    )


def _balanced_jobs(group: Group, rows: NDArray[np.float64], tolerance: float, equilibria: Equilibria) -> Jobs:
    """The jobs of a group; where loads push a floating part away there is none, and the answer is written at once."""
    net = _net_forces(group, rows)
    is_mechanism = net > tolerance * np.abs(group.forces).max(axis=1, initial=0.0)
    pushed, cases = np.nonzero(is_mechanism)
    at = (pushed, group.cases[cases])
    equilibria.displacements[at] = group.prescribed[cases]
    equilibria.codes[at] = MECHANISM
    equilibria.residuals[at] = net[pushed, cases]
    # Contiguous, or each layout would have the kernels compiled once more.
    candidates, cases = map(np.ascontiguousarray, np.nonzero(~is_mechanism))
    return Jobs(candidates, cases, rows, group.forces, group.prescribed[cases], make_counter())


def _net_forces(group: Group, rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """The largest net force [force] on a part that nothing holds, shape (m, g)."""
    plan, potentials = group.plan, group.terms.potentials
    if not all(term.effect.is_translation_invariant for term, _ in potentials):  # it may hold what no support holds
        return np.zeros((len(rows), len(group.cases)))
    is_supported = np.zeros(plan.nodes.size, dtype=np.bool_)
    is_supported[plan.supported] = True
    ends, ties = plan.ends, rows[:, : len(plan.ends)]
    # A law of the springs is there where its spring is; whatever other effects couple they tie.
    others = [kernel.pairs for term, kernel in potentials if not term.effect.scales_with_stiffness]
    if others:
        pairs = np.concatenate(others)
        ends = np.concatenate([ends, pairs])
        ties = np.concatenate([ties, np.ones((len(rows), len(pairs)))], axis=1)
    return net_forces_on_floating_parts(ends, np.ascontiguousarray(ties), is_supported, group.forces, plan.dimension)


def _search(
    groups: Sequence[Group], jobs_of: Sequence[Jobs], tolerance: float, branch: str, threads: int
) -> list[Answers]:
    """The answers to the jobs of each group."""
    if branch == MINIMUM:
        return _descend([group.engine for group in groups], jobs_of, tolerance, threads)

    def on_branch(group: Group, jobs: Jobs) -> Answers:
        def search(jobs: Jobs) -> Answers:
            return _descend([group.engine], [jobs], tolerance, threads)[0]

        return search(jobs) if group.choice.engine == "linear" else follow(group.plan, jobs, search)

    return [on_branch(*pair) for pair in zip(groups, jobs_of, strict=True)]


def _descend(engines: Sequence[Engine], jobs_of: Sequence[Jobs], tolerance: float, threads: int) -> list[Answers]:
    """The minima that the jobs descend to from their starts."""
    answers_of = [_make_answers(*jobs.start.shape) for jobs in jobs_of]
    tasks = [
        partial(engine.find, jobs, answers, tolerance)
        for engine, jobs, answers in zip(engines, jobs_of, answers_of, strict=True)
    ]
    most = max((len(jobs.case) for jobs in jobs_of), default=0)
    # A thread that is done with its tasks joins the others in theirs, where there is work for it.
    try:
        run_all(tasks * min(threads, 1 + most // LANE_COUNT), threads)
    except BaseException:  # an error in a thread, or Ctrl-C: the others find nothing more to do
        for jobs in jobs_of:
            jobs.taken[0] = len(jobs.case)
        raise
    return answers_of


def _make_answers(count: int, size: int) -> Answers:
    return Answers(
        displacements=np.zeros((count, size)),
        codes=np.zeros(count, dtype=np.int8),
        residuals=np.zeros(count),
        energies=np.zeros(count),
        iterations=np.zeros(count, dtype=np.int64),
    )
