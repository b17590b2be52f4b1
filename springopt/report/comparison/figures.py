"""All figures of a comparison of optimizers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from matplotlib.figure import Figure

from springopt.report.comparison.convergence_bands import draw_bands
from springopt.report.comparison.critical_difference import draw_critical_difference
from springopt.report.comparison.running_time_map import draw_running_times
from springopt.report.comparison.solved_shares import draw_over_budget, draw_profiles


def comparison_figures(comparison: Mapping[str, Any]) -> Iterator[tuple[str, Figure]]:
    """Each figure with its name; the comparison as a document, as in `tables`."""
    methods = [each["method"] for each in comparison["methods"]]
    served = {each["method"]: each["scenes"] for each in comparison["methods"]}
    scenes = len(comparison["scenes"])
    yield "solved-over-budget", draw_over_budget(comparison["solved_over_budget"], methods, served, scenes)
    yield "performance-profiles", draw_profiles(comparison["performance_profiles"], methods, served, scenes)
    yield "running-times", draw_running_times(comparison)
    if comparison["ranking"]:
        yield "critical-difference", draw_critical_difference(comparison["ranking"])
    for scene in comparison["scenes"]:
        yield f"convergence-{scene['scene']}", draw_bands(scene)
