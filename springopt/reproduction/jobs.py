"""The jobs of an experiment: the paper's algorithm in one reading, and the baselines beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from springopt.benchmark import Job
from springopt.reproduction.extent import Extent
from springopt.scene import Scene

PAPER_GA = "paper-ga"
#: The strong ones, and the weakest there is; each where it serves the encoding.
BASELINES = ("gauss-newton", "l-bfgs-b", "balance", "analytic", "pymoo-cma-es", "pymoo-ga", "random-search")
#: They draw nothing at random.
FORMULAS = ("balance", "analytic")


def ga_jobs(
    scene: Scene,
    extent: Extent,
    *,
    label: str = PAPER_GA,
    options: Mapping[str, Any] | None = None,
    target: float | None = None,
) -> list[Job]:
    """The genetic algorithm on a scene, once a seed."""
    return _jobs(scene, PAPER_GA, extent, extent.seeds, label, options, target)


def baseline_jobs(
    scene: Scene, extent: Extent, baselines: Sequence[str] = BASELINES, *, target: float | None = None
) -> list[Job]:
    """The baselines on the same scene, with the same budget."""
    seeds = {name: extent.baseline_seeds[: 1 if name in FORMULAS else None] for name in baselines}
    return [job for name in baselines for job in _jobs(scene, name, extent, seeds[name], name, {}, target)]


def _jobs(
    scene: Scene,
    optimizer: str,
    extent: Extent,
    seeds: Sequence[int],
    label: str,
    options: Mapping[str, Any] | None,
    target: float | None,
) -> list[Job]:
    limits = {"evaluations": extent.evaluations(scene)} | ({} if target is None else {"target": target})
    text = scene.to_json()
    return [
        Job(
            scene=text,
            scene_name=scene.name,
            optimizer=optimizer,
            seed=seed,
            limits=limits,
            options=options or {},
            label=label,
        )
        for seed in seeds
    ]
