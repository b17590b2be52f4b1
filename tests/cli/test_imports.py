"""What a command imports: heavy packages only where they are needed."""

import subprocess
import sys
from pathlib import Path

REPORT = """
import sys
before = set(sys.modules)
from springopt.cli.main import run
code = run({arguments!r})
print(*sorted({{name.partition(".")[0] for name in set(sys.modules) - before}}), file=sys.stderr)
sys.exit(code)
"""


def imported(*arguments: str) -> set[str]:
    script = REPORT.format(arguments=list(arguments))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(done.stderr.split()) - set(sys.stdlib_module_names)


def test_help_imports_click_and_the_standard_library_alone() -> None:
    assert imported("--help") == {"click", "springopt"}


def test_listing_scenes_imports_no_numerics() -> None:
    assert not imported("list", "scenes") & {"numpy", "scipy", "numba", "matplotlib", "pydantic", "h5py", "skfem"}


def test_listing_optimizers_imports_neither_kernels_nor_figures() -> None:
    assert not imported("list", "optimizers") & {"numba", "matplotlib", "h5py", "skfem", "pydantic"}


def test_comparing_imports_statistics_but_neither_kernels_nor_figures(tmp_path: Path) -> None:
    assert not imported("compare", "--help") & {"numpy", "scipy", "rich", "h5py", "matplotlib"}
    run = str(tmp_path / "run.h5")
    imported("solve", "paper-fem-2d-4", "--optimizer", "random-search", "--evaluations", "3", "--out", run)
    loaded = imported("compare", run)
    assert "scipy" in loaded
    assert not loaded & {"numba", "matplotlib", "skfem", "pydantic"}


def test_checking_a_scene_imports_no_kernels() -> None:
    script = "import sys, springopt; springopt.load_scene('paper-stiffness-2d'); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not set(done.stdout.split()) & {"numba", "matplotlib", "h5py", "skfem", "scipy"}


def test_showing_a_run_imports_neither_kernels_nor_what_computes_floors(tmp_path: Path) -> None:
    run = str(tmp_path / "run.h5")
    imported("solve", "paper-fem-2d-4", "--optimizer", "random-search", "--evaluations", "3", "--out", run)
    assert not imported("show", run) & {"numba", "matplotlib", "skfem", "scipy", "pydantic"}
