"""Methods and scenes without a gap: what ranks over scenes can be taken from."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass
from heapq import nlargest

MOST = 100  # sets of scenes that are gone on from


@dataclass(frozen=True)
class Block:
    """Methods that have runs on all of these scenes, and why the others are not among them."""

    methods: list[str]
    scenes: list[str]
    methods_left_out: dict[str, str]  #: method -> why
    scenes_left_out: dict[str, str]  #: scene -> why


def complete_block(served: Mapping[str, Set[str]], words: Mapping[tuple[str, str], str]) -> Block:
    """The methods and scenes, each method on each scene, of which there are the most pairs; of as many, more scenes.

    Of very many different sets of scenes the best may be missed, and one near it is taken.

    Args:
        served: method -> the scenes that it has runs on.
        words: (method, scene) -> why there is none, in a word.
    """
    best = max(_candidates(served), key=lambda scenes: _size(served, scenes))
    methods = sorted(method for method, its in served.items() if its >= best)
    everything = frozenset[str]().union(*served.values())
    methods_left_out = {}
    for method in sorted(set(served) - set(methods)):
        missing = sorted(best - served[method])
        methods_left_out[method] = f"not on {_listed({scene: words.get((method, scene)) for scene in missing})}"
    scenes_left_out = {}
    for scene in sorted(everything - best):
        absent = [method for method in methods if scene not in served[method]]
        scenes_left_out[scene] = f"no runs of {_listed({method: words.get((method, scene)) for method in absent})}"
    return Block(methods, sorted(best), methods_left_out, scenes_left_out)


def _candidates(served: Mapping[str, Set[str]]) -> set[frozenset[str]]:
    """Sets of scenes that some methods have in common.

    All of them where they are few; else those that come by intersecting the best so far, because their number may
    double with each method.
    """
    its = {frozenset(scenes) for scenes in served.values() if scenes}
    common = newest = its
    while newest:
        newest = {first & second for first in newest for second in its} - common
        newest = set(nlargest(MOST, newest, key=lambda scenes: _size(served, scenes)))
        common = common | newest
    return common - {frozenset()}


def _size(served: Mapping[str, Set[str]], scenes: Set[str]) -> tuple[int, int, list[str]]:
    """Pairs of method and scene; a single method makes none. The names decide between equals."""
    methods = sum(its >= scenes for its in served.values())
    return methods * len(scenes) if methods > 1 else 0, len(scenes), sorted(scenes)


def _listed(reasons: Mapping[str, str | None]) -> str:
    """Names, those with one reason together: a, b (real), c (memory)."""
    names: dict[str | None, list[str]] = {}
    for name, word in reasons.items():
        names.setdefault(word, []).append(name)
    return ", ".join(", ".join(its) + (f" ({word})" if word else "") for word, its in names.items())
