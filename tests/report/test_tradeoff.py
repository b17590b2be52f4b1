"""A tradeoff for people: the diagram shows every setting, the page holds what the table holds."""

import re
from html.parser import HTMLParser
from io import BytesIO

import pytest

from springopt.errors import UserError
from springopt.report.pages import Bullets, Cells, Code, Heading, Picture, Words, write_page
from springopt.report.tradeoff.figure import draw_tradeoff
from springopt.report.tradeoff.page import write_tradeoff
from springopt.report.tradeoff.rows import heads, rows, sentences
from springopt.report.tradeoff.said import say_error, say_seconds, say_time
from springopt.report.tradeoff.tables import tradeoff_table


def interval(value, spread=0.1):
    return {"value": value, "low": value * (1 - spread), "high": value * (1 + spread)}


def point(series, setting, error, seconds, **options):
    return {
        "series": series,
        "setting": setting,
        "states": {},
        "is_stated": False,
        "is_apart": False,
        "error": None if error is None else interval(error),
        "answers": 4,
        "failures": 4 if error is None else 0,
        "why": "",
        "processor_seconds": interval(seconds),
        "wall_seconds": interval(seconds),
        "warm_up_seconds": 0.2,
        "second_seconds": None,
        "repeats": 9,
        "numbers": {"springs": 72},
        "on_front": False,
    } | options


PRICE = {"factor": interval(3.1), "digits": 4.0, "said": "one digit more costs 3.1 times (2.79 to 3.41)"}
POINTS = [
    point("exact, lanes", "tolerance 1e-2", 1e-3, 1e-5, on_front=True),
    point("exact, lanes", "tolerance 1e-8", 1e-9, 1e-4, on_front=True, is_stated=True),
    point("exact, lanes", "tolerance 1e-12", 0.0, 1.2e-4),
    point("linear", "small displacements", 0.04, 2e-5, failures=1),
    point("exact, iterative", "tolerance 1e-8", None, 3e-2, why="iteration limit"),
]
AXIS = {
    "axis": "solver",
    "title": "Solver",
    "error": "error of positions | over the displacements",
    "time": "one forward solve",
    "second_time": "",
    "shown": ["springs"],
    "is_graded": True,
    "points": POINTS,
    "price_of_a_digit": PRICE,
    "prices_of_a_digit": {"exact, lanes": PRICE},
    "marks": {"explicit limit: step 0.31": 5e-5},
    "numbers": {},
    "notes": ["No engine computes in single precision."],
    "seconds": 3.0,
}
DOCUMENT = {
    "scene": "paper-fem-2d",
    "title": "A scene <of> words",
    "machine": {"processor": "some", "cores": 2, "springopt": "0.1"},
    "axes": [AXIS],
    "missing": {"stepping": "its load cases have no times"},
    "where_to_spend": ["The model is the largest part."],
    "answers": [],
}


def test_the_diagram_is_log_log_with_every_setting_front_mark_and_failure():
    figure = draw_tradeoff(AXIS)
    (axes,) = figure.axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert axes.get_xlabel() == "processor time of one forward solve [s]"
    drawn = {text.get_text() for text in axes.texts}
    assert {"tolerance 1e-2", "small displacements", "explicit limit: step 0.31"} <= drawn
    labels = {text.get_text() for legend in figure.legends for text in legend.get_texts()}
    series = {"exact, lanes", "linear", "exact, iterative"}
    assert labels == series | {"Pareto front", "as the scene states it", "no answer"}
    low, high = axes.get_xlim()
    assert low < 1e-5
    assert high > 3e-2  # the one that failed took the longest, and is seen
    (cross,) = axes.collections[-1].get_offsets()
    assert cross[0] == 3e-2
    assert PRICE["said"] in drawn


def test_a_second_time_has_a_diagram_of_its_own_with_the_marks():
    first, *others = POINTS
    timed = [first | {"second_seconds": interval(5e-3)}, *others]
    both = AXIS | {"points": timed, "second_time": "one step in real time"}
    left, right = draw_tradeoff(both).axes
    assert right.get_xlabel() == "processor time of one step in real time [s]"
    assert [container[0].get_xdata()[0] for container in right.containers] == [5e-3]
    marks = {"explicit limit: step 0.31"}
    assert marks <= {text.get_text() for text in right.texts}
    assert not marks & {text.get_text() for text in left.texts}
    assert "one step in real time" in heads(both)
    assert [row[7] for row in rows(both)] == ["5 ms (4.5 to 5.5)", "-", "-", "-", "-"]


