"""The load cases to add, as `springopt identify --design` answers."""

from __future__ import annotations

import json
from dataclasses import asdict
from math import isfinite
from typing import TYPE_CHECKING, Any

import click

from springopt.cli.results import print_table

if TYPE_CHECKING:
    from springopt.analysis.candidates import Candidate
    from springopt.analysis.design import Pick
    from springopt.analysis.point import Point
    from springopt.scene import Setup


def designed(setup: Setup, point: Point, noise: float, count: int, criterion: str, candidates: str) -> dict[str, Any]:
    """The picks, each with what it brings and what every other candidate would have brought."""
    from springopt.analysis.design import design

    chosen = _candidates(setup, point, candidates)
    picks = design(setup, point, chosen, count, criterion=criterion, noise=noise)
    return {"criterion": criterion, "candidates": candidates, "picks": [_pick(pick) for pick in picks]}


def _candidates(setup: Setup, point: Point, candidates: str) -> list[Candidate]:
    from springopt.analysis.candidates import candidates_of, generated
    from springopt.scene import load_scene

    if candidates == "generated":
        return generated(setup, setup.encoding.decode(point.numbers))
    if candidates == "test":
        return candidates_of(setup.scene, setup, test_alone=True)
    return candidates_of(load_scene(candidates), setup, test_alone=False)


def _pick(pick: Pick) -> dict[str, Any]:
    """What a pick brings; the largest standard error is that of the springs that are identified with it."""
    finite = [error for error in pick.standard_errors.tolist() if isfinite(error)]
    return asdict(pick.score) | {
        "identified": len(finite),
        "largest_standard_error": max(finite, default=None),
        "parameter_errors": [error if isfinite(error) else None for error in pick.parameter_errors.tolist()],
        "table": pick.candidate.table,
        "scores": [asdict(score) for score in pick.scores],
    }


def print_design(answer: dict[str, Any]) -> None:
    """A table of the picks, and those that were made here as a scene states them."""
    from springopt.report.tables import design_table

    print_table(design_table(answer["criterion"], answer["picks"]))
    tables = [pick["table"] for pick in answer["picks"] if pick["table"] is not None]
    if tables:
        click.echo("As a scene states them:")
    for table in tables:
        click.echo(f"  {_toml(table)},")


def _toml(value: Any) -> str:
    """A value as TOML; tables on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
    return json.dumps(value)
