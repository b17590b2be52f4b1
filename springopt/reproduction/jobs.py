"""The jobs of an experiment: the paper's algorithm in one reading, and the baselines beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from springopt.benchmark import Job
from springopt.reproduction.extent import Extent
from springopt.scene import Scene

PAPER_GA = "paper-ga"
#: The strong ones, and the weakest there is.
BASELINES = ("gauss-newton", "l-bfgs-b", "balance", "analytic", "pymoo-cma-es", "random-search")
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
    return make_jobs(scene, PAPER_GA, extent, extent.seeds, label=label, options=options, target=target)


def baseline_jobs(
    scene: Scene, extent: Extent, baselines: Sequence[str] = BASELINES, *, target: float | None = None
) -> list[Job]:
    """The baselines on the same scene, with the same budget."""
    seeds = {name: extent.baseline_seeds[: 1 if name in FORMULAS else None] for name in baselines}
    return [job for name in baselines for job in make_jobs(scene, name, extent, seeds[name], target=target)]


def make_jobs(
    scene: Scene,
    optimizer: str,
    extent: Extent,
    seeds: Sequence[int],
    *,
    label: str = "",
    options: Mapping[str, Any] | None = None,
    target: float | None = None,
    start: str | None = None,
) -> list[Job]:
    """One optimizer on a scene, with its own budget as far as the extent goes."""
    limits = {"evaluations": extent.evaluations(scene)} | ({} if target is None else {"target": target})
    one = Job(
        scene=scene.to_json(),
        scene_name=scene.name,
        optimizer=optimizer,
        seed=0,
        limits=limits,
        options=options or {},
        label=label,
        start=start,
    )
    return [replace(one, seed=seed) for seed in seeds]
