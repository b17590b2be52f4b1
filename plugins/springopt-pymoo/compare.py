"""What each algorithm reaches on two scenes of the paper, and the table of README.md.

    ./run python plugins/springopt-pymoo/compare.py > compared.md

It takes some ten minutes on one core; stderr says how far it is.
"""

import sys
from statistics import median

import springopt as so
from springopt.run import Run

SCENES = ("paper-stiffness-2d", "paper-fem-2d")
OPTIMIZERS = (
    "pymoo-ga",
    "pymoo-de",
    "pymoo-pso",
    "pymoo-cma-es",
    "pymoo-mixed-ga",
    "nsga2",
    "paper-ga",
    "random-search",
)
EVALUATIONS = 20_000
SEEDS = range(5)


def solved(scene: str, optimizer: str, seed: int) -> Run:
    run = so.solve(scene, optimizer, seed=seed, evaluations=EVALUATIONS)
    print(scene, optimizer, seed, f"{run.objective:.4g}", f"{run.processor_seconds:.1f} s", file=sys.stderr)
    return run


def row(scene: str, optimizer: str) -> str:
    """The median objective with the least and the greatest, and the median time."""
    runs = [solved(scene, optimizer, seed) for seed in SEEDS]
    values = [run.objective for run in runs]
    span = f"{median(values):.3g} ({min(values):.3g} to {max(values):.3g})"
    return f"| `{optimizer}` | {span} | {median(run.processor_seconds for run in runs):.1f} |"


def main() -> None:
    for scene in SCENES:
        print(f"\n`{scene}`:\n\n| optimizer | objective | processor seconds |\n| --- | --- | --- |")
        for optimizer in OPTIMIZERS:
            print(row(scene, optimizer), flush=True)


if __name__ == "__main__":
    main()
