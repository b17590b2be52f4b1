"""Prints the table of this plugin's README: what the annealings reach on the paper's scenes.

./run python plugins/springopt-annealing/reached.py
"""

from __future__ import annotations

import statistics
from collections.abc import Sequence

import springopt as so

EVALUATIONS = 10_000
SEEDS = range(5)
RUNS = {
    "paper-stiffness-2d": ("annealing", "dual-annealing"),
    "paper-fem-2d": ("annealing", "dual-annealing"),
    "paper-topology-2d-isotropic": ("annealing",),
    "paper-topology-3d": ("annealing",),
}


def row(scene: str, optimizer: str) -> str:
    """The runs of all seeds in one line."""
    runs = [so.solve(scene, optimizer, seed=seed, evaluations=EVALUATIONS) for seed in SEEDS]
    cells = [
        f"`{scene}`",
        f"`{optimizer}`",
        told([run.objective for run in runs], "{:.3g}"),
        told([run.classes["all springs"]["present"] for run in runs], "{:.0f}"),
        told([run.classes["all springs"]["mean"] for run in runs], "{:.2f}"),
        told([run.classes["all springs"]["spread"] for run in runs], "{:.2f}"),
        told([run.processor_seconds for run in runs], "{:.0f}"),
    ]
    return f"| {' | '.join(cells)} |"


def told(numbers: Sequence[float], form: str) -> str:
    """The median, and the least and the greatest where these look different."""
    middle, least, greatest = (form.format(f(numbers)) for f in (statistics.median, min, max))
    return middle if least == greatest else f"{middle} ({least} to {greatest})"


if __name__ == "__main__":
    print("| scene | optimizer | objective | springs | mean | spread | processor seconds |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for scene, optimizers in RUNS.items():
        for optimizer in optimizers:
            print(row(scene, optimizer), flush=True)
