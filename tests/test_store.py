import dataclasses
import json
import math

import h5py
import numpy as np
import pytest

from springopt.errors import RunFileError
from springopt.front import Front
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.recorder import NO_QUESTION, Answer, Outcome
from springopt.run import Improvement, Order, Run
from springopt.store import FORMAT, RunFile, read, read_answers, write

ANSWERS = [
    Answer("value", bytes(range(16)), 1e-8, 0, 0.1 + 0.2, 1.5, 1.25, 0.5),
    Answer("gradient", bytes(16), 1e-8, 0, -0.0, 2.5, 2.25, 1.5, np.array([1e-300, -0.0]).tobytes()),
    Answer("jacobian", bytes(16), 1e-8, 0, 3.0, 2.5, 2.25, 1.5, None, b"x" * 16),
    Answer("gradient", bytes(16), 1e-8, -1, None, 3.5, 3.25, 2.5, "§ no equilibrium".encode()),
    Answer.raced(bytes(16), Outcome(math.inf, 0, 3, 1e-3), (3.5, 3.25, 2.5)),
    Answer("budget_left", NO_QUESTION, 1e-8, 0, np.inf, 4.0, 4.0, 3.0),
]
LATTICE = SpringLattice.grid((2, 2))
CASES = [
    LoadCase("pull “x”\0", supports=np.array([1, 0, 1, 0], dtype=bool), forces=np.ones((4, 2))),
    LoadCase(
        "press", supports=np.ones(4, dtype=bool), forces=np.zeros((4, 2)), prescribed=np.ones((4, 2)), role="test"
    ),
]
RUN = Run(
    objective=0.1 + 0.2,
    evaluations=9,
    solves=18,
    seconds=1.5,
    processor_seconds=1.25,
    solving_seconds=0.75,
    stiffness=np.array([1.0, 0.0, 2.0, 3.0, 1e-300, 6.0]),
    point=np.array([1.0, -0.0]),
    classes={"all": {"mean": 2.0}},
    errors=[{"name": "pull “x”", "role": "train", "distance": 0.1}],
    optimizer="sampler",
    options={"batch": 3},
    scene="square",
    seed=5,
    run=None,
    complete=False,
    why_stopped="interrupted",
    history=[Improvement(1, 2, 0.1, 0.1, 5.0), Improvement(7, 14, 0.1 + 0.2, 0.25, 0.1 + 0.2)],
    notes={"rate": [(0, 1.0), (4, 0.1)]},
    front=Front(np.array([5.0, 0.1 + 0.2]), np.array([2, 5]), np.array([[3.0, 1e-300], [1.0, -0.0]])),
)
ORDER = Order(scene='{"é": 1}', optimizer="sampler", options={"batch": 3}, seed=5, budget={}, origin={"numpy": "2"})


def contents(**changes):
    positions = np.random.default_rng(0).uniform(size=(2, 2, 4, 2))
    parts = {"order": ORDER, "run": RUN, "lattice": LATTICE, "cases": CASES}
    return RunFile(**parts | changes, reference_positions=positions[0], positions=positions[1])


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.h5"


def same(one, other):
    """Whether two dataclasses hold the same, to the bit."""
    np.testing.assert_equal(dataclasses.asdict(other), dataclasses.asdict(one))


def test_everything_comes_back_to_the_bit(path):
    write(path, contents(), ANSWERS)
    back = read(path)
    assert back.order == ORDER
    assert back.run.run == str(path)
    same(dataclasses.replace(RUN, run=str(path)), back.run)
    same(LATTICE, back.lattice)
    for case, other in zip(CASES, back.cases, strict=True):
        same(case, other)
    np.testing.assert_array_equal(back.positions, contents().positions)
    np.testing.assert_array_equal(back.reference_positions, contents().reference_positions)
    assert read_answers(path) == ANSWERS


def test_a_lattice_without_cells_and_a_run_without_notes_or_front_come_back(path):
    bare = SpringLattice(nodes=LATTICE.nodes, springs=LATTICE.springs)
    write(path, contents(lattice=bare, run=dataclasses.replace(RUN, notes={}, front=Front())), ANSWERS)
    assert read(path).lattice.cells is None
    assert read(path).run.notes == {}
    same(Front(), read(path).run.front)


def test_a_run_file_of_the_time_before_there_were_fronts_is_read(path):
    write(path, contents(), ANSWERS)
    with h5py.File(path, "a") as file:
        del file["front"]
    same(Front(), read(path).run.front)


