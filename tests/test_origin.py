import pytest

from springopt.errors import RunFileError
from springopt.origin import require_this_origin, this_origin


def test_the_origin_names_libraries_and_processor():
    assert set(this_origin()) == {"python", "springopt", "numpy", "scipy", "numba", "processor"}
    assert all(this_origin().values())


def test_the_same_build_and_processor_pass():
    require_this_origin(this_origin(), "run.h5")


@pytest.mark.parametrize("name", ["numpy", "processor"])
def test_another_one_is_refused_in_one_sentence(name):
    other = this_origin() | {name: "something else"}
    with pytest.raises(RunFileError, match=rf"run.h5 was made with {name} something else and here it is .*new run\."):
        require_this_origin(other, "run.h5")
