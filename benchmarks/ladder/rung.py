"""A rung of the ladder: a question, what is right to answer, and the verdict on what was answered."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import springopt as so
from ladder.extended import Body, polish
from springopt.model import Solution

READINGS = RIGHT, RIGHTLY_REFUSED, WRONGLY_REFUSED, SILENTLY_WRONG = (
    "right",
    "refused with the right status",
    "wrongly refused",
    "silently wrong",
)
#: What the forward solve promises of its residual, in relation to the force scale; its default.
TOLERANCE = 1e-8
#: How close an answer comes to a known one, or to the one that extended precision finds beside it.
CLOSE = 1e-7


@dataclass(frozen=True)
class Verdict:
    """How one rung was climbed."""

    family: str
    name: str
    is_solvable: bool
    reading: str
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Rung:
    """An equilibrium to find, or to refuse where there is none."""

    family: str
    name: str
    lattice: so.SpringLattice
    stiffness: np.ndarray
    case: so.LoadCase
    effects: tuple = ()
    known: np.ndarray | None = None  #: positions of the first nodes, shape (<= n, d), where they are unique
    close: float = CLOSE  #: how close to them, in relation to the largest displacement
    status: str | None = None  #: where it is known beforehand; the judge finds it too
    check: Callable[[Solution], str] | None = None  #: what is wrong with an answer, "" if nothing

    def verdict(self) -> Verdict:
        solution = so.Model(self.lattice, self.effects).solve(self.stiffness, [self.case])
        status = solution.status[0]
        is_solvable = self._has_minimum()
        if not status.has_equilibrium:
            is_right = not is_solvable and status == "mechanism"
            return self._read(is_solvable, RIGHTLY_REFUSED if is_right else WRONGLY_REFUSED, str(status))
        if not is_solvable:
            return self._read(False, SILENTLY_WRONG, f"{status}, though the forces of a loose part do not balance")
        fault = self.fault(solution)
        return self._read(True, SILENTLY_WRONG if fault else RIGHT, fault)

    def _read(self, is_solvable: bool, reading: str, reason: str) -> Verdict:
        return Verdict(self.family, self.name, is_solvable, reading, reason)

    @property
    def _weight(self):
        total = np.zeros(self.lattice.nodes.shape)
        for effect in self.effects:
            total = total + effect.constant_forces(self.lattice)
        return total

    def _has_minimum(self) -> bool:
        """Whether the forces balance on every part along every axis where nothing holds it.

        The energy of anything else falls without end; of what is held it grows without end, so that it has a minimum.
        """
        part = np.arange(self.lattice.node_count)
        ends = self.lattice.springs[np.asarray(self.stiffness) > 0]
        for _ in part:
            for i, j in ends:
                part[i] = part[j] = min(part[i], part[j])
        forces = self.case.forces + self._weight
        for number in np.unique(part):
            members = part == number
            is_held = self.case.supports[members].any(axis=0)
            net = np.abs(forces[members].sum(axis=0))
            if (net[~is_held] > 1e-12 * np.abs(forces).max(initial=0)).any():
                return False
        return True

    def fault(self, solution: Solution) -> str:
        """What is wrong with an answer, in a few words; "" if nothing is."""
        status = solution.status[0]
        body, u = Body.of(self.lattice, self.stiffness, self.case, self._weight), solution.displacements[0]
        if not (np.isfinite(u).all() and np.isfinite(solution.energy[0])):
            return "not finite"
        if (u != self.case.prescribed)[self.case.supports].any():
            return "a support moved"
        residual = float(np.abs(body.out_of_balance(u.astype(np.longdouble)).ravel()[body.free]).max(initial=0))
        if residual > max(TOLERANCE * body.force_scale(u), body.rounding(u)):
            return f"residual {residual:.1e}"
        exact, factor = polish(body, u)
        expected = "underdetermined" if factor.zero_count else "converged"
        if factor.negative_count:
            return f"a saddle: {factor.negative_count} directions down"
        if status != expected:
            return f"called {status}, is {expected}"
        return self._misfit(solution, body, u, exact) or (self.check(solution) if self.check else "")

    def _misfit(self, solution: Solution, body: Body, u: np.ndarray, exact: np.ndarray) -> str:
        size = max(np.abs(u).max(initial=0), np.finfo(float).tiny)
        moved = np.abs(u - exact).max(initial=0) / size
        if moved > CLOSE and solution.status[0] == "converged" and self.close <= CLOSE:
            return f"{moved:.1e} from the equilibrium beside it"
        magnitude = body.strain_energy(exact) + np.abs((body.forces * exact).sum())
        noise = 1e-12 * magnitude + body.rounding(u) * size
        if abs(body.energy(u.astype(np.longdouble)) - body.energy(exact)) > noise:
            return "energy above the equilibrium beside it"
        told = solution.energy[0] + np.vdot(self.case.forces + self._weight, self.lattice.nodes)
        absolute = magnitude + np.abs(np.vdot(self.case.forces + self._weight, self.lattice.nodes))
        if abs(told - body.energy(exact)) > 1e-10 * absolute + noise:
            return "tells another energy than it has"
        if self.status is not None and solution.status[0] != self.status:
            return f"called {solution.status[0]}, is {self.status}"
        if self.known is not None:
            off = np.abs(solution.positions[0][: len(self.known)] - self.known).max()
            if off > self.close * size:
                return f"{off / size:.1e} from the known answer"
        return ""
