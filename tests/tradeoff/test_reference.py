"""The axis of the reference's elements, on scenes whose answers are known. The clock stands still where it plans."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from springopt.errors import UserError
from springopt.reference.fem import FemReference
from springopt.scene import Scene, load_scene
from springopt.tradeoff import elements
from springopt.tradeoff.axes import reference
from springopt.tradeoff.axes.reference import AXIS
from springopt.tradeoff.point import Findings, Point, Request

EXAMPLES = Path(__file__).parents[2] / "examples"
CLAMPED = """
title = "A clamped sheet that sags"
effects = [{ kind = "gravity", acceleration = [3.0, -10.0], density = 1.0 }]
lattice = { grid = [5, 5] }
reference = { kind = "fem", young = 100.0, poisson = 0.3 }
encoding = { kind = "real", upper = 10.0 }
[load_cases]
train = [{ name = "sagging", hold = ["left", "right", "bottom", "top"] }]
"""
BLOCK = """
title = "A small block, pulled"
lattice = { grid = [2, 2, 2] }
reference = { kind = "fem", young = 100.0, poisson = 0.3 }
encoding = { kind = "real", upper = 10.0 }
[load_cases]
train = [{ name = "pulled", hold = "left", push = { on = "right", force = [1.0, 0.0, 0.5] } }]
"""


@pytest.fixture(autouse=True)
def _plans_do_not_depend_on_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (elements, reference):
        monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: 0.0))
    monkeypatch.setattr(elements, "MOST_UNKNOWNS", {2: 3000, 3: 700})


def scene(folder: Path, text: str, **tables: object) -> Scene:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    found = load_scene(path)
    return found.model_copy(
        update={name: getattr(found, name).model_copy(update=changes) for name, changes in tables.items()}  # type: ignore[call-overload]
    )


def measured(stated: Scene, **request: object) -> Findings:
    assert AXIS.missing(stated) is None
    return AXIS.measure(stated.build(), replace(Request(seconds=0.01), **request))  # type: ignore[arg-type]


def of_series(findings: Findings, series: str) -> list[Point]:
    return [point for point in findings.points if point.series == series]


def errors_of(findings: Findings, series: str) -> list[float]:
    return [float(np.median(point.errors)) for point in of_series(findings, series)]


def orders(findings: Findings, series: str) -> list[float]:
    """All but of the first mesh, which has none before it."""
    return [point.numbers["observed_order"] for point in of_series(findings, series)[1:]]


def test_a_smooth_problem_shows_the_orders_of_theory(tmp_path: Path) -> None:
    findings = measured(scene(tmp_path, CLAMPED))
    assert [(point.series, point.name) for point in findings.points] == [
        ("first order", "4 x 4 cells"),
        ("second order", "4 x 4 cells"),
        ("first order", "8 x 8 cells"),
        ("second order", "8 x 8 cells"),
        ("first order", "16 x 16 cells"),
    ]
    assert orders(findings, "first order") == pytest.approx([2.0, 2.0], abs=0.25)
    assert orders(findings, "second order")[0] > 2.8
    assert {point.numbers["theoretical_order"] for point in findings.points} == {2.0, 3.0}
    assert all(point.is_good and point.error is not None for point in findings.points)
    assert any("theory has 3" in note for note in findings.notes)
    assert any("with 2,178 unknowns, in 1 of 1 load cases extrapolated" in note for note in findings.notes)


def test_the_scene_s_own_elements_are_marked_and_what_a_scene_says_gives_the_others(tmp_path: Path) -> None:
    stated = scene(tmp_path, CLAMPED)
    setup = stated.build()
    findings = measured(stated)
    assert [point.name for point in findings.points if point.is_stated] == ["4 x 4 cells"]
    first = next(iter(findings.points))
    assert first.is_stated
    assert first.states == {"reference.order": 1, "reference.refinements": 0}
    answers = elements.deformed(setup, elements.table_of(setup, 1, 0))
    np.testing.assert_allclose(answers, setup.reference_positions, rtol=0, atol=1e-12)
    for point in findings.points:
        changes = {name.removeprefix("reference."): value for name, value in point.states.items()}
        said = scene(tmp_path, CLAMPED, reference=changes)
        assert [other.is_stated for other in measured(said).points].count(True) == 1


def test_a_scene_with_finer_elements_is_another_scene_and_one_without_is_not(tmp_path: Path) -> None:
    digest = scene(tmp_path, CLAMPED).digest()
    said = CLAMPED.replace("poisson = 0.3", "poisson = 0.3, order = 1, refinements = 0")
    assert scene(tmp_path, said).digest() == digest
    assert scene(tmp_path, said.replace("order = 1", "order = 2")).digest() != digest


@pytest.mark.parametrize("cell", ["triangle", "quad"])
def test_finer_elements_are_nearer_in_2d(cell: str, tmp_path: Path) -> None:
    findings = measured(scene(tmp_path, CLAMPED.replace("[5, 5]", f"[4, 5], cell = {cell!r}")))
    for series in ("first order", "second order"):
        errors = errors_of(findings, series)
        assert len(errors) >= 2
        assert errors == sorted(errors, reverse=True)


@pytest.mark.parametrize(("cell", "name"), [("hexahedron", "1 x 1 x 1 cells"), ("tetra", "6 cells")])
def test_finer_elements_are_nearer_in_3d(cell: str, name: str, tmp_path: Path) -> None:
    findings = measured(scene(tmp_path, BLOCK.replace("[2, 2, 2]", f"[2, 2, 2], cell = {cell!r}")))
    errors = {(point.series, point.name): np.median(point.errors) for point in findings.points}
    assert errors["second order", name] < errors["first order", name]


def test_cells_of_a_mesh_file_are_divided_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(elements, "MOST_UNKNOWNS", {2: 20_000, 3: 0})
    mesh = Path(__file__).parents[1] / "data" / "fem" / "ellipse_hole.msh"
    text = CLAMPED.replace("grid = [5, 5]", f"mesh = {str(mesh)!r}").replace(
        '["left", "right", "bottom", "top"]', '["left", "bottom"]'
    )
    stated = scene(tmp_path, text)
    findings = measured(stated)
    cells = stated.lattice.build().cells
    assert cells is not None
    assert [point.name for point in of_series(findings, "first order")][:2] == [
        f"{len(cells):,} cells",
        f"{4 * len(cells):,} cells",
    ]
    errors = errors_of(findings, "first order")
    assert errors == sorted(errors, reverse=True)


def test_named_settings_are_measured_alone(tmp_path: Path) -> None:
    wanted = frozenset({("first order", "8 x 8 cells")})
    findings = measured(scene(tmp_path, CLAMPED), only=wanted)
    assert [(point.series, point.name) for point in findings.points] == list(wanted)


def test_what_verifies_a_setting_is_no_coarser_than_what_judged_it_before(tmp_path: Path) -> None:
    asked = {"seconds": -1.0, "only": frozenset({("first order", "8 x 8 cells")})}  # no time for more than is needed
    hurried = measured(scene(tmp_path, CLAMPED), **asked)
    again = measured(scene(tmp_path, CLAMPED), **asked, before={"judge_refinements": 2})
    assert again.numbers["judge_refinements"] == 2 > hurried.numbers["judge_refinements"]


def test_elements_that_find_no_equilibrium_are_kept_as_failures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    setup = scene(tmp_path, CLAMPED).build()
    deform = FemReference.deform

    def failing(body: FemReference, case: object) -> object:
        if body.refinements == 1 and body.order == 1:
            raise UserError("It snaps through.")
        return deform(body, case)  # type: ignore[arg-type]

    monkeypatch.setattr(FemReference, "deform", failing)
    points = {(point.series, point.name): point for point in AXIS.measure(setup, Request(seconds=0.01)).points}
    failed = points.pop(("first order", "8 x 8 cells"))
    assert (failed.failures, failed.error, failed.why) == (1, None, "It snaps through.")
    assert all(point.is_good for point in points.values())


def test_nearly_incompressible_scenes_are_judged_by_standard_elements_of_second_order(tmp_path: Path) -> None:
    said = 'poisson = 0.49, plane = "strain", formulation = "b-bar"'
    findings = measured(scene(tmp_path, CLAMPED.replace("poisson = 0.3", said)))
    assert {point.states.get("reference.formulation") for point in findings.points} == {None, "standard"}
    errors = errors_of(findings, "first order")
    assert errors == sorted(errors, reverse=True)


def test_motion_is_measured_as_far_as_modes_go(tmp_path: Path) -> None:
    text = (
        CLAMPED.replace("poisson = 0.3", "poisson = 0.3, density = 1.0, lumped = true")
        .replace("[5, 5]", "[4, 4]")
        .replace("effects = [{", 'effects = [{ kind = "inertia", mass = 1.0 }, {')
    )
    text += "times = [0.2, 0.4]\n[stepping]\nstep = 0.1\n"
    findings = measured(scene(tmp_path, text))
    assert max(point.numbers["unknowns"] for point in findings.points) <= elements.MOST_UNKNOWNS_IN_MOTION
    assert all(point.is_good for point in findings.points)
    assert findings.points[2].errors[0] < findings.points[0].errors[0]


def test_contact_is_measured_too(tmp_path: Path) -> None:
    assert AXIS.missing(load_scene(EXAMPLES / "pressed_block.toml")) is None
    floor = '{ kind = "plane", stiffness = 100.0, point = [0.0, 0.0], normal = [0.0, 1.0] }'
    text = CLAMPED.replace("effects = [", f"effects = [{floor}, ").replace(
        '["left", "right", "bottom", "top"]', '"left"'
    )
    for series in ("first order", "second order"):
        errors = errors_of(measured(scene(tmp_path, text.replace("[5, 5]", "[3, 3]"))), series)
        assert len(errors) >= 2
        assert errors == sorted(errors, reverse=True)


def test_points_that_hold_are_told_of(tmp_path: Path) -> None:
    said = CLAMPED.replace('["left", "right", "bottom", "top"]', '["left", 4]')
    assert any(note.startswith("Up to 1 held nodes") for note in measured(scene(tmp_path, said)).notes)


def test_a_lattice_that_nothing_finer_judges_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(elements, "MOST_UNKNOWNS", {2: 100, 3: 100})
    findings = measured(scene(tmp_path, CLAMPED))
    assert not findings.points
    assert "nothing judges" in findings.notes[0]


def test_a_mass_spring_reference_has_no_elements() -> None:
    assert (
        AXIS.missing(load_scene("paper-stiffness-2d")) == "its reference is a mass-spring model, which has no elements"
    )
