"""Motions that are known: SciPy's Runge-Kutta method of eighth order, far tighter than any step that it judges.

Dormand and Prince's method (Hairer, Norsett and Wanner 1993, section II.5) is explicit and has nothing in common with
the implicit steps of the forward solve. Its error is estimated by a second run, which is allowed a hundred times more.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count

import numpy as np
from scipy.integrate import solve_ivp

from springopt.checks import Floats
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.tradeoff.independent.system import System

ALLOWED = 1e-12  # relative, of one step
CHECKED = 100.0  # times more is allowed for the run that checks
ROUGHLY = 1e-4  # for a run that finds how large all gets
MOST_EVALUATIONS = 500_000  # of the forces: a minute or two


@dataclass(frozen=True, eq=False)
class KnownMotion:
    """Of one load case."""

    displacements: Floats  #: at its times [length], shape (t, n, d)
    doubt: float  #: how far the run that checks is away, at most, as a share of the largest displacement


def massless_node(masses: Floats, case: LoadCase) -> int | None:
    """The first node that is free to move and has no mass, shape (n,), which an explicit method can't follow."""
    found = np.flatnonzero(case.free.any(axis=1) & (masses <= 0.0))
    return int(found[0]) if len(found) else None


def known_motion(system: System, case: LoadCase) -> KnownMotion:
    """From rest at time 0, where loads and prescribed displacements come on at once, and last.

    Raises UserError for a free node without mass, and where the method gives up.
    """
    node = massless_node(system.masses, case)
    if node is not None:
        raise UserError(
            f"the motion of load case {case.name!r} should be known, but its node {node} moves and has no mass; give "
            "every free node a mass."
        )
    scales = _scales(system, case)
    displacements = _follow(system, case, ALLOWED, scales)[0]
    apart = np.abs(displacements - _follow(system, case, CHECKED * ALLOWED, scales)[0]).max()
    largest = np.abs(displacements).max()
    return KnownMotion(displacements, float(apart / largest) if largest > 0.0 else 0.0)


def _scales(system: System, case: LoadCase) -> tuple[float, float]:
    """How large displacements and velocities get: what is small of them counts beside the largest alone."""
    u, free = np.where(case.free, 0.0, case.prescribed), case.free
    pushes = np.abs((case.forces + system.loads - system.forces(u))[free])
    masses = np.broadcast_to(system.masses[:, None], free.shape)[free]
    start = float((pushes / masses).max(initial=0.0))
    if start == 0.0:  # nothing moves
        return 1.0, 1.0
    # What the first acceleration leads to within a short period is less than what there will be.
    assert case.times is not None  # it is a motion
    squares = system.tangent(u).diagonal()[free.ravel()] / masses
    frequency = float(np.sqrt(max(squares.max(), case.times[-1] ** -2.0)))
    _, largest, fastest = _follow(system, case, ROUGHLY, (start / frequency**2, start / frequency))
    return largest, fastest


def _follow(system: System, case: LoadCase, allowed: float, scales: tuple[float, float]) -> tuple[Floats, float, float]:
    """(displacements at all times of a load case (t, n, d), the largest one, the largest velocity)."""
    assert case.times is not None  # it is a motion
    until, evaluations = case.times[-1], count(1)
    free, loads = case.free, case.forces + system.loads
    masses = np.broadcast_to(system.masses[:, None], free.shape)[free]
    size = len(masses)
    u, v = np.where(free, 0.0, case.prescribed), np.zeros(free.shape)

    def slope(now: float, state: Floats) -> Floats:
        if next(evaluations) > MOST_EVALUATIONS:
            raise UserError(
                f"the motion of load case {case.name!r} should be known up to time {until:g}, but up to "
                f"{now:.3g} it took {MOST_EVALUATIONS:,} evaluations of the forces; look at shorter times, or at "
                "softer contact."
            )
        u[free], v[free] = np.split(state, 2)
        acceleration = (loads - system.forces(u) - system.drag(u, v))[free] / masses
        return np.concatenate([state[size:], acceleration])

    state, begin, largest, fastest = np.zeros(2 * size), 0.0, 0.0, 0.0
    answers, smallest = [], allowed * np.repeat(scales, size)
    for end in case.times if size else []:
        # Time by time, since what the method says between its steps is less exact than they are.
        found = solve_ivp(slope, (begin, end), state, "DOP853", rtol=allowed, atol=smallest)
        if not found.success:
            raise UserError(
                f"the motion of load case {case.name!r} should be known up to time {until:g}, but SciPy's "
                f"DOP853 ends at {found.t[-1]:g}; look at shorter times, or at smaller loads."
            )
        state, begin = found.y[:, -1], end
        largest = max(largest, float(np.abs(found.y[:size]).max()))
        fastest = max(fastest, float(np.abs(found.y[size:]).max()))
        answers.append(np.where(free, 0.0, case.prescribed))
        answers[-1][free] = state[:size]
    if not size:
        answers = [np.where(free, 0.0, case.prescribed)] * len(case.times)
    return np.stack(answers), largest, fastest
