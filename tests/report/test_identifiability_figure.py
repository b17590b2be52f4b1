"""The picture of what is identified: which spring has which look."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex

from springopt.lattice import SpringLattice
from springopt.report.body import project
from springopt.report.figures import save
from springopt.report.identifiability import SHARED, UNSEEN, Identified, draw_identified

FLAT, BLOCK = SpringLattice.grid((3, 3)), SpringLattice.grid((3, 3, 3))


def identified(lattice: SpringLattice) -> Identified:
    """The first two springs are unseen, the next three shared, the errors of the others rise."""
    errors = np.linspace(0.1, 1.0, lattice.spring_count)
    errors[:5] = np.inf
    is_seen = np.ones(lattice.spring_count, dtype=bool)
    is_seen[:2] = False
    return Identified("A scene", lattice, errors, is_seen)


def lines_by_colour(page: Identified) -> dict[str, list[np.ndarray]]:
    collections = [each for each in draw_identified(page).axes[0].collections if isinstance(each, LineCollection)]
    return {to_hex(each.get_color()[0]): list(each.get_segments()) for each in collections[1:]}


@pytest.mark.parametrize("lattice", [FLAT, BLOCK], ids=["2D", "3D"])
def test_unseen_and_shared_springs_have_looks_of_their_own(lattice: SpringLattice) -> None:
    nodes, drawn = project(lattice.nodes), lines_by_colour(identified(lattice))
    np.testing.assert_array_equal(drawn[UNSEEN.lower()], nodes[lattice.springs[:2]])
    np.testing.assert_array_equal(drawn[SHARED.lower()], nodes[lattice.springs[2:5]])


def test_the_worst_spring_is_drawn_last_and_widest() -> None:
    (springs, *_) = draw_identified(identified(FLAT)).axes[0].collections
    assert isinstance(springs, LineCollection)
    np.testing.assert_array_equal(springs.get_segments()[-1], FLAT.nodes[FLAT.springs[-1]])
    assert np.argmax(springs.get_linewidth()) == FLAT.spring_count - 6


def test_the_legend_counts_what_is_not_identified() -> None:
    (legend,) = draw_identified(identified(FLAT)).legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "unseen: moves no node in any load case (2)",
        "shared: other springs can make up for it (3)",
    ]
    page = identified(FLAT)
    page.standard_errors[:] = 0.5
    assert draw_identified(page).legends == []


def test_a_lattice_of_which_nothing_is_identified_can_be_drawn(tmp_path: Path) -> None:
    page = identified(FLAT)
    page.standard_errors[:] = np.inf
    save(draw_identified(page), tmp_path / "page.png")
    assert (tmp_path / "page.png").stat().st_size > 5000
