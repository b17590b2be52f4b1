"""The house's order, as docs/architecture.md draws it: imports run downwards, heavy libraries stay in their rooms."""

import ast
import re
import subprocess
import sys
import tomllib
from itertools import chain
from pathlib import Path

import pytest

import springopt

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "springopt"

#: Where each library may be imported: these rooms or modules, everywhere for NumPy.
LIBRARIES = {
    "click": ["cli"],
    "distributed": ["benchmark.cluster"],
    "h5py": ["store"],
    "llvmlite": ["effects", "forward"],
    "matplotlib": ["report"],
    "meshio": ["mesh"],
    "numba": ["effects", "forward"],
    "numpy": [""],
    "platformdirs": ["effects"],
    "pyamg": ["forward.multigrid"],
    "pydantic": ["scene"],
    "pydantic_core": ["scene"],
    "rich": ["cli", "report"],
    "scipy": [
        "analysis",
        "comparison",
        "forward.multigrid",
        "forward.pattern",
        "forward.superlu",
        "objective",
        "problem",
        "reference",
        "testing",
        "tradeoff.independent",
    ],
    "skfem": ["reference.discretization"],
    "threadpoolctl": ["analysis", "benchmark", "execution", "testing"],
}
#: What comes with a library that is asked for by name.
COMES_WITH = {"llvmlite": "numba", "pydantic_core": "pydantic", "skfem": "scikit-fem"}


def module_name(path):
    """The dotted name below the package; "" for the package itself."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def imports(path):
    """Every absolute name that a file imports, also inside functions and for type checking only."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path} has a relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def own_imports(path):
    """The modules of the package that a file imports, below the package's name."""
    for name in imports(path):
        top, _, below = name.partition(".")
        if top == "springopt":
            yield below if below in MODULES else below.rpartition(".")[0]


def room_of(module):
    return module.partition(".")[0]


def storeys():
    """Room -> (storey, its rooms), from the drawing: a line a storey, commas between rooms, + within a room."""
    text = (ROOT / "docs" / "architecture.md").read_text()
    drawing = re.search(r"## Storeys\n.*?```\n(.*?)```", text, re.DOTALL)[1]
    return {
        name: (storey, room)
        for storey, line in enumerate(reversed(drawing.splitlines()))
        for room in line.split(", ")
        for name in room.split(" + ")
    }


def test_every_module_has_its_place_in_the_house():
    assert set(storeys()) == {room_of(module) for module in MODULES} - {""}


@pytest.mark.parametrize("module", sorted(set(MODULES) - {""}))
def test_imports_run_downwards(module):
    place = storeys()
    storey, room = place[room_of(module)]
    for imported in own_imports(MODULES[module]):
        if imported:
            below, other = place[room_of(imported)]
            assert other == room or below < storey, f"{module} imports {imported}, which is not below it"


def test_the_package_itself_imports_none_of_its_modules():
    assert not list(own_imports(MODULES[""]))


@pytest.mark.parametrize("module", sorted(MODULES))
def test_libraries_stay_in_their_rooms(module):
    for name in imports(MODULES[module]):
        library = name.partition(".")[0]
        if library != "springopt" and library not in sys.stdlib_module_names:
            assert library in LIBRARIES, f"{module} imports {library}, which the core does not depend on"
            at_home = any(not home or module == home or module.startswith(home + ".") for home in LIBRARIES[library])
            assert at_home, f"{module} imports {library}, which belongs to {LIBRARIES[library]}"


def test_the_core_depends_on_what_it_imports_and_nothing_else():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    asked = [*project["dependencies"], *project["optional-dependencies"]["dask"]]
    required = {re.match(r"[\w-]+", requirement)[0] for requirement in asked}
    assert required == {COMES_WITH.get(library, library) for library in LIBRARIES}


def test_every_dependency_has_its_line_in_the_docs():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    text = (ROOT / "docs" / "dependencies.md").read_text()
    for requirement in chain(project["dependencies"], *project["optional-dependencies"].values()):
        name = re.match(r"[\w-]+", requirement)[0]
        assert f"| {name} |" in text, f"docs/dependencies.md does not say why {name}"


@pytest.mark.parametrize("folder", sorted(path.parent.name for path in ROOT.glob("plugins/*/pyproject.toml")))
def test_a_plugin_knows_no_other_plugin(folder):
    others = {path.stem for path in ROOT.glob("plugins/*/springopt_*") if path.parent.name != folder}
    for path in (ROOT / "plugins" / folder).rglob("*.py"):
        assert not others & {name.partition(".")[0] for name in imports(path)}


def test_importing_springopt_loads_the_standard_library_alone():
    code = "import sys; before = set(sys.modules); import springopt; print(*sorted(set(sys.modules) - before))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {name.partition(".")[0] for name in done.stdout.split()}
    assert loaded <= sys.stdlib_module_names | {"springopt"}


@pytest.mark.parametrize("name", springopt.__all__)
def test_every_public_name_is_found(name):
    assert getattr(springopt, name) is not None
    assert name in dir(springopt)


def test_another_name_is_no_attribute():
    with pytest.raises(AttributeError, match="no attribute 'SpringLatice'"):
        _ = springopt.SpringLatice
