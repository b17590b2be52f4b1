"""The page of a run: what is drawn where."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex

from springopt.front import Front
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.report import style
from springopt.report.body import project, visible
from springopt.report.deformation import deformations
from springopt.report.figures import Learned, draw, save
from springopt.run import Improvement

FLAT, BLOCK = SpringLattice.grid((3, 3)), SpringLattice.grid((3, 3, 3))


def learned(lattice: SpringLattice, roles: Sequence[str], values: Sequence[tuple[int, float]]) -> Learned:
    """Nodes on the right, pulled by 0.2; the model lags by a tenth of that."""
    pull = np.zeros_like(lattice.nodes)
    pull[side(lattice, "right"), 0] = 0.2
    supports = side(lattice, "left")
    cases = [LoadCase(f"case {i}", supports, pull, role=role) for i, role in enumerate(roles)]
    errors = [{"relative_distance": 0.02, "max_distance": 0.1}] * len(cases)
    reference = np.stack([lattice.nodes + pull] * len(cases))
    stiffness = np.linspace(0.0, 8.0, lattice.spring_count)
    shown = deformations(cases, reference, reference - 0.1 * pull, errors)
    history = [Improvement(evaluations, evaluations, 0.0, 0.0, value) for evaluations, value in values]
    return Learned("A run", lattice, stiffness, shown, history, 100)


@pytest.mark.parametrize("lattice", [FLAT, BLOCK], ids=["2D", "3D"])
def test_a_page_has_a_panel_for_each_load_case_then_convergence_and_stiffness(lattice: SpringLattice) -> None:
    figure = draw(learned(lattice, ["train"] * 4 + ["test"] * 2, [(1, 0.5), (40, 0.1)]))
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert titles == [f"case {i}\nerror 0.020, largest 0.10" for i in range(6)]
    assert [axes.get_title(loc="left") for axes in figure.axes[-2:]] == ["Convergence", "Stiffness"]
    assert [frame.get_supylabel() for frame in figure.subfigs[:2]] == ["Training", "Test"]


def test_all_panels_share_their_limits_and_hold_every_force_arrow() -> None:
    panels = [axes for axes in draw(learned(FLAT, ["train", "test"], [(1, 0.5)])).axes if axes.get_title()]
    assert {axes.get_xlim() for axes in panels} == {panels[0].get_xlim()}
    assert panels[0].get_xlim()[1] > 2.2 + 2 / 8
    assert all(axes.get_aspect() == 1.0 for axes in panels)


def test_a_page_without_history_shows_no_convergence() -> None:
    figure = draw(learned(FLAT, ["train"], []))
    assert [axes.get_title(loc="left") for axes in figure.axes][-1] == "Stiffness"
    assert not any(axes.get_title(loc="left") == "Convergence" for axes in figure.axes)


def test_a_front_has_a_panel_between_convergence_and_stiffness() -> None:
    front = Front(np.array([4.0, 1.0, 0.0]), np.array([3, 7, 12]), np.zeros((3, 1)))
    figure = draw(replace(learned(FLAT, ["train"], [(1, 0.5)]), front=front))
    assert [axes.get_title(loc="left") for axes in figure.axes[-3:]] == ["Convergence", "Front", "Stiffness"]
    line, points = figure.axes[-2].lines
    assert points.get_xdata().tolist() == [3, 7, 12]  # type: ignore[union-attr]
    assert line.get_ydata().tolist() == [4.0, 1.0, 0.1]  # type: ignore[union-attr]
    assert "of 20" in figure.axes[-2].get_xlabel()


def drawn_model(page: Learned) -> np.ndarray:
    """The lines of the model in the first panel, shape (drawn springs, 2, 2)."""
    collections = [each for each in draw(page).axes[0].collections if isinstance(each, LineCollection)]
    (model,) = [each for each in collections if to_hex(each.get_color()[0]) == style.MODEL.lower()]
    return np.array(model.get_segments())


def test_the_figure_draws_the_present_springs_where_the_model_has_them() -> None:
    page = learned(FLAT, ["train"], [])
    (deformation,) = page.deformations
    np.testing.assert_array_equal(drawn_model(page), deformation.model[FLAT.springs[page.stiffness > 0]])


def test_a_block_shows_the_present_springs_along_its_visible_edges() -> None:
    page = learned(BLOCK, ["train"], [])
    page.stiffness[:100] = 0.0
    edges = {frozenset(line) for line in visible(BLOCK).lines.tolist()}
    shown = [pair for pair, k in zip(BLOCK.springs.tolist(), page.stiffness, strict=True) if k and set(pair) in edges]
    assert 0 < len(shown) < len(edges)
    np.testing.assert_array_equal(drawn_model(page), project(page.deformations[0].model)[shown])


def test_the_legend_explains_every_mark_on_the_page() -> None:
    figure = draw(learned(FLAT, ["train"], []))
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["reference", "mass-spring model", "rest shape", "held", "moved", "force"]
    figure.canvas.draw()
    assert figure.legends[0].get_texts()[-1].get_window_extent().x1 < figure.bbox.width


@pytest.mark.parametrize("history", [[(1, 0.5), (9, 0.0)], [(3, 0.0)]])
def test_convergence_to_zero_fits_a_log_scale(history: list[tuple[int, float]]) -> None:
    axes = draw(learned(FLAT, ["train"], history)).axes[-2]
    assert axes.get_yscale() == "log"
    assert min(axes.lines[0].get_ydata()) > 0  # type: ignore[type-var, arg-type]
    assert axes.lines[0].get_xdata()[-1] == 100  # type: ignore[index]


def test_the_histogram_counts_present_springs_by_class() -> None:
    page = learned(FLAT, ["train"], [])
    axes = draw(page).axes[-1]
    assert sum(bar.get_height() for bar in axes.patches) == np.count_nonzero(page.stiffness)
    labels = [text.get_text() for text in axes.get_legend().get_texts()]  # type: ignore[union-attr]
    assert [label.split(":")[0] for label in labels] == ["inner straight", "boundary straight", "diagonal"]


def test_a_page_of_no_springs_can_be_drawn() -> None:
    page = learned(FLAT, ["train"], [(1, 3.0)])
    draw(Learned("none", FLAT, 0 * page.stiffness, page.deformations, page.history, 1))


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_a_page_is_saved_as_its_ending_says(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"page.{ending}"
    save(draw(learned(FLAT, ["train"], [(1, 0.5)])), path)
    assert path.stat().st_size > 5000
