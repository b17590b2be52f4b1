"""An identified model as it runs: of the springs that are there, ready to be solved for the load cases of its scene."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from springopt.checks import Floats
from springopt.forward.batch import Equilibria, Group
from springopt.forward.motion.follow import Motions
from springopt.forward.status import has_equilibrium
from springopt.misfit import MISFITS
from springopt.model import Model
from springopt.scene import Setup
from springopt.scene.build import build_model
from springopt.tradeoff.axes.model.resampling import why_springs_stay
from springopt.tradeoff.errors import errors_of_cases, say_failures


@dataclass(frozen=True, eq=False)
class Running:
    """A model, its stiffness and fitted parameters (s + f,), and the setup whose load cases it is asked for."""

    model: Model
    row: Floats
    setup: Setup

    @classmethod
    def of(cls, setup: Setup, row: Floats) -> Running:
        """Without the springs of no stiffness, which would cost their share of each solve.

        They stay where effects are stated spring by spring.
        """
        lattice = setup.lattice
        count = lattice.spring_count
        present = row[:count] > 0.0
        if present.all() or not present.any() or why_springs_stay(setup.scene) is not None:
            return cls(setup.model, row, setup)
        fewer = replace(lattice, springs=lattice.springs[present], rest_lengths=lattice.rest_lengths[present])
        return cls(build_model(setup.scene, fewer), np.concatenate([row[:count][present], row[count:]]), setup)

    @property
    def spring_count(self) -> int:
        return int(np.count_nonzero(self.row[: self.model.lattice.spring_count]))

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        return self.model.groups(self.setup.cases)

    def solve(self) -> Equilibria | Motions:
        """One candidate under all load cases of the scene."""
        return self.model.find(self.groups, self.row[None], self.setup.objective.tolerance)

    def errors(self, answers: Equilibria | Motions) -> Floats:
        """Mean distances from the reference over its mean displacements, inf where there is no answer, shape (c,)."""
        known = self._flat(self.setup.reference_positions)
        errors = errors_of_cases(self._positions(answers), known, self.setup.lattice.nodes)
        return np.where(has_equilibrium(answers.codes[0]), errors, np.inf)

    def misfits(self, answers: Equilibria | Motions) -> Floats:
        """In the scene's own definition, inf where there is no answer, shape (c,)."""
        objective = self.setup.objective
        differences = self._positions(answers) - self._flat(self.setup.reference_positions)
        values = MISFITS[objective.minimize].value(differences, objective.smallest_rest_length)
        return np.where(has_equilibrium(answers.codes[0]), values, np.inf)

    def why(self, answers: Equilibria | Motions) -> str:
        """Which load cases have no answer, and what their solve says of itself; "" if none."""
        return say_failures(self.setup.cases, answers.codes[0])

    def is_test(self) -> NDArray[np.bool_]:
        """Which load cases judge: those that test, or all that there are, shape (c,)."""
        tests = np.array([case.role == "test" for case in self.setup.cases])
        return tests if tests.any() else ~tests

    def _positions(self, answers: Equilibria | Motions) -> Floats:
        displacements = answers.displacements[0]
        shape = (*displacements.shape[:-1], *self.setup.lattice.nodes.shape)
        return self._flat(self.setup.lattice.nodes + displacements.reshape(shape))

    def _flat(self, positions: Floats) -> Floats:
        """Those of all times side by side, shape (c, t n, d)."""
        return positions.reshape(len(positions), -1, positions.shape[-1])
