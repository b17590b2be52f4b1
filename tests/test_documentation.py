"""What the documentation shows in Python runs."""

import re
from pathlib import Path

import pytest

from springopt.testing import check_effect, check_optimizer

ROOT = Path(__file__).parents[1]


def python_blocks(page: str) -> list[str]:
    return re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)


def test_the_readme_s_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = python_blocks("README.md")
    names: dict[str, object] = {}
    exec(compile(example.replace("evaluations=2000", "evaluations=50"), "README.md", "exec"), names)
    assert names["gradient"].shape == (72,)  # type: ignore[attr-defined]
    objective, diagonal = capsys.readouterr().out.split()
    assert 0 < float(objective) < 1
    assert 0.5 < float(diagonal) < 10


def test_the_optimizer_in_the_documentation_keeps_the_contract(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # In a file of its own, because options are read off the source.
    (tmp_path / "my_package.py").write_text(python_blocks("docs/optimizers.md")[0], encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    from my_package import HillClimber  # type: ignore[import-not-found]

    check_optimizer(HillClimber())


def test_the_effect_in_the_documentation_keeps_the_contract(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "windy_package.py").write_text(python_blocks("docs/effects-of-your-own.md")[0], encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    from windy_package import Wind  # type: ignore[import-not-found]

    check_effect(Wind((1.0, 0.5)))


def test_every_page_that_is_linked_exists() -> None:
    pages = [path for pattern in ("*.md", "docs/*.md", "*/*/README.md") for path in ROOT.glob(pattern)]
    for page in pages:
        for link in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / link).exists(), f"{page.name} links {link}"


def test_the_tradeoff_s_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = python_blocks("docs/tradeoff.md")
    exec(compile(example, "docs/tradeoff.md", "exec"), {})
    *front, said = capsys.readouterr().out.splitlines()
    assert front[-1].startswith("with everything ")  # nothing is as accurate
    assert said.startswith("effects: the cheapest setting that keeps an error of 1e-06 is with everything")
