"""The command line, run in this process in a folder of its own."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from springopt.cli.main import run


class Answer(NamedTuple):
    code: int
    out: str
    err: str


SpringoptCommand = Callable[..., Answer]


@pytest.fixture
def springopt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> SpringoptCommand:
    monkeypatch.chdir(tmp_path)

    def command(*arguments: str) -> Answer:
        code = run(arguments)
        return Answer(code, *capsys.readouterr())

    return command
