"""What is said of a number of the paper beside ours."""

import pytest

from springopt.reproduction.paper import Published
from springopt.reproduction.spread import Spread
from springopt.reproduction.verdict import Comparison


def test_a_number_between_the_seeds_is_within_their_spread() -> None:
    comparison = Comparison("Mean", Published("5.01", "section 4.2"), [5.0, 5.1, 4.9], ".2f")
    assert comparison.agrees
    assert comparison.said() == (
        "Mean: 5.01 in the paper (section 4.2), 5.00 (4.90 to 5.10) here: **within the seeds' spread**."
    )


@pytest.mark.parametrize(("printed", "agrees"), [("0.08", True), ("0.0800", False), ("0.07", False)])
def test_a_number_counts_as_far_as_it_is_printed(printed: str, agrees: bool) -> None:
    assert Comparison("Error", Published(printed, "Figure 3"), [0.0752, 0.0761], ".2f").agrees == agrees


def test_a_count_is_not_rounded() -> None:
    assert not Comparison("Springs", Published("463", "section 3.2"), [463.3, 468.0], "g").agrees


def test_a_difference_names_its_size_and_what_other_readings_give() -> None:
    readings = {"parents drawn uniformly": [0.51, 0.80], "one side held": [0.72, 0.99]}
    said = Comparison("Spread", Published("0.65", "section 4.2"), [0.18, 0.3, 0.41], ".2f", readings).said()
    assert said.endswith(
        "0.30 (0.18 to 0.41) here: **differs by 0.24 (36.9%), more than the seeds' spread**; readings tried: parents "
        "drawn uniformly, 0.66 (0.51 to 0.80) (within); one side held, 0.85 (0.72 to 0.99) (differs)."
    )


def test_seeds_that_agree_are_one_number() -> None:
    assert Spread.of([468.0, 468.0]).said("g") == "468"


def test_the_gap_to_the_nearest_seed_has_a_sign() -> None:
    spread = Spread.of([1.0, 2.0])
    assert (spread.gap(0.5), spread.gap(1.5), spread.gap(2.25)) == (-0.5, 0.0, 0.25)
