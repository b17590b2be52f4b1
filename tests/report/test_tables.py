"""Tables for people: the numbers in them."""

import numpy as np

from springopt.forward.status import Status
from springopt.front import Front
from springopt.report.tables import LONGEST_FRONT, errors_table, front_table


def error(name: str, role: str, distance: float | None) -> dict[str, object]:
    """Errors of one load case, in proportion to its distance."""
    sizes = {"distance": 1, "relative_distance": 2, "least_squares": 10, "max_distance": 3}
    scaled = {measure: None if distance is None else size * distance for measure, size in sizes.items()}
    return {"name": name, "role": role, "status": Status.CONVERGED, **scaled}


def cells(*errors: dict[str, object]) -> list[list[str]]:
    """The rows of the table of errors, without the status."""
    return [list(row) for row in zip(*(column.cells for column in errors_table(errors).columns[:-1]), strict=True)]


def test_the_errors_of_a_role_are_summed_and_the_largest_is_its_largest() -> None:
    rows = cells(error("a", "train", 0.5), error("b", "test", 9.0), error("c", "train", 0.25))
    assert rows == [
        ["a", "train", "0.5", "1", "5", "1.5"],
        ["c", "train", "0.25", "0.5", "2.5", "0.75"],
        ["sum", "train", "0.75", "1.5", "7.5", "1.5"],
        ["b", "test", "9", "18", "90", "27"],
        ["sum", "test", "9", "18", "90", "27"],
    ]


def test_a_load_case_without_an_equilibrium_leaves_no_sum() -> None:
    assert cells(error("a", "train", 0.5), error("b", "train", None))[-1] == ["sum", "train", "-", "-", "-", "1.5"]


def front(length: int) -> Front:
    """A point for each number of springs, the values from `length` down."""
    return Front(np.arange(length, 0.0, -1.0), np.arange(length), np.zeros((length, 1)))


def test_a_front_tells_springs_their_share_and_the_objective() -> None:
    rows = [list(row) for row in zip(*(column.cells for column in front_table(front(3), 8).columns), strict=True)]
    assert rows == [["0", "0.0%", "3"], ["1", "12.5%", "2"], ["2", "25.0%", "1"]]


def test_of_a_long_front_every_so_many_points_are_shown_and_both_ends() -> None:
    table = front_table(front(100), 100)
    springs = list(table.columns[0].cells)
    assert (len(springs), springs[0], springs[-1]) == (LONGEST_FRONT, "0", "99")
    assert table.title == "Front, 24 of 100 points"
    assert front_table(front(LONGEST_FRONT), 100).title == "Front"
