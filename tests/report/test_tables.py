"""Tables for people: the numbers in them."""

from springopt.forward.status import Status
from springopt.report.tables import errors_table


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
