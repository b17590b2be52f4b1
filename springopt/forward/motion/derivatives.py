"""How the motions of one candidate change with its row of stiffness and parameters: exact for the steps taken.

Each stage of the integrator leads from a base, displacements and speed, to its end, by G(end, base, base speed; row) =
0, see `motion.evaluation`. So derivatives are carried from stage to stage, forwards along a change of the row, or
backwards from a function of the motion (the discrete adjoint). Matrices are dense, and inverted once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from springopt.errors import NoEquilibrium, UserError
from springopt.forward.batch import Group
from springopt.forward.motion.follow import move
from springopt.forward.motion.slopes import Stage, stages_of
from springopt.forward.motion.stepping import ENERGY_MOMENTUM, Stepping
from springopt.forward.motion.steps import GAMMA
from springopt.forward.status import has_equilibrium

Floats = NDArray[np.float64]

LARGEST = 1_500  # degrees of freedom: the matrices of a step take 18 MB each
MOST_ENTRIES = 2.5e8  # of the matrices of all steps of a motion: 2 GB, some three times


@dataclass(frozen=True, eq=False)
class Track:
    """One load case: every stage of its motion, step by step."""

    stages: Sequence[tuple[Stage, ...]]  #: one of each step, or two
    steps: Floats  #: their lengths [time], shape (steps,)
    targets: NDArray[np.int64]  #: after which step each time is reached, shape (t,)


@dataclass(frozen=True, eq=False)
class MotionLinearization:
    """The derivatives of all motions of one candidate; as `derivatives.Linearization`, with t n d in place of n d."""

    tracks: Sequence[Track]  #: of each load case
    size: int  #: n d
    columns: int  #: s + p

    def along(self, change: Floats) -> Floats:
        """The derivative of the displacements along a change (s + p,) of the row, shape (c, t n d)."""
        return np.stack([self._forwards(track, change[:, None])[:, :, 0].ravel() for track in self.tracks])

    def against(self, loads: Floats) -> Floats:
        """The derivative (s + p,) of a function of all displacements by the row; `loads` (c, t n d), that by them."""
        answer = np.zeros(self.columns)
        for track, load in zip(self.tracks, loads, strict=True):
            answer += self._backwards(track, load.reshape(-1, self.size))
        return answer

    def jacobian(self) -> Floats:
        """The derivatives of the displacements by the row, shape (c, t n d, s + p)."""
        units = np.eye(self.columns)
        return np.stack([self._forwards(track, units).reshape(-1, self.columns) for track in self.tracks])

    def _forwards(self, track: Track, changes: Floats) -> Floats:
        """Along several changes (s + p, k) at once, shape (t, n d, k)."""
        u, v = np.zeros((2, self.size, changes.shape[1]))
        answers = []
        for stages, h in zip(track.stages, track.steps, strict=True):
            if len(stages) == 1:  # speed and acceleration are those of the end, or in its mean
                end, _, acceleration = stages[0].along(u, v, changes)
                u, v = end, v + h * acceleration
            else:
                _, speed, acceleration = stages[0].along(u, v, changes)
                rest = (1.0 - GAMMA) * h
                u, v, _ = stages[1].along(u + rest * speed, v + rest * acceleration, changes)
            answers.append(u)
        return np.stack([answers[step] for step in track.targets])

    def _backwards(self, track: Track, loads: Floats) -> Floats:
        """From the derivatives (t, n d) of a function by the displacements, shape (s + p,)."""
        u, v, zero = np.zeros((3, self.size))
        answer = np.zeros(self.columns)
        at = {int(step): number for number, step in enumerate(track.targets)}
        for step in range(len(track.steps) - 1, -1, -1):
            stages, h = track.stages[step], track.steps[step]
            if step in at:
                u = u + loads[at[step]]
            if len(stages) == 1:
                before, speed = stages[0].against(u, zero, h * v, answer)
                u, v = before, v + speed
            else:
                base, base_speed = stages[1].against(u, v, zero, answer)
                rest = (1.0 - GAMMA) * h
                before, speed = stages[0].against(zero, rest * base, rest * base_speed, answer)
                u, v = base + before, base_speed + speed
        return answer


def linearize_motion(
    groups: Sequence[Group], row: Floats, fitted: Floats, stepping: Stepping, *, tolerance: float
) -> MotionLinearization:
    """The motions of one candidate: its row (s + p,), and `fitted` (s + f,), what it was given as.

    Raises NoEquilibrium where one breaks off, UserError for steps that an error decides and for large systems.
    """
    size = groups[0].plan.nodes.size
    if stepping.step_error is not None:
        raise UserError(
            "derivatives of motion need steps that are fixed; leave step_error out, and make the step short."
        )
    if size > LARGEST:
        raise UserError(
            f"derivatives of motion are there for up to {LARGEST:,} degrees of freedom, not {size:,}; choose a coarser "
            "lattice, or an optimizer that needs values alone."
        )
    tracks: list[Track | None] = [None] * sum(len(group.cases) for group in groups)
    for group in groups:
        for number, case in enumerate(group.cases):
            tracks[case] = _track(group, number, row, fitted, stepping, tolerance)
    return MotionLinearization([track for track in tracks if track is not None], size, len(row))


def _track(group: Group, number: int, row: Floats, fitted: Floats, stepping: Stepping, tolerance: float) -> Track:
    times, targets = _every_step(group.times[number], stepping.step)
    if len(times) * group.plan.nodes.size**2 > MOST_ENTRIES:
        raise UserError(
            f"derivatives of a motion of {len(times):,} steps and {group.plan.nodes.size:,} degrees of freedom would "
            "need gigabytes; take longer steps, or an optimizer that needs values alone."
        )
    alone = _only(group, number, times)
    motions = move([alone], fitted[None], stepping, tolerance=tolerance)
    if not has_equilibrium(motions.codes[0, 0]):
        raise NoEquilibrium("The motion breaks off at this stiffness: no step forward balances the forces.")
    u = np.concatenate([group.prescribed[number][None], motions.displacements[0, 0]])
    v = np.concatenate([np.zeros((1, u.shape[1])), motions.velocities[0, 0]])
    steps = np.diff(times, prepend=0.0)
    is_midpoint = stepping.integrator == ENERGY_MOMENTUM
    stages = stages_of(group, row, u, v, steps, motions.is_euler[0, 0], is_midpoint=is_midpoint)
    return Track(stages, steps, targets)


def _every_step(times: Floats, step: float) -> tuple[Floats, NDArray[np.int64]]:
    """The end of every step (steps,), as `motion.steps` has them, and which of them each of the times (t,) is."""
    ends: list[Floats] = []
    for begin, end in zip(np.concatenate([[0.0], times[:-1]]), times, strict=True):
        count = max(int(np.ceil((end - begin) / step - 1e-9)), 1)
        ends.append(np.linspace(begin, end, count + 1)[1:])
    return np.concatenate(ends), np.cumsum([len(few) for few in ends]) - 1


def _only(group: Group, number: int, times: Floats) -> Group:
    """One load case of a group, looked at at other times."""
    own = slice(number, number + 1)
    return replace(
        group,
        cases=np.zeros(1, dtype=np.int64),
        forces=group.forces[own],
        work=group.work[own],
        prescribed=group.prescribed[own],
        times=times[None],
    )
