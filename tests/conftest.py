"""Settings of all tests."""

import os
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

# The same examples on every machine: a red test is red for everybody.
settings.register_profile("springopt", derandomize=True, deadline=None, database=None)
settings.load_profile("springopt")

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="session", autouse=True)
def the_core_as_it_is_here(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The core's entry points are those of pyproject.toml, whatever was installed of it, also in other processes."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    home = tmp_path_factory.mktemp("metadata")
    folder = home / f"springopt-{project['version']}.dist-info"
    folder.mkdir()
    metadata = f"Metadata-Version: 2.4\nName: springopt\nVersion: {project['version']}\n"
    (folder / "METADATA").write_text(metadata, encoding="utf-8")
    groups = {"console_scripts": project["scripts"], **project["entry-points"]}
    text = "".join(
        f"[{group}]\n" + "".join(f"{name} = {value}\n" for name, value in entries.items())
        for group, entries in groups.items()
    )
    (folder / "entry_points.txt").write_text(text, encoding="utf-8")
    before = os.environ.get("PYTHONPATH")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(home)
        paths = [str(home), str(ROOT), *([before] if before else [])]
        patch.setenv("PYTHONPATH", os.pathsep.join(paths))
        yield
