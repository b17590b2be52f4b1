"""A tradeoff as plain numbers and words, for JSON, tables and pages."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from springopt.origin import processor
from springopt.scene import Scene
from springopt.tradeoff.advice import advise
from springopt.tradeoff.cheapest import Answer
from springopt.tradeoff.front import Price
from springopt.tradeoff.measure import Measured, Tradeoff
from springopt.tradeoff.point import Point


def document(scene: Scene, tradeoff: Tradeoff, answers: Sequence[Answer] = ()) -> dict[str, Any]:
    """Everything, no number of it infinite."""
    return {
        "scene": scene.name,
        "title": scene.title,
        "machine": {"processor": processor(), "cores": os.cpu_count(), "springopt": version("springopt")},
        "axes": [_axis(measured) for measured in tradeoff.measured],
        "missing": dict(tradeoff.missing),
        "where_to_spend": advise(tradeoff),
        "answers": [_answer(answer) for answer in answers],
    }


def _axis(measured: Measured) -> dict[str, Any]:
    axis, price, front = measured.axis, measured.price, measured.front
    return {
        "axis": axis.name,
        "title": axis.title,
        "error": axis.error,
        "time": axis.time,
        "second_time": axis.second_time,
        "shown": list(axis.shown),
        "is_graded": axis.is_graded,
        "points": [_point(point) | {"on_front": point in front} for point in measured.points],
        "price_of_a_digit": _price(price),
        "prices_of_a_digit": {series: _price(price) for series, price in measured.prices.items()},
        "marks": dict(measured.findings.marks),
        "numbers": _finite(dict(measured.findings.numbers)),
        "notes": list(measured.findings.notes),
        "seconds": measured.seconds,
    }


def _point(point: Point) -> dict[str, Any]:
    return {
        "series": point.series,
        "setting": point.name,
        "states": dict(point.states),
        "is_stated": point.is_stated,
        "is_apart": point.is_apart,
        "error": None if point.error is None else asdict(point.error),
        "answers": len(point.errors),
        "failures": point.failures,
        "why": point.why,
        "processor_seconds": asdict(point.processor_seconds),
        "wall_seconds": asdict(point.wall_seconds),
        "second_seconds": None if point.second_time is None else asdict(point.second_time),
        "warm_up_seconds": point.warm_up,
        "repeats": len(point.processor),
        "numbers": _finite(dict(point.numbers)),
    }


def _price(price: Price | None) -> dict[str, Any] | None:
    return None if price is None else asdict(price) | {"said": price.said}


def _answer(answer: Answer) -> dict[str, Any]:
    return {
        "axis": answer.measured.axis.name,
        "target_error": answer.target_error,
        "time": answer.time,
        "verified": None if answer.verified is None else _point(answer.verified),
        "refuted": [_point(point) for point in answer.refuted],
        "closest": None if answer.closest is None else _point(answer.closest),
        "said": answer.said,
    }


def _finite(value: Any) -> Any:
    """JSON has no infinity."""
    if isinstance(value, dict):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
