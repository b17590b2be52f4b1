"""The derivatives of every stage of a motion, see `motion.derivatives`."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from springopt.effects.compile import compiled
from springopt.effects.effect import Kernel
from springopt.effects.probe import force_derivatives, probe, pulls_of_law
from springopt.effects.springs import COLLAPSED
from springopt.forward.batch import Group
from springopt.forward.motion.evaluation import GAUSS
from springopt.forward.motion.steps import GAMMA
from springopt.forward.spring_forces import forces_at_nodes, work_per_stiffness
from springopt.forward.terms import Term, Terms

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

#: Dissipations say how they change with the speed alone; by the displacements differences tell, of this share of a
#: spring's length, extrapolated once.
DIFFERENCE = 1e-3


@dataclass(frozen=True, eq=False)
class Stage:
    """One stage: speed = to_speed (end - base), acceleration = to_acceleration (speed - base speed)."""

    to_speed: float
    to_acceleration: float
    inverse: Floats  #: of the derivative of G by the end; 0 where supports hold, shape (n d, n d)
    by_base: Floats  #: the derivative of G by the base, shape (n d, n d)
    masses: Floats  #: shape (n d,)
    ends: NDArray[np.int64]  #: of the springs, shape (s, 2)
    pulls: Floats  #: of the springs per stiffness, shape (s, d)
    by_row: Floats  #: what else G changes by with the row, shape (s + p, n d), or (0, n d) where nothing does

    def along(self, base: Floats, base_speed: Floats, changes: Floats) -> tuple[Floats, Floats, Floats]:
        """Changes of end, speed and acceleration, (n d, k) each, with those of the base and of the row (s + p, k)."""
        pushed = self.by_base @ base - self.to_acceleration * self.masses[:, None] * base_speed
        springs = np.ascontiguousarray(changes[: len(self.ends)].T)
        count = len(self.masses) // self.pulls.shape[1]
        for k, change in enumerate(springs):
            pushed[:, k] -= forces_at_nodes(self.ends, self.pulls[None], change, count)[0]
        if len(self.by_row):
            pushed += self.by_row.T @ changes
        end = -self.inverse @ pushed
        speed = self.to_speed * (end - base)
        return end, speed, self.to_acceleration * (speed - base_speed)

    def against(self, end: Floats, speed: Floats, acceleration: Floats, answer: Floats) -> tuple[Floats, Floats]:
        """Derivatives by base and base speed, (n d,) each, from those by what the stage led to.

        Those by the row are added to `answer` (s + p,).
        """
        speed = speed + self.to_acceleration * acceleration
        adjoint = self.inverse.T @ (end + self.to_speed * speed)
        base = -self.to_speed * speed - self.by_base.T @ adjoint
        base_speed = -self.to_acceleration * acceleration + self.to_acceleration * self.masses * adjoint
        answer[: len(self.ends)] += work_per_stiffness(self.ends, self.pulls[None], adjoint[None, None])[0, 0]
        if len(self.by_row):
            answer -= self.by_row @ adjoint
        return base, base_speed


@dataclass(frozen=True, eq=False)
class _Ways:
    """The stages of all steps side by side: where each begins and ends, and at which speed."""

    base: Floats  #: shape (l, n d)
    base_speed: Floats
    end: Floats
    to_speed: Floats  #: shape (l,)
    to_acceleration: Floats

    @property
    def speed(self) -> Floats:
        return self.to_speed[:, None] * (self.end - self.base)

    @property
    def acceleration(self) -> Floats:
        return self.to_acceleration[:, None] * (self.speed - self.base_speed)


def stages_of(
    group: Group, row: Floats, u: Floats, v: Floats, steps: Floats, is_euler: Booleans, *, is_midpoint: bool
) -> list[tuple[Stage, ...]]:
    """The stages of every step, from the states (steps + 1, n d) between them; of implicit Euler one."""
    if is_midpoint:
        ways = _Ways(u[:-1], v[:-1], u[1:], 1.0 / steps, 2.0 / steps)
        return [(stage,) for stage in _stages(group, row, ways, is_midpoint=True)]
    reach = GAMMA * steps[:, None]
    rest = steps[:, None] - reach
    stage_speed = (u[1:] - u[:-1] - reach * v[1:]) / rest
    stage_acceleration = (stage_speed - v[:-1]) / reach
    factor = 1.0 / reach[:, 0]
    first = _Ways(u[:-1], v[:-1], u[:-1] + reach * stage_speed, factor, factor)
    second = _Ways(u[:-1] + rest * stage_speed, v[:-1] + rest * stage_acceleration, u[1:], factor, factor)
    both = [_stages(group, row, ways, is_midpoint=False) for ways in (first, second)]
    stages: list[tuple[Stage, ...]] = list(zip(*both, strict=True))
    jumps = np.flatnonzero(is_euler)
    if len(jumps):
        whole = 1.0 / steps[jumps]
        euler = _stages(group, row, _Ways(u[jumps], v[jumps], u[jumps + 1], whole, whole), is_midpoint=False)
        for step, stage in zip(jumps.tolist(), euler, strict=True):
            stages[step] = (stage,)
    return stages


def _stages(group: Group, row: Floats, ways: _Ways, *, is_midpoint: bool) -> list[Stage]:
    terms, plan, d = group.terms, group.plan, group.plan.dimension
    stiffness, values = np.split(row, [len(plan.ends)])
    masses = np.repeat(terms.masses(values), d)
    free = np.setdiff1d(np.arange(len(masses)), plan.supported)
    dense = np.ix_(np.arange(len(ways.base)), free, free)
    by_end, by_base = _slopes(terms, plan, stiffness, values, ways, is_midpoint=is_midpoint)
    inertia = (ways.to_speed * ways.to_acceleration)[:, None] * masses
    every = np.arange(len(masses))
    by_end[:, every, every] += inertia
    by_base[:, every, every] -= inertia
    inverse = np.zeros_like(by_end)
    inverse[dense] = np.linalg.inv(by_end[dense])
    pulls = _pulls(terms, plan, values, ways, is_midpoint=is_midpoint)
    by_row = _by_row(terms, stiffness, values, ways, is_midpoint=is_midpoint)
    return [
        Stage(
            to_speed=ways.to_speed[step],
            to_acceleration=ways.to_acceleration[step],
            inverse=inverse[step],
            by_base=by_base[step],
            masses=masses,
            ends=plan.ends,
            pulls=pulls[step],
            by_row=by_row[step],
        )
        for step in range(len(ways.base))
    ]


def _points(ways: _Ways, *, is_midpoint: bool) -> list[tuple[float, float, Floats]]:
    """(weight, share of the end, displacements) of the points where potentials are taken."""
    if not is_midpoint:
        return [(1.0, 1.0, ways.end)]
    return [(0.5, share, ways.base + share * (ways.end - ways.base)) for share in GAUSS]


def _slopes(
    terms: Terms, plan: Any, stiffness: Floats, values: Floats, ways: _Ways, *, is_midpoint: bool
) -> tuple[Floats, Floats]:
    """Derivatives of internal forces and dissipation by end and base, shape (l, n d, n d) each."""
    by_end, by_base = np.zeros((2, len(ways.base), plan.nodes.size, plan.nodes.size))
    springs = (plan.ends, plan.rest_vectors, plan.natural_lengths)
    _spring_slopes(*springs, stiffness, ways.base, ways.end, is_midpoint, by_end, by_base)
    for term, kernel in terms.potentials:
        if is_midpoint and kernel.between is not None:
            own = partial(probe, kernel.on_the_way(), terms.lattice, stiffness=stiffness, values=values[term.columns])
            # It is the same there and back, so that the derivative by the base is that by the end, turned round.
            by_end += _dense(kernel, own(ways.end, velocities=ways.base).blocks, plan.nodes.size)
            by_base += _dense(kernel, own(ways.base, velocities=ways.end).blocks, plan.nodes.size)
            continue
        for weight, share, at in _points(ways, is_midpoint=is_midpoint):
            blocks = probe(kernel, terms.lattice, at, stiffness=stiffness, values=values[term.columns]).blocks
            matrices = weight * _dense(kernel, blocks, plan.nodes.size)
            by_end += share * matrices
            by_base += (1.0 - share) * matrices
    at, share = ((ways.base + ways.end) * 0.5, 0.5) if is_midpoint else (ways.end, 1.0)
    for term, kernel in terms.dissipations:
        ask = partial(probe, kernel, terms.lattice, stiffness=stiffness, values=values[term.columns])
        blocks = ask(at, velocities=ways.speed).blocks
        by_speed = ways.to_speed[:, None, None] * _dense(kernel, blocks, plan.nodes.size)
        moved = _by_displacements(ask, at, ways.speed, DIFFERENCE * plan.step_limit)
        by_end += by_speed + share * moved
        by_base += (1.0 - share) * moved - by_speed
    return by_end, by_base


def _dense(kernel: Kernel, blocks: Floats, size: int) -> Floats:
    """The symmetric matrices that blocks (l, q, d, d) of pairs of nodes stand for, shape (l, n d, n d)."""
    d = blocks.shape[-1]
    matrices = np.zeros((len(blocks), size // d, d, size // d, d))
    i, j = kernel.pairs.T
    off = i != j
    # Axes that are indexed come first.
    np.add.at(matrices.transpose(1, 3, 0, 2, 4), (i, j), blocks.swapaxes(0, 1))
    np.add.at(matrices.transpose(1, 3, 0, 2, 4), (j[off], i[off]), blocks[:, off].swapaxes(0, 1).swapaxes(2, 3))
    return matrices.reshape(len(blocks), size, size)


def _by_displacements(ask: Any, at: Floats, speed: Floats, step: float) -> Floats:
    """The derivative of a dissipation by the displacements at (l, n d), shape (l, n d, n d)."""
    count, size = at.shape
    speeds = np.repeat(speed, size, axis=0)

    def central(h: float) -> Floats:
        shifts = np.tile(h * np.eye(size), (count, 1))
        here = np.repeat(at, size, axis=0)
        forward, backward = (ask(here + sign * shifts, velocities=speeds).forces for sign in (1.0, -1.0))
        return ((forward - backward) / (2.0 * h)).reshape(count, size, size).swapaxes(1, 2)

    return (4.0 * central(step / 2) - central(step)) / 3.0


def _pulls(terms: Terms, plan: Any, values: Floats, ways: _Ways, *, is_midpoint: bool) -> Floats:
    """What each spring pulls its first node with over its stiffness, shape (l, s, d)."""
    pulls = np.empty((len(ways.base), *plan.rest_vectors.shape))
    springs = (plan.ends, plan.rest_vectors, plan.natural_lengths)
    _spring_pulls(*springs, ways.base, ways.end, is_midpoint, pulls)
    for term, _ in terms.potentials:
        if term.effect.scales_with_stiffness:
            for weight, _, at in _points(ways, is_midpoint=is_midpoint):
                own, fitted = values[term.columns], terms.fitted_of(term)
                law = pulls_of_law(term.effect, terms.lattice, at, values=own, fitted=fitted, is_linear=False)
                pulls += weight * law
    return pulls


def _by_row(terms: Terms, stiffness: Floats, values: Floats, ways: _Ways, *, is_midpoint: bool) -> Floats:
    """What G changes by with the row beside the pulls of springs, shape (l, s + p, n d), or (l, 0, n d)."""
    if not len(values):
        return np.zeros((len(ways.base), 0, ways.base.shape[1]))
    springs = len(stiffness)
    answer = np.zeros((len(ways.base), springs + len(values), ways.base.shape[1]))
    for term, kernel in terms.potentials:
        if not terms.fitted_of(term):
            continue
        columns = slice(springs + term.columns.start, springs + term.columns.stop)
        if is_midpoint and kernel.between is not None:
            answer[:, columns] = _by_units(terms, term, kernel.on_the_way(), ways.end, ways.base)
            continue
        for weight, _, at in _points(ways, is_midpoint=is_midpoint):
            for number, u in enumerate(at):
                derivatives = force_derivatives(
                    term.effect,
                    kernel,
                    terms.lattice,
                    u,
                    stiffness=stiffness,
                    values=values[term.columns],
                    is_linear=False,
                )
                answer[number, columns] += weight * derivatives
    at = (ways.base + ways.end) * 0.5 if is_midpoint else ways.end
    for term, kernel in terms.dissipations:
        _add_dissipation(answer, terms, term, kernel, stiffness, values[term.columns], at, ways.speed)
    _add_masses(answer[:, springs:], terms, values, ways.acceleration)
    return answer


def _by_units(terms: Terms, term: Term, kernel: Kernel, end: Floats, base: Floats) -> Floats:
    """The derivatives of forces that are linear in the parameters, but for a constant, shape (l, k, n d)."""
    count = term.columns.stop - term.columns.start
    units = np.concatenate([np.zeros((1, count)), np.eye(count)])
    springs = np.zeros(terms.lattice.spring_count)
    answer = np.empty((len(end), count, end.shape[1]))
    for number, (there, here) in enumerate(zip(end, base, strict=True)):
        states, bases = (np.broadcast_to(state, (len(units), len(state))) for state in (there, here))
        forces = probe(kernel, terms.lattice, states, stiffness=springs, values=units, velocities=bases).forces
        answer[number] = forces[1:] - forces[0]
    return answer


def _add_dissipation(
    answer: Floats,
    terms: Terms,
    term: Term,
    kernel: Kernel,
    stiffness: Floats,
    values: Floats,
    at: Floats,
    speed: Floats,
) -> None:
    """Its forces are linear in its parameters, and in the stiffness."""
    springs = len(stiffness)
    candidates = np.concatenate(
        [stiffness[None].repeat(1 + len(values), axis=0), np.eye(springs), 0.0 * stiffness[None]]
    )
    own = np.concatenate([0.0 * values[None], np.eye(len(values)), values[None].repeat(springs + 1, axis=0)])
    for number, (u, v) in enumerate(zip(at, speed, strict=True)):
        states, speeds = (np.broadcast_to(vector, (len(own), len(vector))) for vector in (u, v))
        forces = probe(kernel, terms.lattice, states, stiffness=candidates, values=own, velocities=speeds).forces
        first = springs + term.columns.start
        answer[number, first : first + len(values)] += forces[1 : 1 + len(values)] - forces[0]
        answer[number, :springs] += forces[1 + len(values) : -1] - forces[-1]


def _add_masses(answer: Floats, terms: Terms, values: Floats, acceleration: Floats) -> None:
    """Inertia is linear in the parameters of masses."""
    by_node = acceleration.reshape(len(acceleration), terms.lattice.node_count, -1)
    for term in terms.terms:
        if term.has_masses:
            units = np.zeros((term.columns.stop - term.columns.start, len(values)))
            units[:, term.columns] = np.eye(len(units))
            masses = term.effect.masses(terms.lattice, terms.values(term, units))
            assert masses is not None
            inertia = masses[None, :, :, None] * by_node[:, None]
            answer[:, term.columns] += inertia.reshape(*inertia.shape[:2], -1)


@njit(error_model="numpy")
def _vector(ends: Any, rest_vectors: Any, spring: int, u: Any, vector: Any) -> float:
    """The vector of a spring at displacements u (n d), and its length."""
    d, square = rest_vectors.shape[1], 0.0
    for a in range(d):
        vector[a] = rest_vectors[spring, a] + u[ends[spring, 1] * d + a] - u[ends[spring, 0] * d + a]
        square += vector[a] * vector[a]
    return np.sqrt(square)


@compiled
def _spring_slopes(
    ends: Any,
    rest_vectors: Any,
    natural_lengths: Any,
    stiffness: Any,
    base: Any,
    end: Any,
    is_midpoint: bool,
    by_end: Any,
    by_base: Any,
) -> None:
    """Derivatives of the force k (1 - 2 L0 / (before + after)) (mean vector), or of k (1 - L0 / after) (vector)."""
    d = rest_vectors.shape[1]
    before, after, mean = np.empty(d), np.empty(d), np.empty(d)
    for step in range(len(base)):
        for spring in range(len(ends)):
            k, natural = stiffness[spring], natural_lengths[spring]
            length_after = _vector(ends, rest_vectors, spring, end[step], after)
            if is_midpoint:
                length_before = _vector(ends, rest_vectors, spring, base[step], before)
            else:
                length_before = length_after
                before[:] = after
            mean[:] = 0.5 * (before + after)
            lengths = max(length_before + length_after, 2.0 * COLLAPSED * natural)
            tension, along_after, along_before = k, 0.0, 0.0
            if natural > 0.0:
                tension = k * (1.0 - 2.0 * natural / lengths)
                along_after = 2.0 * k * natural / (lengths * lengths * max(length_after, COLLAPSED * natural))
                along_before = 2.0 * k * natural / (lengths * lengths * max(length_before, COLLAPSED * natural))
            i, j = ends[spring, 0] * d, ends[spring, 1] * d
            for a in range(d):
                for b in range(d):
                    same = 0.5 * tension if a == b else 0.0
                    to_end, to_base = same + along_after * mean[a] * after[b], same + along_before * mean[a] * before[b]
                    if not is_midpoint:
                        to_end, to_base = to_end + to_base, 0.0
                    for matrix, entry in ((by_end, to_end), (by_base, to_base)):
                        matrix[step, j + a, j + b] += entry
                        matrix[step, i + a, i + b] += entry
                        matrix[step, j + a, i + b] -= entry
                        matrix[step, i + a, j + b] -= entry


@compiled
def _spring_pulls(
    ends: Any, rest_vectors: Any, natural_lengths: Any, base: Any, end: Any, is_midpoint: bool, pulls: Any
) -> None:
    d = rest_vectors.shape[1]
    before, after = np.empty(d), np.empty(d)
    for step in range(len(base)):
        for spring in range(len(ends)):
            length_after = _vector(ends, rest_vectors, spring, end[step], after)
            length_before = length_after
            before[:] = after
            if is_midpoint:
                length_before = _vector(ends, rest_vectors, spring, base[step], before)
            lengths = max(length_before + length_after, 2.0 * COLLAPSED * natural_lengths[spring])
            tension = 1.0 - 2.0 * natural_lengths[spring] / lengths if natural_lengths[spring] > 0.0 else 1.0
            for a in range(d):
                pulls[step, spring, a] = tension * 0.5 * (before[a] + after[a])