def test_fitted_parameters_come_back_and_a_run_without_them_keeps_no_trace_of_them(path):
    fitted = {"volume.modulus": [0.1 + 0.2]}
    run = dataclasses.replace(RUN, parameters=fitted, parameter_intervals={"volume.modulus": [0.0, 1.0]})
    write(path, contents(run=run), ANSWERS)
    same(dataclasses.replace(run, run=str(path)), read(path).run)
    path.unlink()
    write(path, contents(), ANSWERS)
    with h5py.File(path) as file:
        assert "parameter" not in file["run"].asstr()[()]


def test_times_and_motions_come_back(path):
    cases = [dataclasses.replace(case, times=np.array([0.5, 0.1 + 0.9])) for case in CASES]
    motion = np.random.default_rng(1).uniform(size=(2, 2, 4, 2))
    write(path, dataclasses.replace(contents(cases=cases), reference_positions=motion, positions=-motion), ANSWERS)
    back = read(path)
    np.testing.assert_array_equal(back.positions, -motion)
    for case, other in zip(cases, back.cases, strict=True):
        same(case, other)


def test_only_the_run_file_is_left_behind(path):
    write(path, contents(), ANSWERS)
    write(path, contents(), ANSWERS)
    assert [entry.name for entry in path.parent.iterdir()] == ["run.h5"]


def test_a_file_that_can_not_be_written_is_told_in_one_sentence(tmp_path):
    with pytest.raises(RunFileError, match=r"can't be written .*its journal holds the run"):
        write(tmp_path / "gone" / "run.h5", contents(), ANSWERS)


def test_only_an_earlier_state_of_the_same_run_is_replaced(path):
    write(path, contents(), ANSWERS[:2])
    write(path, contents(), ANSWERS)
    assert read_answers(path) == ANSWERS
    with pytest.raises(RunFileError, match="holds another run than its journal"):
        write(path, contents(order=dataclasses.replace(ORDER, seed=6)), [])
    assert read_answers(path) == ANSWERS
    path.write_text("mine")
    with pytest.raises(RunFileError, match="is no run file of springopt"):
        write(path, contents(), ANSWERS)
    assert path.read_text() == "mine"


def test_an_order_comes_back_from_its_json():
    assert Order.from_json(ORDER.to_json()) == ORDER


def test_a_run_is_one_json_object_with_every_number_exact():
    told = json.loads(RUN.to_json())
    assert set(told) == {field.name for field in dataclasses.fields(RUN)}
    assert told["objective"] == RUN.objective
    assert told["stiffness"] == RUN.stiffness.tolist()
    assert [(each["evaluations"], each["value"]) for each in told["history"]] == [(1, 5.0), (7, RUN.objective)]
    assert told["front"] == {"values": [5.0, RUN.objective], "springs": [2, 5], "points": [[3.0, 1e-300], [1.0, -0.0]]}


def test_numbers_that_are_not_finite_are_null_in_json():
    run = dataclasses.replace(RUN, objective=np.inf, errors=[{"distance": float("nan")}])
    told = json.loads(run.to_json())
    assert told["objective"] is None
    assert told["errors"] == [{"distance": None}]


def damage(path, kind):
    """Makes a run file, and from it one that can't be read."""
    write(path, contents(), ANSWERS * 100)
    if kind == "missing":
        path.unlink()
    elif kind == "text":
        path.write_text("notes")
    elif kind == "empty":
        path.write_bytes(b"")
    elif kind == "truncated":
        path.write_bytes(path.read_bytes()[:-100])
    elif kind == "half":
        path.write_bytes(path.read_bytes()[:4096])
    elif kind == "foreign":
        h5py.File(path, "w").close()
    else:
        with h5py.File(path, "a") as file:
            if kind == "newer":
                file.attrs["version"] = FORMAT + 1
            else:
                del file[kind]


@pytest.mark.parametrize(
    ("kind", "sentence"),
    [
        ("missing", "there is no run file .*run.h5; give the path"),
        ("text", "is no run file of springopt; give the path"),
        ("empty", "is no run file of springopt; give the path"),
        ("truncated", "is damaged .*; start a new run"),
        ("half", "is damaged .*; start a new run"),
        ("foreign", "is an HDF5 file, but no run file of springopt"),
        ("newer", f"has run file format {FORMAT + 1}, and this springopt reads {FORMAT}; use a newer"),
        ("positions", "is damaged .*; start a new run"),
        ("lattice/nodes", "is damaged .*; start a new run"),
        ("run", "is damaged .*; start a new run"),
        ("stiffness", "is damaged .*; start a new run"),
    ],
)
def test_a_file_that_can_not_be_read_is_refused_in_one_sentence(path, kind, sentence):
    damage(path, kind)
    with pytest.raises(RunFileError, match=sentence):
        read(path)


def test_answers_that_are_missing_are_damage_too(path):
    damage(path, "answers/value")
    with pytest.raises(RunFileError, match="is damaged"):
        read_answers(path)
