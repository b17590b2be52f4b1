"""What is minimized, as a function of the residuals: half their squares' sum, or a weighted sum of node distances."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from springopt.checks import Floats
from springopt.problem import Problem
from springopt_gradient.norms import SumOfNorms
from springopt_gradient.quadratic import minimize_in_box


class Model(Protocol):
    """A measure of residuals that are linear in the step."""

    def step(self, damping: float, lower: Floats, upper: Floats) -> Floats:
        """The step (size,) in [lower, upper] where the measure + damping x mean curvature x |step|^2 / 2 is least."""


class Measure(Protocol):
    """A convex function of the residuals (r,), which grows with a power of them."""

    degree: ClassVar[int]

    def value(self, residuals: Floats) -> float: ...
    def model(self, residuals: Floats, jacobian: Floats) -> Model: ...
    def curvature(self, residuals: Floats, jacobian: Floats) -> Floats: ...  # of a parabola for large steps


class Squares:
    """Half the sum of squares."""

    degree: ClassVar[int] = 2

    def value(self, residuals: Floats) -> float:
        return 0.5 * float(residuals @ residuals)

    def model(self, residuals: Floats, jacobian: Floats) -> Model:
        return NormalEquations(self.curvature(residuals, jacobian), jacobian.T @ residuals)

    def curvature(self, residuals: Floats, jacobian: Floats) -> Floats:
        return jacobian.T @ jacobian


@dataclass(frozen=True, eq=False)
class Distances:
    """The sum over load cases and nodes of weights x lengths of the residuals, kinked where one of these is zero."""

    degree: ClassVar[int] = 1
    weights: Floats  #: shape (cases n,), in motion (cases t n,)
    dimension: int

    def value(self, residuals: Floats) -> float:
        return float(self.weights @ np.linalg.norm(residuals.reshape(-1, self.dimension), axis=1))

    def model(self, residuals: Floats, jacobian: Floats) -> Model:
        by_node = jacobian.reshape(len(self.weights), self.dimension, -1)
        moving = by_node.any(axis=(1, 2))
        return SumOfNorms(residuals.reshape(-1, self.dimension)[moving], by_node[moving], self.weights[moving])

    def curvature(self, residuals: Floats, jacobian: Floats) -> Floats:
        """Of parabolas that touch the distances where they are, or at their mean if they are below it."""
        lengths = np.linalg.norm(residuals.reshape(-1, self.dimension), axis=1)
        touched = np.maximum(lengths, lengths.mean() or 1.0)
        return jacobian.T @ (np.repeat(self.weights / touched, self.dimension)[:, None] * jacobian)


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """A step d changes the value by slope.d + d.curvature.d/2."""

    curvature: Floats  #: shape (size, size)
    slope: Floats  #: shape (size,)

    def step(self, damping: float, lower: Floats, upper: Floats) -> Floats:
        """Levenberg's damping: alike for every unknown."""
        unit = np.diag(self.curvature).mean() or 1.0
        return minimize_in_box(self.curvature + damping * unit * np.eye(len(self.slope)), self.slope, lower, upper)


def negligible(problem: Problem, start: float) -> float:
    """The value below which nothing is left to find, since the forward solve could not tell it from zero.

    Its tolerance is beside the value of a body that does not move or, where there is no body, that at the start.
    """
    objective: Any = problem.objective
    if "objective" in problem.supplies:
        training = [case.role == "train" for case in objective.cases]
        displacements = (objective.reference_positions - objective.model.lattice.nodes)[training]
        roots = np.sqrt(objective.weights[training])
        start = objective.value_of((displacements.reshape(len(roots), -1) * roots[:, None]).ravel())
    return start * objective.tolerance ** measures_of(problem)[-1].degree


def measures_of(problem: Problem) -> list[Measure]:
    """Least squares, which leads to the right place from afar; then the problem's own misfit, if it is another."""
    objective: Any = problem.objective
    if "objective" not in problem.supplies or objective.minimize == "least-squares":
        return [Squares()]
    *_, dimension = shape = objective.reference_positions.shape
    nodes = math.prod(shape[1:-1])  # at all times
    unit = objective.smallest_rest_length if objective.minimize == "relative-distance" else 1.0
    training = [weight for weight, case in zip(objective.weights, objective.cases, strict=True) if case.role == "train"]
    return [Squares(), Distances(np.repeat(np.sqrt(training), nodes) / (nodes * unit), dimension)]
