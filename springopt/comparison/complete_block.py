"""Methods and scenes without a gap: what ranks over scenes can be taken from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass


@dataclass(frozen=True)
class Block:
    """Methods that have runs on all of these scenes, and why the others are not among them."""

    methods: list[str]
    scenes: list[str]
    methods_left_out: dict[str, str]  #: method -> why
    scenes_left_out: dict[str, str]  #: scene -> why


def complete_block(served: Mapping[str, Set[str]], words: Mapping[tuple[str, str], str]) -> Block:
    """The methods and scenes, each method on each scene, of which there are the most pairs; of as many, more scenes.

    Args:
        served: method -> the scenes that it has runs on.
        words: (method, scene) -> why there is none, in a word.
    """
    best = max(_candidates(served.values()), key=lambda scenes: _size(served, scenes))
    methods = sorted(method for method, its in served.items() if its >= best)
    others = {method: sorted(best - its) for method, its in sorted(served.items()) if not its >= best}
    everything = frozenset[str]().union(*served.values())
    return Block(
        methods=methods,
        scenes=sorted(best),
        methods_left_out={method: _why(method, missing, words) for method, missing in others.items()},
        scenes_left_out={
            scene: "no runs of " + ", ".join(method for method in methods if scene not in served[method])
            for scene in sorted(everything - best)
        },
    )


def _candidates(served: Iterable[Set[str]]) -> set[frozenset[str]]:
    """All sets of scenes that some methods have in common."""
    its = {frozenset(scenes) for scenes in served if scenes}
    common = set(its)
    while len(common) < len(common := common | {first & second for first in common for second in its}):
        pass
    return common - {frozenset()}


def _size(served: Mapping[str, Set[str]], scenes: Set[str]) -> tuple[int, int, list[str]]:
    """Pairs of method and scene; a single method makes none. The names decide between equals."""
    methods = sum(its >= scenes for its in served.values())
    return methods * len(scenes) if methods > 1 else 0, len(scenes), sorted(scenes)


def _why(method: str, missing: list[str], words: Mapping[tuple[str, str], str]) -> str:
    reasons = sorted({words.get((method, scene), "no run") for scene in missing})
    return f"not on {', '.join(missing)} ({', '.join(reasons)})"
