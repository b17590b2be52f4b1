"""`springopt check-plugin`: the verdicts of the checks as a table and as one document, and the exit code."""

import json

import pytest

from springopt.testing import CHECKS, EFFECT_CHECKS

NAMES = [check.__name__.removeprefix("check_").replace("_", " ") for check in CHECKS]


def lazy(self, problem, rng):
    print("nothing to do")


def test_a_sound_optimizer_passes_every_check(springopt) -> None:
    code, out, err = springopt("check-plugin", "random-search")
    assert (code, err) == (0, "")
    assert all(name in out for name in NAMES)
    assert out.count("passed") == len(CHECKS)
    assert "random-search keeps the contract." in out


def test_a_fault_is_named_with_what_to_mend_and_exits_1(springopt, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("springopt.random_search.RandomSearch.minimize", lazy)
    code, out, err = springopt("check-plugin", "random-search")
    assert code == 1
    assert "failed" in out
    assert "ask for at least one value" in out
    assert "random-search does not keep the contract: mend what failed." in out
    assert "nothing to do" in err


def test_as_json_it_is_one_document(springopt, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("springopt.random_search.RandomSearch.minimize", lazy)
    code, out, _ = springopt("check-plugin", "random-search", "--json")
    answer = json.loads(out)
    assert (code, answer["optimizer"], answer["passed"]) == (1, "random-search", False)
    assert [check["check"] for check in answer["checks"]] == NAMES
    assert answer["checks"][0] == {"check": "options are documented", "verdict": "passed", "sentence": ""}
    assert answer["checks"][1]["verdict"] == "failed"
    assert answer["checks"][1]["sentence"].startswith("random-search ended without a question")
    assert answer["checks"][-1]["verdict"] == "not judged"


def test_an_unknown_name_is_a_mistake_in_one_sentence(springopt) -> None:
    code, out, err = springopt("check-plugin", "random-serch")
    assert (code, out) == (2, "")
    assert "there is no optimizer 'random-serch'" in err
    assert err.count("\n") == 1


def test_an_effect_is_checked_with_the_options_that_are_set(springopt) -> None:
    code, out, _ = springopt("check-plugin", "gravity", "--set", "acceleration=0,-9.81", "--json")
    answer = json.loads(out)
    assert (code, answer["effect"], answer["passed"]) == (0, "gravity", True)
    assert len(answer["checks"]) == len(EFFECT_CHECKS)


def test_an_option_without_a_default_must_be_set(springopt) -> None:
    code, _, err = springopt("check-plugin", "gravity")
    assert (code, err) == (2, "Error: gravity needs its option acceleration, a list, each a number; set it.\n")
