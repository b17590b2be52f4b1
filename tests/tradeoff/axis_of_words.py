"""An axis without physics: settings that are as accurate and as slow as they are told to be."""

import numpy as np

from springopt.tradeoff.point import Axis, Findings, Point


def point(name, error, seconds, *, series="s", is_stated=False):
    """Six repeats, all the same."""
    return Point(series, name, np.atleast_1d(error), np.full(6, seconds), np.full(6, seconds), is_stated=is_stated)


def axis_of(points, *, again=None, name="words", missing=None, **options):
    """Finds these points, and with another seed than 0 those of `again`."""
    asked = []

    def measure(setup, request):
        asked.append(request)
        found = points if request.seed == 0 or again is None else again
        wanted = [each for each in found if request.wants(each.series, each.name)]
        return Findings(wanted, notes=["A note."], numbers={"words": 1})

    axis = Axis(name, "Words", "the error", "one word", lambda scene: missing, measure, **options)
    return axis, asked
