"""The branch that a slow load follows: load steps from rest, each short enough to stay on it.

Where a load has several equilibria, `minimum` is the one that the search from rest descends to; `followed` is the one
that the body arrives at when the loads, and the prescribed displacements, grow from zero. A step starts where the
extrapolated last one ends. It is cut in half where the answer is not where it was expected: another branch may have
been caught. Where the shortest step does so the branch has ended, at a limit point, and the body snaps to what the
search from there descends to; so does a mechanism, at the first touch of a load.

A perfectly symmetric body could not decide which way to buckle. So the way is walked with imperfect loads, each
component IMPERFECTION times the largest load off, by a fixed pattern; the last step, at full load, is perfect.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springopt.forward.counter import make_counter
from springopt.forward.plan import Plan
from springopt.forward.state import Answers, Jobs
from springopt.forward.status import has_equilibrium

BRANCHES = MINIMUM, FOLLOWED = ("minimum", "followed")

IMPERFECTION = 1e-4
FIRST_STEP = 1.0 / 16.0
LONGEST_STEP = 1.0 / 8.0
SHORTEST_STEP = 2.0**-12
# A step may miss where it was expected to end by this share of its length; one that misses by less than the second
# share is followed by a longer one. Below the third, a share of a spring's length, no other branch is near.
MISS = 0.5
CLOSE_MISS = 0.1
NEAR = 0.02
# However well it was foretold, no step goes further than this many spring lengths.
FAR = 1.0

Floats = NDArray[np.float64]


@dataclass
class Ways:
    """How far each job has come; changes as the steps are taken."""

    load: Floats  #: share of the full load that has been reached, shape (jobs,)
    step: Floats  #: the next step, shape (jobs,)
    here: Floats  #: displacements, shape (jobs, n d)
    speed: Floats  #: displacements per share of the load over the last step, shape (jobs, n d)


def follow(plan: Plan, jobs: Jobs, search: Callable[[Jobs], Answers]) -> Answers:
    """The answers to all jobs, at the end of the way from rest; `search` descends from where a job starts.

    A job that finds no equilibrium on its way, with the shortest step, ends there with that status.
    """
    full_forces, full_start = jobs.forces[jobs.case], jobs.start
    imperfect = full_forces + imperfection(plan, full_forces)
    count, size = full_start.shape
    ways = Ways(np.zeros(count), np.full(count, FIRST_STEP), np.zeros((count, size)), np.zeros((count, size)))
    iterations = np.zeros(count, dtype=np.int64)
    if count and (plan.prestrains.any() or len(plan.potentials.table)):  # it may not rest where it was laid out
        rest = search(_part(jobs, np.arange(count), 0.0 * full_forces, 0.0 * full_start))
        ways.here[:] = np.where(has_equilibrium(rest.codes)[:, None], rest.displacements, 0.0)
        iterations += rest.iterations
    active = np.arange(count)
    while len(active):
        load = np.minimum(ways.load[active] + ways.step[active], 1.0)
        start = _expected(plan, ways, active, load, full_start)
        answers = search(_part(jobs, active, load[:, None] * imperfect[active], start))
        iterations[active] += answers.iterations
        active = active[_advance(plan, ways, active, load, start, answers)]
    start = ways.here.copy()
    start[:, plan.supported] = full_start[:, plan.supported]
    answers = search(_part(jobs, np.arange(count), full_forces, start))
    return answers._replace(iterations=answers.iterations + iterations)


def imperfection(plan: Plan, forces: Floats) -> Floats:
    """Forces on every degree of freedom, IMPERFECTION times the largest load at most, shape (jobs, n d).

    Their pattern is the golden ratio's multiples modulo 1, less 1/2: no symmetry of a lattice is one of theirs.
    """
    size = plan.nodes.size
    pattern = 2.0 * np.modf((np.arange(size) + 1.0) * 0.5 * (np.sqrt(5.0) - 1.0))[0] - 1.0
    pattern[plan.supported] = 0.0
    return IMPERFECTION * np.abs(forces).max(axis=1, initial=0.0, keepdims=True) * pattern


def _part(jobs: Jobs, active: NDArray[np.int64], forces: Floats, start: Floats) -> Jobs:
    """Some of the jobs, each under forces of its own."""
    return Jobs(jobs.candidate[active], np.arange(len(active)), jobs.candidates, forces, start, make_counter())


def _expected(plan: Plan, ways: Ways, active: NDArray[np.int64], load: Floats, full_start: Floats) -> Floats:
    """Where the next step is expected to end; supports exactly."""
    start = ways.here[active] + (load - ways.load[active])[:, None] * ways.speed[active]
    start[:, plan.supported] = load[:, None] * full_start[active][:, plan.supported]
    return start


def _advance(
    plan: Plan, ways: Ways, active: NDArray[np.int64], load: Floats, start: Floats, answers: Answers
) -> NDArray[np.bool_]:
    """Take the steps that ended as expected, cut the others; which of the active jobs are still on their way."""
    way = np.abs(answers.displacements - ways.here[active]).max(axis=1, initial=0.0)
    miss = np.abs(answers.displacements - start).max(axis=1, initial=0.0)
    is_shortest = ways.step[active] <= SHORTEST_STEP
    is_near = way <= NEAR * plan.step_limit
    is_expected = is_near | ((miss <= MISS * way) & (way <= FAR * plan.step_limit))
    is_found = has_equilibrium(answers.codes)
    is_taken = is_found & (is_expected | is_shortest)
    taken, rows = active[is_taken], np.flatnonzero(is_taken)
    gone = load[rows] - ways.load[taken]
    displacements = answers.displacements[rows]
    # Behind a snap the way there foretells nothing.
    ways.speed[taken] = np.where(is_expected[rows, None], (displacements - ways.here[taken]) / gone[:, None], 0.0)
    ways.here[taken], ways.load[taken] = displacements, load[rows]
    is_easy = (miss <= CLOSE_MISS * way) | is_near
    longer = np.where(is_easy[rows], np.minimum(2.0 * ways.step[taken], LONGEST_STEP), ways.step[taken])
    ways.step[taken] = longer
    ways.step[active[~is_taken]] *= 0.5
    return (ways.load[active] < 1.0) & (is_found | ~is_shortest)
