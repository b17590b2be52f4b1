"""`springopt tradeoff` on the command line, on the axes that are quick."""

import json
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
QUICK = ("tradeoff", "paper-fem-2d", "--axis", "effects", "--seconds", "0.3")


def test_it_prints_a_table_and_writes_a_page(springopt):
    code, out, err = springopt(*QUICK)
    assert (code, err) == (0, "")
    assert "Effects: with everything, and without each" in out
    assert "exact kinematics" in out
    assert out.endswith("Page with figures: paper-fem-2d-tradeoff.html\n")
    assert "<svg" in Path("paper-fem-2d-tradeoff.html").read_text()
    code, out, err = springopt(*QUICK)
    assert (code, out) == (2, "")
    assert "paper-fem-2d-tradeoff.html exists already, and nothing is overwritten" in err


def test_json_has_everything_and_writes_no_page_unless_asked(springopt):
    code, out, _ = springopt(*QUICK, "--json")
    answer = json.loads(out)
    assert code == 0
    assert [axis["axis"] for axis in answer["axes"]] == ["effects"]
    assert {point["setting"] for point in answer["axes"][0]["points"]} == {"everything", "exact kinematics"}
    assert list(Path().iterdir()) == []
    springopt(*QUICK, "--json", "--out", "page.md")
    assert sorted(path.name for path in Path().iterdir()) == ["page", "page.md"]
    assert "springopt tradeoff paper-fem-2d --axis effects --seconds 0.3" in Path("page.md").read_text()


def test_the_reverse_question_is_answered_by_a_run_of_its_own(springopt):
    code, out, _ = springopt(*QUICK, "--json", "--target-error", "1e-6")
    (answer,) = json.loads(out)["answers"]
    assert code == 0
    assert answer["verified"]["setting"] == "everything"
    assert answer["said"].startswith("effects: the cheapest setting that keeps an error of 1e-06 is with everything")
    code, out, _ = springopt(*QUICK, "--json", "--time", "1e-9")
    assert json.loads(out)["answers"][0]["verified"] is None


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["nowhere"], "there is no scene 'nowhere'."),
        (["paper-fem-2d", "--axis", "solvr"], "Did you mean 'solver'?"),
        (["paper-fem-2d", "--axis", "stepping"], "scene paper-fem-2d has none of these axes (stepping: its load cases"),
        (["paper-fem-2d", "--target-error", "1", "--time", "1"], "give one of them"),
        (["paper-fem-2d", "--target-error", "0"], "0.0 is not in the range x>0"),
        (["paper-fem-2d", "--seconds", "-1"], "-1.0 is not in the range x>0"),
        (["paper-fem-2d", "--seconds", "nan"], "nan is not a finite number"),
        (["paper-fem-2d", "--target-error", "inf"], "inf is not a finite number"),
        (["paper-fem-2d", "--out", "page.pdf"], "an output here ends in .html or .md, not as page.pdf"),
        (["paper-fem-2d", "--out", "no/page.html"], "the folder of no/page.html does not exist"),
    ],
)
def test_bad_input_is_one_sentence_and_writes_nothing(springopt, arguments, sentence):
    code, out, err = springopt("tradeoff", *arguments)
    assert (code, out) == (2, "")
    assert sentence in " ".join(err.split())
    assert list(Path().iterdir()) == []


def test_pictures_of_a_page_go_over_nothing(springopt):
    Path("page").mkdir()
    code, _, err = springopt(*QUICK, "--out", "page.md")
    assert code == 2
    assert "page, where the pictures would be, exists already" in err
