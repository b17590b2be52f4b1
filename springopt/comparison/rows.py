"""A comparison as rows of one table, for spreadsheets and other people's statistics; all but its curves."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from springopt.comparison.comparison import Comparison
from springopt.comparison.failure import FAILED
from springopt.comparison.running_time import Estimate
from springopt.comparison.scene_comparison import MethodOnScene, SceneComparison, Spread
from springopt.errors import UserError


class Row(NamedTuple):
    """One number, or one word; what does not apply is None."""

    scene: str | None
    method: str | None
    other: str | None  #: the second method of a pair
    quantity: str
    target: int | None  #: 10 to the minus this of the way
    unit: str | None
    value: float | None
    low: float | None = None  #: lower quartile, or lower end of the 95 % interval
    high: float | None = None
    word: str | None = None


def write_csv(comparison: Comparison, path: Path) -> None:
    """Writes the rows under their headings."""
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(Row._fields)
            writer.writerows(rows(comparison))
    except OSError as error:
        raise UserError(f"{path} can't be written ({error.strerror}); name another file.") from None


def rows(comparison: Comparison) -> Iterator[Row]:
    """Scene by scene, then over the scenes."""
    for scene in comparison.scenes:
        yield from _scene_rows(scene)
    for refusal in comparison.refusals:
        what = "failed" if refusal.word == FAILED else "refused"
        yield Row(refusal.scene, refusal.method, None, what, None, None, None, word=refusal.word)
    yield from _ranking_rows(comparison)


def _scene_rows(scene: SceneComparison) -> Iterator[Row]:
    way = scene.way
    yield Row(scene.scene, None, None, "start", None, scene.minimize, way.start)
    sure = "proven" if way.proven else "best known"
    yield Row(scene.scene, None, None, "floor", None, scene.minimize, way.floor, word=sure)
    for each in scene.methods:
        yield from _method_rows(scene, each)
    for pair in scene.pairs:
        names = scene.scene, pair.first, pair.second
        yield _estimate(*names, "probability of ending lower", None, None, pair.lower)._replace(word=pair.ends_lower)
        if pair.p is not None:
            yield Row(*names, "p", None, None, pair.p, word=pair.test)
            yield Row(*names, "p after Holm", None, None, pair.p_holm, word=pair.test)


def _method_rows(scene: SceneComparison, each: MethodOnScene) -> Iterator[Row]:
    names = scene.scene, each.method, None
    word = "all the same" if each.deterministic else None
    yield Row(*names, "runs", None, None, each.runs, word=word)
    yield Row(*names, "failed runs", None, None, each.failed)
    spreads = {"final value": each.value, "gap": each.gap, "training error": each.train_error}
    for quantity, spread in {**spreads, **({"test error": each.test_error} if each.test_error else {})}.items():
        yield _spread(*names, quantity, spread)
    for target, reached in each.targets.items():
        yield _estimate(*names, "success rate", target, None, reached.rate)
        for unit, time in reached.running_times.items():
            yield _estimate(*names, "expected running time", target, unit, time)
    cost = each.cost
    for unit in ("evaluations", "solves", "processor_seconds"):
        yield Row(*names, "spent", None, unit, getattr(cost, unit))
    yield Row(*names, "spent in solves", None, "processor_seconds", cost.solving_seconds)
    yield Row(*names, "overhead", None, "processor_seconds", cost.overhead_seconds)


def _ranking_rows(comparison: Comparison) -> Iterator[Row]:
    ranking = comparison.ranking
    if ranking is None:
        return
    yield Row(None, None, None, "critical difference", None, None, ranking.critical_difference)
    if ranking.friedman:
        for quantity in ("chi_square", "p", "f", "p_f", "kendall_w"):
            yield Row(None, None, None, f"Friedman {quantity}", None, None, getattr(ranking.friedman, quantity))
    for method, mean in ranking.mean_ranks.items():
        yield Row(None, method, None, "mean rank", None, None, mean)
    for pair in ranking.pairs:
        yield Row(None, pair.first, pair.second, "p", None, None, pair.p, word="Wilcoxon")
        yield Row(None, pair.first, pair.second, "p after Holm", None, None, pair.p_holm, word="Wilcoxon")
        yield Row(None, pair.first, pair.second, "rank-biserial correlation", None, None, pair.rank_biserial)


def _spread(scene: str, method: str, other: str | None, quantity: str, spread: Spread) -> Row:
    quartiles = spread.lower_quartile, spread.upper_quartile
    return Row(scene, method, other, quantity, None, None, spread.median, *quartiles)


def _estimate(
    scene: str, method: str, other: str | None, quantity: str, target: int | None, unit: str | None, found: Estimate
) -> Row:
    return Row(scene, method, other, quantity, target, unit, found.value, found.low, found.high)
