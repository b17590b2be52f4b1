"""From nothing to the page: the jobs of the experiments, one run each, then what they say."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from springopt.benchmark import Job, run_jobs
from springopt.benchmark.execute import Progress
from springopt.errors import PluginError, UserError, did_you_mean
from springopt.registry import installed
from springopt.reproduction.experiment import Experiment
from springopt.reproduction.experiments import EXPERIMENTS
from springopt.reproduction.extent import Extent
from springopt.reproduction.page import Page, names
from springopt.reproduction.publish import PICTURES, publish, require_new
from springopt.reproduction.runs import Runs

PLUGINS = "springopt-paper-ga, springopt-gradient, springopt-balance, springopt-analytic and springopt-pymoo"


def reproduce(
    out: Path,
    extent: Extent,
    *,
    only: Sequence[str] = (),
    runs: Path | None = None,
    workers: int = 1,
    progress: Progress | None = None,
) -> Path:
    """Runs the experiments and writes the page, which is returned; runs that are there are not made again.

    Args:
        out: the folder of the page `reproduction.md` and of the folder `reproduction` with its pictures.
        extent: how much is run.
        only: names of experiments; all of them if there are none.
        runs: the folder of the runs; `out/runs` by default.
        workers: processes.
        progress: see `run_jobs`.
    """
    experiments = _chosen(only)
    jobs = _jobs(experiments, extent)
    _require_installed(jobs)
    require_new(out)
    outcomes = run_jobs(jobs, (runs or out / "runs") / extent.name, workers=workers, progress=progress)
    found = Runs(outcomes)
    sections = {experiment: experiment.section(found, extent) for experiment in experiments}
    text = Page(extent, tuple(only), PICTURES).text(sections)
    return publish(out, text, [picture for section in sections.values() for picture in section.pictures])


def _chosen(only: Sequence[str]) -> list[Experiment]:
    known = {experiment.name: experiment for experiment in EXPERIMENTS}
    for name in only:
        if name not in known:
            hint = did_you_mean(name, known)
            raise UserError(f"there is no experiment {name!r}; there are {names(EXPERIMENTS)}.{hint}")
    return [experiment for name, experiment in known.items() if name in only or not only]


def _jobs(experiments: Iterable[Experiment], extent: Extent) -> list[Job]:
    """Of all experiments, each job once: some share runs. `run_jobs` refuses different ones with the same place."""
    jobs: list[Job] = []
    for experiment in experiments:
        jobs += [job for job in experiment.jobs(extent) if job not in jobs]
    return jobs


def _require_installed(jobs: Iterable[Job]) -> None:
    missing = sorted({job.optimizer for job in jobs} - set(installed()))
    if missing:
        said = ", ".join(missing)
        raise PluginError(f"this needs the optimizers {said}, which are not installed; install {PLUGINS}.")
