"""pymoo's particle swarm, Kennedy and Eberhart (1995), which adapts its weights as Zhan et al. (2009)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_pymoo.ranges import require_options


@dataclass(frozen=True)
class PSO(Optimizer):
    """Particle swarm of pymoo: each particle is drawn to the best that it and the swarm have seen."""

    name: ClassVar[str] = "pymoo-pso"
    needs: ClassVar[tuple[str, ...]] = ("real",)
    population: int = 25  #: particles
    inertia: float = 0.9  #: share of its velocity that a particle keeps, at first if it adapts
    cognitive: float = 2.0  #: pull of the particle's own best, at first if it adapts
    social: float = 2.0  #: pull of the swarm's best, at first if it adapts
    adaptive: bool = True  #: whether these three follow how spread out the swarm is
    fastest: float = 0.2  #: bound on a velocity, as a share of the box
    perturb_best: bool = True  #: whether one particle of each generation is a mutation of the swarm's best

    def __post_init__(self) -> None:
        require_options(self, population=(2, 1e6), inertia=(0, 2), cognitive=(0, 10), social=(0, 10), fastest=(0, 1))

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        from pymoo.algorithms.soo.nonconvex import pso

        from springopt_pymoo.search import Scene, first_generation, search

        algorithm = pso.PSO(
            pop_size=self.population,
            sampling=first_generation(problem, rng, self.population),
            w=self.inertia,
            c1=self.cognitive,
            c2=self.social,
            adaptive=self.adaptive,
            max_velocity_rate=self.fastest,
            pertube_best=self.perturb_best,
        )
        search(algorithm, Scene(problem), rng)
