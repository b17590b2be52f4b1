"""Sparse random references: is it found which springs there are, without noise and with it?

    ./run python benchmarks/sparse_references.py [--references 10]

References: springs of the grids of `paper-stiffness-2d` (65 to 90 % kept) and `paper-topology-3d` (40 to 90 %) are
dropped one at a time in a random order, none whose removal would make the rest tangent of a set of supports singular;
those that stay have a stiffness from 2 to 8. The loads are the scenes', each halved until no node moves by more than
half a spacing. Noise: normal, of this standard deviation in spacings, in every free coordinate of the reference.

Found by `balance`, then by `gauss-newton` from there, with stiffness in [0, 10] and nothing else known. Which springs
there are is then decided by Bayes' rule with what the script knows, the noise and how references are made: a spring is
present if that is more probable than not. Around the answer the residuals are taken as linear, J being their Jacobian:
the likelihood is normal, with J^T J / sigma^2 as its inverse covariance. In the prior a spring is absent, or present
with any stiffness from 2 to 8. Of the many combinations of presences a Gibbs sampler takes the mean.

The bound is what the same rule makes of an efficient estimator: of estimates drawn with covariance sigma^2 (J^T J)^-1
around the truth, J taken there. Differences to it in the last digits are chance: few springs in thousands are wrong.

F1 is 2 TP / (2 TP + FP + FN) over springs: the mean over references, and the worst. `balance` is the force balance
alone, a spring being present above 1. `error` is the root mean square error of the stiffness of present springs after
Gauss-Newton, each over that of the efficient estimator, which knows no bounds; springs that the loads do not tell are
left out.
"""

import argparse
import contextlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, log_ndtr
from threadpoolctl import threadpool_limits

import springopt as so
from springopt.encoding import Real
from springopt.optimizer import Optimizer
from springopt.options import make_optimizer
from springopt.reference.random_springs import pulls, thin_out
from springopt.registry import load_optimizer

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

KEPT = {"paper-stiffness-2d": (0.65, 0.9), "paper-topology-3d": (0.4, 0.9)}
SOFTEST, STIFFEST, UPPER = 2.0, 8.0, 10.0
NOISES = (0.0, 1e-5, 1e-4, 1e-3)
FURTHEST = 0.5  # spacings
TOLERANCE = 1e-10
EXACT = 1e-8  # noise that stands for none: what the equilibria are exact to
BOUND_SAMPLES = 8
SWEEPS, WARM_UP = 60, 20
ROUNDING = 1e-12  # share of a spring's information that is lost where others tell much more
WEAK = 1e-6  # information on a spring of which the loads tell nothing: an error of 1000


@dataclass(frozen=True, eq=False)
class Reference:
    """A sparse mass-spring model and what it does."""

    model: so.Model
    cases: list[so.LoadCase]
    stiffness: Floats  #: 0 where a spring was dropped, shape (s,)
    positions: Floats  #: shape (c, n, d)

    @property
    def present(self) -> Booleans:
        return self.stiffness > 0


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--references", type=int, default=10, help="of each grid")
    count = parser.parse_args().references
    threadpool_limits(1)
    print("| grid | noise | balance | balance, gauss-newton | bound | error |\n|---|---|---|---|---|---|")
    for scene in KEPT:
        references = [make_reference(scene, seed) for seed in range(count)]
        for noise in NOISES:
            print(
                row(scene, noise, [score(reference, scene, noise, seed) for seed, reference in enumerate(references)])
            )


def row(scene: str, noise: float, scores: list[Floats]) -> str:
    means, worst = np.mean(scores, axis=0), np.min(scores, axis=0)
    cells = [f"{mean:.4f} ({least:.3f})" for mean, least in zip(means[:3], worst[:3], strict=True)]
    error = f"{means[3]:.2f}" if noise else "-"
    return f"| {scene[-2:]} | {noise:g} | {' | '.join(cells)} | {error} |"


def score(reference: Reference, scene: str, noise: float, seed: int) -> Floats:
    """F1 of force balance, of Gauss-Newton from there and of the bound; the error in standard errors."""
    rng = np.random.default_rng([seed, 1])
    share = np.mean(KEPT[scene])
    balanced, refined, objective = find(reference, noise, rng)
    sigma = max(noise, EXACT)
    found = decide(*information(objective, refined, sigma), share, rng)
    truth = noiseless(reference)
    matrix, pull = information(truth, reference.stiffness, sigma)
    _, jacobian = truth.jacobian(reference.stiffness)
    drawn = [pull + jacobian.T @ rng.standard_normal(len(jacobian)) / sigma for _ in range(BOUND_SAMPLES)]
    bound = np.mean([f1(decide(matrix, pull, share, rng), reference.present) for pull in drawn])
    errors = np.sqrt(np.linalg.inv(matrix + WEAK * np.eye(len(matrix))).diagonal())
    told = reference.present & (errors < STIFFEST - SOFTEST)
    off = (refined - reference.stiffness)[told] / errors[told]
    return np.array(
        [
            f1(balanced > SOFTEST / 2, reference.present),
            f1(found, reference.present),
            bound,
            np.sqrt(np.mean(np.square(off))),
        ]
    )


def f1(found: Booleans, present: Booleans) -> float:
    return 2.0 * float((found & present).sum()) / float(found.sum() + present.sum())


