import sqlite3

import numpy as np
import pytest

from springopt.budget import Budget
from springopt.errors import RecordBroken, RunFileError
from springopt.journal import FORMAT, Journal, holds_run, journal_path, run_path
from springopt.problem import Problem
from springopt.recorder import NO_QUESTION, Answer
from springopt.run import Order
from springopt.testing import Bowl, Box

ORDER = Order(scene="{}", optimizer="sampler", options={"batch": 3}, seed=5, budget={"evaluations": 9}, origin={})
ANSWERS = [
    Answer("value", bytes(range(16)), 1e-8, 0, 0.1 + 0.2, 1.5, 1.25, 0.5),
    Answer("gradient", bytes(16), 1e-8, 0, -0.0, 2.5, 2.25, 1.5, np.array([1e-300, -0.0]).tobytes()),
    Answer("jacobian", bytes(16), 1e-8, 0, 3.0, 2.5, 2.25, 1.5, None, b"x" * 16),
    Answer("gradient", bytes(16), 1e-8, -1, None, 3.5, 3.25, 2.5, "§ no equilibrium".encode()),
    Answer("budget_left", NO_QUESTION, 1e-8, 0, np.inf, 4.0, 4.0, 3.0),
]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.h5.journal"


def test_answers_come_back_to_the_bit_and_in_order(path):
    with Journal.create(path, ORDER) as journal:
        journal.record(ANSWERS[:2])
        journal.record(ANSWERS[2:])
    with Journal.open(path) as journal:
        assert journal.order == ORDER
        assert list(journal.answers()) == ANSWERS
        again = [journal.recorded(answer.kind, [answer.question])[0] for answer in ANSWERS]
        assert again == ANSWERS
        assert np.signbit(again[1].value)
        assert journal.recorded("value", [NO_QUESTION]) == []


def test_a_batch_gets_as_many_answers_as_there_are(path):
    with Journal.create(path, ORDER, [ANSWERS[0]] * 3) as journal:
        assert len(journal.recorded("value", [ANSWERS[0].question] * 2)) == 2
        assert len(journal.recorded("value", [ANSWERS[0].question] * 2)) == 1
        journal.record([ANSWERS[1]])
        assert journal.recorded("gradient", [ANSWERS[1].question]) == []
        assert list(journal.answers()) == [ANSWERS[0]] * 3 + [ANSWERS[1]]


@pytest.mark.parametrize(("kind", "question"), [("value", bytes(16)), ("gradient", ANSWERS[0].question)])
def test_another_question_than_the_recorded_one_is_told_in_one_sentence(path, kind, question):
    refused = pytest.raises(RecordBroken, match="optimizer sampler asked something else than in the recorded run")
    with Journal.create(path, ORDER, ANSWERS) as journal, refused:
        journal.recorded(kind, [question])


def test_a_problem_replays_its_journal(path):
    box, budget = Box(np.zeros(2), np.ones(2)), Budget(seconds=100.0)
    points = np.random.default_rng(0).uniform(size=(200, 2))

    def answers(journal):
        problem = Problem(Bowl(np.ones(2)), box, budget, journal)
        return [problem.evaluate(points), problem.budget_left, *problem.gradient(points[0])]

    with Journal.create(path, ORDER) as journal:
        live = answers(journal)
    with Journal.open(path) as journal:
        np.testing.assert_equal(answers(journal), live)
        assert len(list(journal.answers())) == 202


def test_a_new_journal_overwrites_nothing(path):
    path.write_text("mine")
    with pytest.raises(RunFileError, match="exists already: a run was cut short"):
        Journal.create(path, ORDER)
    assert path.read_text() == "mine"
    path.write_text("")
    with pytest.raises(RunFileError, match="it had not begun: delete the file, or choose another output"):
        Journal.create(path, ORDER)


def test_a_folder_that_is_not_there_is_refused_in_one_sentence(tmp_path):
    with pytest.raises(RunFileError, match=r"can't be written .No such file or directory.; choose another output"):
        Journal.create(tmp_path / "gone" / "run.h5.journal", ORDER)


def test_a_journal_without_an_answer_leaves_nothing_behind(path):
    with Journal.create(path, ORDER):
        assert path.exists()
    assert list(path.parent.iterdir()) == []


def test_deleting_leaves_nothing_behind(path):
    journal = Journal.create(path, ORDER, ANSWERS)
    journal.record(ANSWERS)
    journal.delete()
    journal.close()
    assert list(path.parent.iterdir()) == []


def test_one_process_holds_a_journal_at_a_time(path):
    with Journal.create(path, ORDER, ANSWERS), pytest.raises(RunFileError, match="is in use by another process"):
        Journal.open(path)


@pytest.mark.parametrize("content", [b"notes\n", b"", b"SQLite format 3\0" + bytes(84)])
def test_a_foreign_file_is_refused_and_left_as_it_is(path, content):
    path.write_bytes(content)
    with pytest.raises(RunFileError, match="is no journal of springopt"):
        Journal.open(path)
    assert path.read_bytes() == content


def test_a_foreign_database_is_refused(path):
    connection = sqlite3.connect(path)
    with connection:
        connection.execute("CREATE TABLE answers (x)")
    connection.close()
    with pytest.raises(RunFileError, match="is no journal of springopt"):
        Journal.open(path)


def test_a_missing_file_is_refused(path):
    with pytest.raises(RunFileError, match=r"can't be read .No such file"):
        Journal.open(path)


@pytest.mark.parametrize(("other", "which"), [(FORMAT + 1, "a newer"), (FORMAT - 1, "the older")])
def test_another_format_is_refused(path, other, which):
    Journal.create(path, ORDER, ANSWERS).close()
    connection = sqlite3.connect(path)
    connection.execute(f"PRAGMA user_version = {other}")
    connection.close()
    with pytest.raises(
        RunFileError, match=f"has journal format {other}, and this springopt reads {FORMAT}; use {which}"
    ):
        Journal.open(path)


@pytest.mark.parametrize("length", [200, 5000])
def test_a_truncated_journal_is_refused(path, length):
    Journal.create(path, ORDER, ANSWERS * 200).close()
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(RunFileError, match=r"(?s)is damaged|can't be written or read"):
        list(Journal.open(path).answers())


def test_the_empty_file_of_a_run_killed_at_once_holds_no_run(path):
    assert not holds_run(path)
    path.touch()
    assert not holds_run(path)
    path.unlink()
    Journal.create(path, ORDER, ANSWERS).close()
    assert holds_run(path)


def test_the_journal_lies_beside_its_run_file(tmp_path):
    run = tmp_path / "a.h5"
    assert journal_path(run).name == "a.h5.journal"
    assert run_path(journal_path(run)) == run_path(run) == run
