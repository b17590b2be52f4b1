"""Figures of a comparison: what is drawn where."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from springopt.report.comparison.critical_difference import draw_critical_difference, groups
from springopt.report.comparison.figures import comparison_figures
from springopt.report.comparison.method_lines import LINE_HEIGHT, looks
from springopt.report.comparison.running_time_map import draw_running_times
from springopt.report.figures import save

METHODS = [f"optimizer-{number}" for number in range(18)]
UNITS = ("evaluations", "solves", "processor_seconds")


def on_scene(method: str, slow: int) -> dict[str, Any]:
    time = float("inf") if slow > 9 else 10.0 * (1 + slow)
    course = [1.0, 10.0 ** -(9 - slow)]
    return {
        "method": method,
        "targets": {2: {"running_times": {unit: {"value": time} for unit in UNITS}}},
        "course": {
            "evaluations": [1.0, 100.0],
            "median": course,
            "lower_quartile": course,
            "upper_quartile": course,
        },
    }


@pytest.fixture(scope="module")
def comparison() -> dict[str, Any]:
    """18 methods, of which the last serves one of two scenes, and a nineteenth none."""
    curve = {
        "places": [1.0, 10.0, 100.0],
        "shares": {name: [0.0, 0.02 * i, 0.05 * i] for i, name in enumerate(METHODS)},
    }
    return {
        "target": 2,
        "methods": [{"method": method, "scenes": 2 - (method == METHODS[-1])} for method in METHODS],
        "scenes": [
            {"scene": "one", "methods": [on_scene(method, slow) for slow, method in enumerate(METHODS)]},
            {"scene": "two", "methods": [on_scene(method, slow) for slow, method in enumerate(METHODS[:-1])]},
        ],
        "refusals": [
            {"scene": "two", "method": METHODS[-1], "word": "real"},
            *({"scene": scene, "method": "stubborn", "word": "binary"} for scene in ("one", "two")),
        ],
        "ranking": {
            "scenes": ["one", "two"],
            "mean_ranks": {method: 1.0 + i for i, method in enumerate(METHODS)},
            "critical_difference": 4.5,
            "friedman": {"p": 0.01, "kendall_w": 0.5},
        },
        "solved_over_budget": [{"unit": unit, **curve} for unit in UNITS],
        "performance_profiles": [{"unit": unit, **curve} for unit in UNITS],
    }


@pytest.fixture(scope="module")
def figures(comparison: Mapping[str, Any]) -> dict[str, Figure]:
    return dict(comparison_figures(comparison))


def texts(figure: Figure) -> list[str]:
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def test_there_is_one_for_each_scene_and_four_over_all(figures: Mapping[str, Figure]) -> None:
    assert list(figures) == [
        "solved-over-budget",
        "performance-profiles",
        "running-times",
        "critical-difference",
        "convergence-one",
        "convergence-two",
    ]


@pytest.mark.parametrize("name", ["solved-over-budget", "performance-profiles"])
def test_every_line_has_its_name_apart_from_the_others_and_says_what_it_does_not_serve(
    figures: Mapping[str, Figure], name: str
) -> None:
    for axes in figures[name].axes:
        named = [text for text in axes.texts if text.get_text().startswith("optimizer-")]
        assert len(named) == 18
        assert f"{METHODS[-1]} (1 of 2 scenes)" in {text.get_text() for text in named}
        levels = np.sort([text.get_position()[1] for text in named])
        assert np.diff(levels).min() >= LINE_HEIGHT / (axes.bbox.height * 72 / axes.figure.dpi) - 1e-9
        assert levels.min() >= 0


def test_eighteen_lines_look_different() -> None:
    assert len({str(sorted(look.items())) for look in looks(METHODS).values()}) == 18


def test_a_running_time_s_cell_has_the_number_or_the_reason(figures: Mapping[str, Figure]) -> None:
    panel = figures["running-times"].axes[0]
    cells = {text.get_position(): text.get_text() for text in panel.texts}
    assert cells[0, 0] == "10"
    assert cells[0, 4] == "50"
    assert cells[0, 12] == "never"
    assert cells[1, 17] == "real"
    assert cells[1, 18] == "binary"
    assert len(cells) == 2 * 19


def test_a_scene_that_nobody_solved_has_no_times(comparison: Mapping[str, Any]) -> None:
    scene = {"scene": "hard", "methods": [on_scene("a", 12), on_scene("b", 12)]}
    figure = draw_running_times(
        {**comparison, "scenes": [scene], "refusals": [], "methods": [{"method": "a"}, {"method": "b"}]}
    )
    assert {text.get_text() for text in figure.axes[0].texts} == {"never"}


def test_bars_join_what_lies_within_the_critical_difference() -> None:
    # Demsar (2006), section 3.2.2 and Figure 1: one group at 5 %, and two at 10 %, to which C4.5+cf both belongs.
    ranks = [1.964, 2.0, 2.893, 3.143]
    assert groups(ranks, 1.25) == [(1.964, 3.143)]
    assert groups(ranks, 1.118) == [(1.964, 2.893), (2.893, 3.143)]
    assert groups([1.0, 3.0], 1.0) == []


def test_every_method_stands_at_the_diagram_of_ranks(figures: Mapping[str, Figure]) -> None:
    shown = " ".join(texts(figures["critical-difference"]))
    assert all(method in shown for method in METHODS)
    assert "critical difference 4.50" in shown


def test_two_equal_methods_make_a_diagram_as_well() -> None:
    ranking = {
        "scenes": ["one", "two"],
        "mean_ranks": {"a": 1.5, "b": 1.5},
        "critical_difference": 2.0,
        "friedman": None,
    }
    assert "Mean ranks over 2 scenes" in texts(draw_critical_difference(ranking))


def test_each_method_on_a_scene_has_its_panel(figures: Mapping[str, Figure]) -> None:
    titles = [axes.get_title(loc="left") for axes in figures["convergence-one"].axes]
    assert titles == METHODS
    assert len([axes for axes in figures["convergence-two"].axes if axes.get_title(loc="left")]) == 17


def test_figures_are_written(figures: Mapping[str, Figure], tmp_path: Path) -> None:
    for name in ("solved-over-budget", "critical-difference"):
        save(figures[name], tmp_path / f"{name}.png")
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
