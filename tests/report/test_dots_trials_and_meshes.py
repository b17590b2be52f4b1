"""Pictures of many runs: what is drawn where."""

import numpy as np
import pytest

from springopt.encoding.spring_classes import inner_boundary_diagonal
from springopt.lattice import SpringLattice
from springopt.report.dots import Dots, draw_dots
from springopt.report.meshes import Mesh, depths, draw_meshes
from springopt.report.trials import Trials, draw_trials

LATTICE = SpringLattice.grid((4, 4))


def test_dots_have_a_row_for_each_way_and_a_line_at_the_published_number() -> None:
    figure = draw_dots([Dots("mean", {"one": [4.0, 5.0], "two": [6.0]}, 5.01), Dots("spread", {"one": [], "two": [1]})])
    left, right = figure.axes
    assert [label.get_text() for label in left.get_yticklabels()] == ["one", "two"]
    assert left.lines[0].get_xdata().tolist() == [4.0, 5.0]
    assert left.lines[2].get_xdata() == [5.01, 5.01]
    assert [text.get_text() for text in left.texts] == ["paper 5.01"]
    assert not right.texts


@pytest.mark.parametrize("unseen", [0, 2])
def test_trials_have_a_histogram_each_and_the_spread_beside_the_standard_errors(unseen: int) -> None:
    count = LATTICE.spring_count
    errors = np.linspace(0.1, 1.0, count)
    errors[:unseen] = np.inf
    stiffness = {name: np.full(count, level) for name, level in (("a", 3.2), ("b", 7.7))}
    rows = [Trials("supports", stiffness, np.full(count, 0.5), errors)]
    figure = draw_trials(rows, inner_boundary_diagonal(LATTICE), [(3.0, 4.0)])
    assert [axes.get_title() for axes in figure.axes] == ["a", "b", "Spring by spring"]
    last = figure.axes[-1]
    assert sum(len(line.get_xdata()) for line in last.lines) == count
    assert [text.get_text() for text in last.texts] == ["unseen"] * bool(unseen)


def test_meshes_show_shares_of_the_springs_and_stiffness_by_depth() -> None:
    stiffness = np.where(LATTICE.straight, 7.5, 3.75)
    figure = draw_meshes([Mesh("4 x 4", LATTICE, stiffness)], {"4": (0.3, 0.7)}, ("two classes", "boundary"))
    histogram, legends, by_depth, shares = figure.axes
    assert sum(bar.get_height() for bar in histogram.patches) == pytest.approx(1.0)
    assert not legends.axison
    assert by_depth.get_xlabel() == "distance from the boundary"
    assert [bar.get_height() for bar in shares.patches] == [0.3, 0.7]


def test_depth_is_that_of_a_spring_s_middle() -> None:
    classes = inner_boundary_diagonal(LATTICE)
    depth = depths(LATTICE)
    assert set(depth[classes["boundary straight"]]) == {0.0}
    assert set(depth[classes["diagonal"]]) == {0.5, 1.5}
