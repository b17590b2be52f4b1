"""SciPy's dual annealing: generalized simulated annealing (Xiang et al. 1997) with descents from its best points."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import OptimizeResult, dual_annealing, minimize

from springopt.checks import Floats
from springopt.errors import NoEquilibrium, UserError
from springopt.optimizer import Optimizer
from springopt.problem import Problem

LOST = 1e100  # a value that turns any line search back


@dataclass(frozen=True)
class DualAnnealing(Optimizer):
    """SciPy's dual annealing, descending from each new best point by the gradient (L-BFGS-B)."""

    name: ClassVar[str] = "dual-annealing"
    needs: ClassVar[tuple[str, ...]] = ("real",)
    draws: int = 10  #: points drawn at first: the search begins at the best, and measures values by their spread
    local_search: bool = True  #: whether it descends by the gradient, where there is one
    initial_temp: float = 5230.0  #: SciPy's: temperature of the first jumps; in (0.01, 50000]
    restart_temp_ratio: float = 2e-5  #: SciPy's: share of it at which the annealing begins anew; in (0, 1)
    visit: float = 2.62  #: SciPy's: how far the jumps go; in (1, 3]
    accept: float = -5.0  #: SciPy's: the lower, the fewer worse points are accepted; in (-10000, -5]

    def __post_init__(self) -> None:
        legal = {
            "draws": self.draws >= 1,
            "initial_temp": 0.01 < self.initial_temp <= 5e4,
            "restart_temp_ratio": 0 < self.restart_temp_ratio < 1,
            "visit": 1 < self.visit <= 3,
            "accept": -1e4 < self.accept <= -5,
        }
        for option, is_legal in legal.items():
            if not is_legal:
                raise UserError(
                    f"option {option} of dual-annealing is out of range at {getattr(self, option):g}; "
                    "`springopt list optimizers dual-annealing` says what is legal."
                )

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        points = problem.sample(rng, self.draws)
        values = problem.evaluate(points)
        descends = self.local_search and "gradient" in problem.supplies
        spread = float(np.median(values) - values.min()) or 1.0
        measured = Measured(problem, self.initial_temp / spread)
        dual_annealing(
            measured.value,
            list(zip(problem.lower, problem.upper, strict=True)),
            maxiter=sys.maxsize,
            maxfun=np.inf,
            minimizer_kwargs={"method": measured.descend},
            no_local_search=not descends,
            initial_temp=self.initial_temp,
            restart_temp_ratio=self.restart_temp_ratio,
            visit=self.visit,
            accept=self.accept,
            x0=points[values.argmin()],
            rng=rng,
        )


@dataclass(frozen=True)
class Measured:
    """A problem's values in units that fit SciPy's temperature: what it accepts depends on their size."""

    problem: Problem
    unit: float  #: by which values are multiplied

    def value(self, point: Floats) -> float:
        return self.unit * float(self.problem.evaluate(self._inside(point)[None])[0])

    def descend(self, value: Any, start: Floats, **_: Any) -> OptimizeResult:
        """L-BFGS-B from a point, in the place of SciPy's own, which would take differences for the gradient."""
        bounds = list(zip(self.problem.lower, self.problem.upper, strict=True))
        return minimize(self.slope, start, jac=True, method="L-BFGS-B", bounds=bounds)

    def slope(self, point: Floats) -> tuple[float, Floats]:
        """Value and gradient; where there is no equilibrium, a wall."""
        try:
            value, gradient = self.problem.gradient(self._inside(point))
        except NoEquilibrium:
            return LOST, np.zeros(self.problem.size)
        return self.unit * value, self.unit * gradient

    def _inside(self, point: Floats) -> Floats:
        """Rounding may leave the box by a bit."""
        return np.clip(point, self.problem.lower, self.problem.upper)
