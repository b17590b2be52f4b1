"""`springopt simulate`: the forward solve of a scene or a run, without any optimizer."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springopt.cli.main import COMMANDS
from springopt.cli.outputs import ARRAY_ENDINGS, FIGURE_ENDINGS, require_new
from springopt.cli.results import print_table
from springopt.cli.runs import names_run, read_run
from springopt.cli.stiffness import read_stiffness
from springopt.errors import UserError

if TYPE_CHECKING:
    from springopt.checks import Floats
    from springopt.load_case import LoadCase
    from springopt.model import Solution
    from springopt.parameters import Parameters
    from springopt.scene import Setup


@click.command("simulate", short_help=COMMANDS["simulate"])
@click.argument("source", metavar="SCENE|RUN.h5")
@click.option(
    "--stiffness",
    metavar="NUMBER|FILE",
    help="One number for all springs, or a .npy, .csv, .txt or .json file with one for each; of a run, its own.",
)
@click.option("--out", metavar="FILE.npz", help="Write positions, in motion with times and velocities, as arrays.")
@click.option("--figure", metavar="FILE", help="Draw every load case; .png, .pdf or .svg.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document, positions and all.")
def command(source: str, stiffness: str | None, out: str | None, figure: str | None, as_json: bool) -> None:
    """Deform a mass-spring model under every load case of a scene, and compare it with the scene's reference.

    Effects act as the scene states them, those of a run with the parameters that it found.
    """
    out_path = None if out is None else require_new(out, ARRAY_ENDINGS)
    figure_path = None if figure is None else require_new(figure, FIGURE_ENDINGS)
    setup, candidate = _load(source, stiffness)
    solution = setup.objective.solution(candidate)
    errors = [asdict(error) for error in setup.objective.errors(candidate)]
    if out_path is not None:
        _write_arrays(out_path, setup, candidate, solution)
    if figure_path is not None:
        _draw(figure_path, setup, solution, errors)
    if as_json:
        click.echo(json.dumps(_document(setup, candidate, solution, errors)))
        return
    from springopt.report.tables import simulation_table

    print_table(simulation_table(setup.scene.title, _rows(solution, errors), is_motion=_is_motion(setup)))
    if figure_path is not None:
        click.echo(f"Figure: {figure_path}")


def _load(source: str, stiffness: str | None) -> tuple[Setup, Parameters]:
    """The scene made ready, and the stiffness that was given or that the run found, with the run's parameters."""
    from springopt.parameters import Parameters
    from springopt.scene import Scene, load_scene

    if names_run(source):
        contents = read_run(source)
        run, setup = contents.run, Scene.from_json(contents.order.scene).build()
        numbers = run.stiffness if stiffness is None else read_stiffness(stiffness, setup.lattice.spring_count)
        return setup, Parameters(numbers, run.parameters)
    if stiffness is None:
        raise UserError("a scene states no stiffness of its own; give --stiffness a number or a file, or give a run.")
    setup = load_scene(source).build()
    return setup, Parameters(read_stiffness(stiffness, setup.lattice.spring_count))


def _is_motion(setup: Setup) -> bool:
    return setup.cases[0].times is not None


def _rows(solution: Solution, errors: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """For each load case its error, status, residual and energy, in motion one for each time."""
    return [
        error | {"energy": energy.tolist(), "residual": float(residual)}
        for error, energy, residual in zip(errors, solution.energy, solution.residual, strict=True)
    ]


def _document(setup: Setup, candidate: Parameters, solution: Solution, errors: list[dict[str, Any]]) -> dict[str, Any]:
    """Everything, positions and all; in motion of each load case its times too."""
    rows = [
        row | {"positions": positions.tolist()}
        for row, positions in zip(_rows(solution, errors), solution.positions, strict=True)
    ]
    if _is_motion(setup):
        for row, case, velocities in zip(rows, setup.cases, solution.velocities, strict=True):
            row |= {"times": _times(case), "velocities": velocities.tolist()}
    document = {"scene": setup.scene.name, "stiffness": candidate.stiffness.tolist(), "load_cases": rows}
    parameters = {name: value.tolist() for name, value in _values(candidate).items()}
    return document | ({"parameters": parameters} if parameters else {})


def _times(case: LoadCase) -> list[float]:
    return [] if case.times is None else case.times.tolist()


def _values(candidate: Parameters) -> dict[str, Floats]:
    import numpy as np

    return {name: np.asarray(value, dtype=float) for name, value in candidate.values.items()}


def _write_arrays(path: Path, setup: Setup, candidate: Parameters, solution: Solution) -> None:
    import numpy as np

    arrays: dict[str, Any] = {
        "stiffness": candidate.stiffness,
        "nodes": setup.lattice.nodes,
        "springs": setup.lattice.springs,
        "load_cases": [case.name for case in setup.cases],
        "status": [str(status) for status in solution.status],
        "positions": solution.positions,
        "reference_positions": setup.reference_positions,
    }
    if _is_motion(setup):
        arrays |= {"times": [_times(case) for case in setup.cases], "velocities": solution.velocities}
    np.savez(path, **arrays | _values(candidate))


def _draw(path: Path, setup: Setup, solution: Solution, errors: list[dict[str, Any]]) -> None:
    from springopt.report.deformation import deformations
    from springopt.report.figures import Learned, draw, save

    learned = Learned(
        title=f"{setup.scene.name}, given stiffness",
        lattice=setup.lattice,
        stiffness=solution.stiffness,
        deformations=deformations(setup.cases, setup.reference_positions, solution.positions, errors),
    )
    save(draw(learned), path)
