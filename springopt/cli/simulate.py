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
    from springopt.scene import Setup


@click.command("simulate", short_help=COMMANDS["simulate"])
@click.argument("source", metavar="SCENE|RUN.h5")
@click.option(
    "--stiffness",
    metavar="NUMBER|FILE",
    help="One number for all springs, or a .npy, .csv, .txt or .json file with one for each; of a run, its own.",
)
@click.option("--out", metavar="FILE.npz", help="Write positions, reference positions and stiffness as arrays.")
@click.option("--figure", metavar="FILE", help="Draw every load case; .png, .pdf or .svg.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document, positions and all.")
def command(source: str, stiffness: str | None, out: str | None, figure: str | None, as_json: bool) -> None:
    """Deform a mass-spring model under every load case of a scene, and compare it with the scene's reference."""
    out_path = None if out is None else require_new(out, ARRAY_ENDINGS)
    figure_path = None if figure is None else require_new(figure, FIGURE_ENDINGS)
    setup, row = _load(source, stiffness)
    answers, numbers = _answers(setup, row), row[: setup.lattice.spring_count]
    if out_path is not None:
        _write_arrays(out_path, setup, numbers, answers)
    if figure_path is not None:
        _draw(figure_path, setup, numbers, answers)
    if as_json:
        click.echo(json.dumps({"scene": setup.scene.name, "stiffness": numbers.tolist(), "load_cases": answers}))
    else:
        from springopt.report.tables import simulation_table

        print_table(simulation_table(setup.scene.title, answers))


def _load(source: str, stiffness: str | None) -> tuple[Setup, Floats]:
    """The scene made ready, and the stiffness that was given, or what the run found, parameters of effects too."""
    from springopt.scene import Scene, load_scene

    if names_run(source):
        contents = read_run(source)
        setup = Scene.from_json(contents.order.scene).build()
        if stiffness is None:
            return setup, setup.encoding.decode(contents.run.point)
        return setup, read_stiffness(stiffness, setup.lattice.spring_count)
    if stiffness is None:
        raise UserError("a scene states no stiffness of its own; give --stiffness a number or a file, or give a run.")
    setup = load_scene(source).build()
    return setup, read_stiffness(stiffness, setup.lattice.spring_count)


def _answers(setup: Setup, row: Floats) -> list[dict[str, Any]]:
    """For each load case its error, status, energy, residual and positions; in motion of each time, the energy too."""
    solution = setup.objective.solution(row)
    return [
        asdict(error) | {"energy": energy.tolist(), "residual": float(residual), "positions": positions.tolist()}
        for error, energy, residual, positions in zip(
            setup.objective.errors(row), solution.energy, solution.residual, solution.positions, strict=True
        )
    ]


def _write_arrays(path: Path, setup: Setup, stiffness: Floats, answers: list[dict[str, Any]]) -> None:
    import numpy as np

    np.savez(
        path,
        stiffness=stiffness,
        nodes=setup.lattice.nodes,
        springs=setup.lattice.springs,
        load_cases=[answer["name"] for answer in answers],
        status=[str(answer["status"]) for answer in answers],
        positions=[answer["positions"] for answer in answers],
        reference_positions=setup.reference_positions,
    )


def _draw(path: Path, setup: Setup, stiffness: Floats, answers: list[dict[str, Any]]) -> None:
    import numpy as np

    from springopt.report.deformation import deformations
    from springopt.report.figures import Learned, draw, save

    positions = np.array([answer["positions"] for answer in answers])
    learned = Learned(
        title=f"{setup.scene.name}, given stiffness",
        lattice=setup.lattice,
        stiffness=stiffness,
        deformations=deformations(setup.cases, setup.reference_positions, positions, answers),
    )
    save(draw(learned), path)