def test_settings_that_are_choices_are_not_joined():
    def styles(is_graded):
        drawn = draw_tradeoff(AXIS | {"is_graded": is_graded}).axes[0].containers
        return {container[0].get_linestyle() for container in drawn}

    assert styles(True) == {"-"}
    assert styles(False) == {"None"}


def test_an_axis_without_any_answer_can_be_drawn():
    nothing = AXIS | {"points": [point("a", "b", None, 1.0)], "price_of_a_digit": None, "marks": {}}
    figure = draw_tradeoff(nothing)
    assert figure.axes[0].collections
    figure.savefig(BytesIO())


def test_the_table_has_a_row_a_setting_and_says_what_is_special():
    table = list(rows(AXIS))
    assert all(len(row) == len(heads(AXIS)) for row in table)
    assert [row[-1] for row in table] == [
        "front",
        "as stated, front",
        "",
        "1 of 4 failed",
        "4 of 4 failed (iteration limit)",
    ]
    assert table[4][2] == "-"
    assert table[0][7] == "72"
    assert tradeoff_table(AXIS).row_count == len(POINTS)


def test_sentences_begin_with_the_price_of_a_digit():
    assert sentences(AXIS) == [
        "Along the front one digit more costs 3.1 times (2.79 to 3.41).",
        "exact, lanes: one digit more costs 3.1 times (2.79 to 3.41).",
        "No engine computes in single precision.",
    ]


@pytest.mark.parametrize(("seconds", "said"), [(2.0, "2 s"), (3.14e-3, "3.14 ms"), (5e-6, "5 µs"), (4e-10, "0.4 ns")])
def test_seconds_have_the_unit_that_makes_them_short(seconds, said):
    assert say_seconds(seconds) == said


def test_intervals_have_one_unit_and_equal_ends_are_said_once():
    assert say_time({"value": 1.1e-3, "low": 0.9e-3, "high": 1.2e-3}) == "1.1 ms (0.9 to 1.2)"
    assert say_error({"value": 0.5, "low": 0.5, "high": 0.5}) == "0.5"
    assert say_error({"value": 0.5, "low": 0.4, "high": 0.6}) == "0.5 (0.4 to 0.6)"


class Tags(HTMLParser):
    """Counts elements, and wants each closed."""

    def __init__(self):
        super().__init__()
        self.open, self.count = [], {}

    def handle_starttag(self, tag, attrs):
        self.count[tag] = self.count.get(tag, 0) + 1
        if tag != "meta":
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.count[tag] = self.count.get(tag, 0) + 1

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_a_page_is_one_html_file_with_its_pictures_inside(tmp_path):
    write_tradeoff(tmp_path / "page.html", DOCUMENT, "springopt tradeoff paper-fem-2d")
    text = (tmp_path / "page.html").read_text()
    tags = Tags()
    tags.feed(text)
    assert tags.open == []
    assert (tags.count["svg"], tags.count["table"], tags.count["h1"]) == (1, 1, 1)
    assert "A scene &lt;of&gt; words" in text
    assert "src=" not in text
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]


def test_a_page_of_markdown_lies_beside_its_pictures(tmp_path):
    write_tradeoff(tmp_path / "page.md", DOCUMENT, "springopt tradeoff paper-fem-2d")
    text = (tmp_path / "page.md").read_text()
    (picture,) = re.findall(r"!\[.*\]\((.*)\)", text)
    assert (tmp_path / picture).stat().st_size > 10_000
    assert "```\nspringopt tradeoff paper-fem-2d\n```" in text
    assert "stepping: its load cases have no times" in text
    assert sorted(path.name for path in tmp_path.iterdir()) == ["page", "page.md"]


def test_blocks_of_a_page(tmp_path):
    blocks = [Heading("A", 1), Words("b"), Bullets(["c", "d"]), Code("e"), Cells(["f"], [["g|h"]])]
    write_page(tmp_path / "a.md", blocks)
    assert (tmp_path / "a.md").read_text() == "# A\n\nb\n\n- c\n- d\n\n```\ne\n```\n\n| f |\n| --- |\n| g\\|h |\n"


def test_a_page_that_can_not_be_written_is_one_sentence(tmp_path):
    with pytest.raises(UserError, match=r"page\.html can't be written"):
        write_page(tmp_path / "no" / "page.html", [Words("a")])
    with pytest.raises(UserError, match=r"page\.md can't be written"):
        write_page(tmp_path / "no" / "page.md", [Picture("a", draw_tradeoff(AXIS), "b")])
