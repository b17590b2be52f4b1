"""Every installed optimizer on one question: how long until free springs cost 0.68 of what one stiffness costs?

    ./run python benchmarks/strategies.py [--seeds 0 1 2] [--seconds 20] [--ratio 0.68] [--only NAME ...]

0.68 is unrestricted : homogeneous in Table 1 of Bianchi et al. (2004). The scene is `paper-fem-2d`; the least cost of
one stiffness is that of `paper-fem-2d-homogeneous`. A run ends at this target, when its optimizer is content, or after
`--seconds` on the wall. Prints Markdown, medians over the seeds: processor seconds and evaluations to the target
(gradients and Jacobians count 2), and what was reached in the end, over the homogeneous cost.
"""

import argparse
import statistics
import warnings

import springopt as so
from springopt.registry import installed

SCENE, HOMOGENEOUS = "paper-fem-2d", "paper-fem-2d-homogeneous"


def homogeneous_cost() -> float:
    """The least cost of one stiffness: one unknown, which any good local method finds."""
    return so.solve(HOMOGENEOUS, "gauss-newton").objective


def raced(name: str, target: float, seeds: list[int], seconds: float) -> list[so.Run]:
    """The runs, one a seed. Each optimizer has its first run for nothing, to compile and to be imported."""
    so.solve(SCENE, name, evaluations=20)
    return [so.solve(SCENE, name, seed=seed, seconds=seconds, target=target) for seed in seeds]


def row(name: str, runs: list[so.Run], homogeneous: float) -> tuple[float, str]:
    """What a table is sorted by, and the row: those that miss the target follow those that reach it."""
    reached = [run.why_stopped == "target" for run in runs]
    seconds = statistics.median(run.processor_seconds for run in runs)
    ratio = statistics.median(run.objective for run in runs) / homogeneous
    share = f"{sum(reached)} of {len(runs)}"
    if 2 * sum(reached) > len(runs):
        evaluations = statistics.median(run.evaluations for run in runs)
        return seconds, f"| {name} | {seconds:.3f} | {evaluations:,.0f} | {share} | {ratio:.3f} |"
    return 1e9 * ratio, f"| {name} | not reached ({seconds:.3g} s) | | {share} | {ratio:.3g} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--seconds", type=float, default=20.0, help="on the wall, of one run")
    parser.add_argument("--ratio", type=float, default=0.68, help="of the cost to the homogeneous one")
    parser.add_argument("--only", nargs="+", default=installed(), metavar="NAME", help="of the optimizers")
    arguments = parser.parse_args()
    homogeneous = homogeneous_cost()
    target = arguments.ratio * homogeneous
    rows, refused = [], []
    for name in arguments.only:
        try:
            runs = raced(name, target, arguments.seeds, arguments.seconds)
        except so.UserError as error:
            refused.append(f"{name}: {error}")
        else:
            rows.append(row(name, runs, homogeneous))
    print(f"{SCENE}, seeds {arguments.seeds}: target {target:.4f}, {arguments.ratio:g} of {homogeneous:.4f}\n")
    print("| optimizer | processor seconds | evaluations | reached | cost over homogeneous |\n|---|---|---|---|---|")
    print(*(text for _, text in sorted(rows)), sep="\n")
    print(*refused, sep="\n")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
