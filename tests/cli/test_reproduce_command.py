"""`springopt reproduce` on the command line."""

from pathlib import Path

import pytest

from springopt.reproduction import extent


def test_a_page_is_made_and_named(springopt, monkeypatch: pytest.MonkeyPatch) -> None:
    tiny = extent.Extent("quick", (100,), (100,), 0.0, least=10)
    monkeypatch.setattr(extent, "QUICK", tiny)
    asked = ("reproduce", "--quick", "--only", "topology-3d", "--workers", "1")
    assert springopt(*asked) == (0, "Page: reproduction/reproduction.md\n", "")
    assert Path("reproduction/reproduction/figure-2.png").exists()
    assert Path("reproduction/runs/quick/paper-topology-3d/paper-ga/seed100.h5").exists()
    code, out, err = springopt(*asked)
    assert (code, out) == (2, "")
    assert "reproduction.md exists already, and nothing is overwritten; move it away" in err


def test_an_experiment_that_there_is_not_is_one_sentence(springopt) -> None:
    code, out, err = springopt("reproduce", "--only", "table-2")
    assert (code, out) == (2, "")
    assert "there is no experiment 'table-2'; there are figure-1, topology-3d, stiffness, load-sets, figure-3," in err
