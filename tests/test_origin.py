from importlib.metadata import version

import pytest

from springopt import origin
from springopt.errors import RunFileError
from springopt.origin import require_this_origin, this_origin
from springopt.random_search import RandomSearch

LIBRARIES = {"python", "springopt", "numpy", "scipy", "numba"}
HERE = this_origin(RandomSearch)


def test_the_origin_names_libraries_sources_optimizer_and_processor():
    assert set(HERE) == LIBRARIES | {"springopt's sources", "the optimizer of", "processor"}
    assert all(HERE.values())
    assert HERE["the optimizer of"] == f"springopt {version('springopt')}"


def test_an_optimizer_that_is_not_installed_has_no_distribution():
    mine = type("Mine", (RandomSearch,), {"name": "mine"})
    assert this_origin(mine)["the optimizer of"] == "no distribution"


def test_the_same_build_and_processor_pass():
    require_this_origin(HERE, "run.h5", RandomSearch)


@pytest.mark.parametrize("name", ["numpy", "springopt's sources", "the optimizer of", "processor"])
def test_another_one_is_refused_in_one_sentence(name):
    other = HERE | {name: "something else"}
    with pytest.raises(RunFileError, match=rf"run.h5 was made with {name} something else and here it is .*new run\."):
        require_this_origin(other, "run.h5", RandomSearch)


def test_sources_count_where_an_answer_could_depend_on_them(tmp_path, monkeypatch):
    monkeypatch.setattr(origin, "__file__", str(tmp_path / "origin.py"))
    (tmp_path / "cli").mkdir()
    digests = []
    for place in ("origin.py", "cli/solve.py", "model.py"):
        (tmp_path / place).write_text("x = 1")
        digests.append(origin._sources.__wrapped__())
    assert digests[0] == digests[1] != digests[2]
