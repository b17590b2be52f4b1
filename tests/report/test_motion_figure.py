"""The page of a motion: what is drawn where."""

from collections.abc import Sequence

import numpy as np
import pytest

from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.report.deformation import deformations, earlier
from springopt.report.figures import Learned, draw

FLAT, BLOCK = SpringLattice.grid((3, 3)), SpringLattice.grid((3, 3, 3))
TIMES = np.array([0.5, 1.0, 1.5, 2.0])


def moving(lattice: SpringLattice, roles: Sequence[str], times: np.ndarray = TIMES) -> Learned:
    """The right side goes to 0.2 and beyond, its highest node further; the model lags by a tenth of that."""
    pull = np.zeros_like(lattice.nodes)
    pull[side(lattice, "right"), 0] = 0.2
    pull[-1, 0] = 0.3
    cases = [LoadCase(f"case {i}", side(lattice, "left"), pull, role=role, times=times) for i, role in enumerate(roles)]
    errors = [{"relative_distance": 0.02, "max_distance": 0.1}] * len(cases)
    motion = times[:, None, None] * pull
    reference, model = lattice.nodes + motion, lattice.nodes + 0.9 * motion
    shown = deformations(cases, np.stack([reference] * len(cases)), np.stack([model] * len(cases)), errors)
    return Learned("A motion", lattice, np.ones(lattice.spring_count), shown)


@pytest.mark.parametrize("lattice", [FLAT, BLOCK], ids=["2D", "3D"])
def test_below_each_load_case_the_node_that_moves_furthest_is_drawn_over_time(lattice: SpringLattice) -> None:
    figure = draw(moving(lattice, ["train", "train", "test"]))
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    node = lattice.node_count - 1
    assert titles.count(f"x displacement, node {node} [length]") == 3
    course = next(axes for axes in figure.axes if axes.get_title().startswith("x displacement"))
    _, reference, model = course.lines
    np.testing.assert_allclose(reference.get_ydata(), [0.0, *(0.3 * TIMES)])
    np.testing.assert_allclose(model.get_ydata(), [0.0, *(0.27 * TIMES)])
    assert model.get_xdata().tolist() == [0.0, *TIMES]  # type: ignore[union-attr]


def test_the_body_is_drawn_at_its_last_time_and_pale_at_earlier_ones() -> None:
    page = moving(FLAT, ["train"])
    np.testing.assert_allclose(page.deformations[0].reference[-1, 0], FLAT.nodes[-1, 0] + 0.6)
    np.testing.assert_array_equal(earlier(TIMES[:, None, None])[:, 0, 0], [0.5, 1.0])
    assert not len(earlier(TIMES[:1, None, None]))
    labels = [text.get_text() for text in draw(page).legends[0].get_texts()]
    assert "earlier" in labels


def test_the_distance_of_each_load_case_is_drawn_over_time() -> None:
    figure = draw(moving(FLAT, ["train", "train", "test"]))
    assert [axes.get_title(loc="left") for axes in figure.axes[-2:]] == ["Distance over time", "Stiffness"]
    distances = figure.axes[-2]
    assert [text.get_text() for text in distances.get_legend().get_texts()] == ["training", "test"]  # type: ignore[union-attr]
    moved = 0.1 * (0.2 + 0.2 + 0.3) / 9
    for line in distances.lines:
        np.testing.assert_allclose(line.get_ydata(), [0.0, *(moved * TIMES)])


def test_one_time_alone_can_be_drawn_and_a_body_that_does_not_move() -> None:
    page = moving(FLAT, ["train"], TIMES[:1])
    draw(page).canvas.draw()
    still = np.broadcast_to(FLAT.nodes, (1, 1, *FLAT.nodes.shape))
    errors = [{"relative_distance": 0.0, "max_distance": 0.0}]
    shown = deformations([page.deformations[0].case], still, still, errors)
    draw(Learned("Still", FLAT, page.stiffness, shown)).canvas.draw()
