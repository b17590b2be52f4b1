"""Where to spend: the errors of the scene's own settings beside each other, on one scale."""

from __future__ import annotations

from springopt.tradeoff.measure import Measured, Tradeoff
from springopt.tradeoff.point import Point

#: What is below this share of the largest error can't be seen beside it.
UNSEEN = 0.01
#: A setting that saves less than this share of the time is not worth a sentence.
WORTH = 0.1
#: A share of the displacements that nobody misses.
NOTHING = 1e-6


def advise(tradeoff: Tradeoff) -> list[str]:
    """Sentences, the most important first; none where the scene's own settings have no errors on one scale.

    Axes without grades have no errors of their own, but what they save may be told.
    """
    found = [(each, each.stated) for each in tradeoff.measured if each.axis.is_part]
    whole = [(each, point.error.value, point) for each, point in found if point is not None and point.error is not None]
    if len(whole) < 2:
        return []
    stated = sorted((entry for entry in whole if entry[0].axis.is_graded), key=lambda entry: -entry[1])
    if not stated:
        return []
    errors = ", ".join(f"{error:.2g} ({each.axis.name})" for each, error, _ in stated)
    largest, most, own = stated[0]
    said = [f"As the scene states it, positions are off by {errors} of the displacements."]
    if most < NOTHING and len(stated) > 1:
        return [*said, "That is nothing to spend on."]
    price = f", {largest.price.said}" if largest.price else ""
    if len(stated) > 1:
        said.append(f"The largest part is that of the {largest.axis.name}: spend there{price}.")
    if own.numbers.get("fit_is_cut"):
        # What is unseen beside such an error may well be seen beside the model's own.
        return [*said, "But the time ended its fit, so that this may be the fit's error: give more --seconds to see."]
    others = [entry for entry in whole if entry[0] is not largest]
    said += [sentence for each, _, point in others if (sentence := _saving(each, point, most))]
    return said


def _saving(measured: Measured, stated: Point, most: float) -> str | None:
    """A cheaper setting of an axis whose error would still not be seen beside the largest."""
    wanted = [
        p
        for p in measured.points
        if not p.is_apart and p.is_good and p.error is not None and p.error.high <= UNSEEN * most
    ]
    cheapest = min(wanted, key=lambda point: point.processor_seconds.value, default=None)
    if cheapest is None or cheapest is stated:
        return None
    share = cheapest.processor_seconds.value / stated.processor_seconds.value
    if share > 1.0 - WORTH:
        return None
    return (
        f"{measured.axis.name}: {measured.call(cheapest)} would do (its error is below {UNSEEN:.0%} of that) "
        f"and takes {share:.2g} of the time."
    )
