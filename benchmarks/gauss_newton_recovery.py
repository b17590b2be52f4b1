"""Gauss-Newton on a mass-spring reference: is every spring found that a load case can see, and at what cost?

    ./run python benchmarks/gauss_newton_recovery.py [--scene paper-stiffness-2d] [--seeds 100]

One run a seed, from random starts, of `gauss-newton` and, for comparison, of SciPy's `least_squares` (trust region
reflective, Branch, Coleman and Li 1999), each with its own stopping rules. A spring is identifiable if it changes some
training load case, that is if its column of the Jacobian is not zero. Prints Markdown: evaluations (a Jacobian counts
2), the worst error of an identifiable spring [force/length], processor seconds.
"""

import argparse
import statistics
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

import springopt as so

#: A column of the Jacobian below this share of the longest is zero.
UNSEEN = 1e-12
ERROR = 1e-5


@dataclass(frozen=True)
class TrustRegionReflective(so.Optimizer):
    """SciPy's, with the tolerances that reach the same accuracy."""

    name = "scipy's least_squares (trf)"
    needs = ("real", "jacobian")

    def minimize(self, problem, rng):
        def jacobian(point):
            return problem.jacobian(point)[1]

        bounds, start = (problem.lower, problem.upper), problem.sample(rng, 1)[0]
        least_squares(problem.residuals, start, jacobian, bounds, method="trf", ftol=1e-10, xtol=1e-7, gtol=1e-12)


def true_stiffness(scene: so.Scene) -> np.ndarray:
    """The stiffness of the spring reference, shape (s,), zero where a spring is absent."""
    return scene.build().objective.reference.stiffness


def identifiable(scene: so.Scene, stiffness: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(scene.build().objective.jacobian(stiffness)[1], axis=0)
    return lengths > UNSEEN * lengths.max()


def row(scene: so.Scene, optimizer: so.Optimizer | str, truth: np.ndarray, seen: np.ndarray, seeds: int) -> str:
    runs = [so.solve(scene, optimizer, seed=seed) for seed in range(seeds)]
    errors = [float(np.abs(run.point - truth)[seen].max()) for run in runs]
    evaluations, seconds = [run.evaluations for run in runs], [run.processor_seconds for run in runs]
    return (
        f"| {runs[0].optimizer} | {sum(e <= ERROR for e in errors)} of {len(runs)} | {max(errors):.1e} "
        f"| {statistics.median(evaluations):g} | {max(evaluations)} "
        f"| {statistics.median(seconds):.3f} | {max(seconds):.3f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="paper-stiffness-2d", help="one with a spring reference")
    parser.add_argument("--seeds", type=int, default=100, help="how many")
    arguments = parser.parse_args()
    scene = so.load_scene(arguments.scene)
    truth = true_stiffness(scene)
    seen = identifiable(scene, truth)
    so.solve(scene, "gauss-newton")  # compiles
    print(f"{scene.name}, {seen.sum()} of {len(seen)} springs identifiable\n")
    print("| | seeds with all to 1e-5 | worst error | evaluations, median | worst | seconds, median | worst |")
    print("|---|---|---|---|---|---|---|")
    for optimizer in ("gauss-newton", TrustRegionReflective()):
        print(row(scene, optimizer, truth, seen, arguments.seeds))


if __name__ == "__main__":
    main()