def find(reference: Reference, noise: float, rng: np.random.Generator) -> tuple[Floats, Floats, so.Objective]:
    """The stiffness by force balance, the same after Gauss-Newton, and the objective that they were given."""
    free = np.array([case.free for case in reference.cases])
    positions = reference.positions + noise * free * rng.standard_normal(reference.positions.shape)
    objective = so.Objective(reference.model, reference.cases, positions, "least-squares", tolerance=TOLERANCE)
    encoding = Real(reference.model.lattice, upper=UPPER)
    problem = so.Problem(objective, encoding, so.Budget(evaluations=1000))
    balanced = run("balance", problem, rng)
    problem.start_at(balanced)
    return balanced, run("gauss-newton", problem, rng, starts=1), objective


def run(name: str, problem: so.Problem, rng: np.random.Generator, **options: object) -> Floats:
    """The best point after an optimizer was at work."""
    optimizer: Optimizer = make_optimizer(load_optimizer(name), options)
    with contextlib.suppress(so.BudgetSpent):
        optimizer.minimize(problem, rng)
    assert problem.best_point is not None
    return problem.best_point


def noiseless(reference: Reference) -> so.Objective:
    return so.Objective(reference.model, reference.cases, reference.positions, "least-squares", tolerance=TOLERANCE)


def information(objective: so.Objective, stiffness: Floats, sigma: float) -> tuple[Floats, Floats]:
    """The normal likelihood exp(-k.matrix.k / 2 + pull.k) of the stiffness, linearized at this one."""
    residuals, jacobian = objective.jacobian(stiffness)
    matrix = jacobian.T @ jacobian / sigma**2
    return matrix, matrix @ stiffness - jacobian.T @ residuals / sigma**2


def decide(matrix: Floats, pull: Floats, share: float, rng: np.random.Generator) -> Booleans:
    """Which springs are more probably present than not, by Gibbs sampling of the presences alone, shape (s,).

    The stiffness is integrated out: the tableau of the sweep operator (Goodnight 1979) tells the mean and the error of
    each spring's stiffness, given which others are present, and changes with every spring that comes or goes.
    """
    count = len(pull)
    # What nothing tells stays at the middle, with a large error; the units are those in which all springs tell alike.
    weak = WEAK + ROUNDING * matrix.diagonal()
    matrix, pull = matrix + np.diag(weak), pull + weak * (SOFTEST + STIFFEST) / 2
    units = 1.0 / np.sqrt(matrix.diagonal())
    matrix, pull = matrix * np.outer(units, units), pull * units
    tableau = np.block([[matrix, pull[:, None]], [pull, np.zeros(1)]])
    present = np.zeros(count, dtype=bool)
    for spring in range(count):
        flip(tableau, present, spring)
    total = np.zeros(count)
    for number in range(SWEEPS):
        for spring in rng.permutation(count):
            if present[spring]:
                mean, error = tableau[spring, -1], np.sqrt(tableau[spring, spring])
            else:
                mean, error = tableau[spring, -1] / tableau[spring, spring], 1.0 / np.sqrt(tableau[spring, spring])
            chance = probability(units[spring] * mean, units[spring] * error, share)
            total[spring] += chance * (number >= WARM_UP)
            if (rng.random() < chance) != present[spring]:
                flip(tableau, present, spring)
    return total > 0.5 * (SWEEPS - WARM_UP)


def flip(tableau: Floats, present: Booleans, spring: int) -> None:
    """Takes a spring into the model, or out of it: a sweep, which is its own inverse."""
    pivot, row, column = tableau[spring, spring], tableau[spring].copy(), tableau[:, spring].copy()
    tableau -= np.outer(column, row / pivot)
    tableau[spring], tableau[:, spring], tableau[spring, spring] = row / pivot, -column / pivot, 1.0 / pivot
    present[spring] = not present[spring]


def probability(mean: float, error: float, share: float) -> float:
    """Of presence, for an estimate of the stiffness that is normal: 0 if absent, else anything from 2 to 8 alike."""
    low, high = (SOFTEST - mean) / error, (STIFFEST - mean) / error
    if low > 0:  # the tail that is not rounded away
        low, high = -high, -low
    within = log_ndtr(high) + np.log1p(-np.exp(log_ndtr(low) - log_ndtr(high)))
    at_zero = -0.5 * (mean / error) ** 2 - np.log(error * np.sqrt(2 * np.pi))
    odds = np.log(share / (1 - share)) + within - np.log(STIFFEST - SOFTEST) - at_zero
    return float(expit(odds))


def make_reference(scene: str, seed: int) -> Reference:
    """A random reference on the grid and with the loads of a scene, its springs thinned out."""
    rng = np.random.default_rng(seed)
    setup = so.load_scene(scene).build()
    cases = [case for case in setup.cases if case.role == "train"]
    share, count = rng.uniform(*KEPT[scene]), setup.lattice.spring_count
    free = {case.supports.tobytes(): case.free.ravel() for case in cases}
    matrices = [pulls(setup.lattice)[rows] for rows in free.values()]
    present = thin_out(matrices, rng.permutation(count), round(share * count))
    stiffness = np.where(present, rng.uniform(SOFTEST, STIFFEST, len(present)), 0.0)
    model = so.Model(setup.lattice)
    moderate = [moderated(model, stiffness, case) for case in cases]
    return Reference(model, moderate, stiffness, model.solve(stiffness, moderate, TOLERANCE).positions)


def moderated(model: so.Model, stiffness: Floats, case: so.LoadCase) -> so.LoadCase:
    """The load case with its forces halved until there is an equilibrium where no node moves far."""
    while True:
        solution = model.solve(stiffness, [case], TOLERANCE)
        furthest = np.linalg.norm(solution.displacements, axis=2).max()
        if solution.status[0].has_equilibrium and furthest <= FURTHEST:
            return case
        case = so.LoadCase(case.name, case.supports, case.forces / 2)


if __name__ == "__main__":
    main()
