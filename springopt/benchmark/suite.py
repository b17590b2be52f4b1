"""What a benchmark runs: scenes and optimizers by their names, and the quick suite."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from springopt.benchmark.job import Job
from springopt.errors import UserError, did_you_mean
from springopt.registry import installed, optimizers
from springopt.scene import Scene, bundled_scenes, load_scene

#: A small scene or two of each group: three seeds of all optimizers end within ten minutes on two cores.
QUICK_SCENES = (
    "paper-fem-2d",
    "paper-topology-2d-isotropic",
    "recovery-2d-sparse",
    "fem-2d-triangles",
    "fem-3d-hexahedra",
    "scale-72",
    "hard-column",
    "hard-mechanism-binary",
)
QUICK_SEEDS = 3
QUICK_LIMITS: Mapping[str, float] = {"evaluations": 500}


def choose_scenes(words: Sequence[str]) -> list[Scene]:
    """Scenes in the order asked for, each once; all bundled ones where nothing is asked for.

    Args:
        words: names of bundled scenes, groups of them, TOML files, or patterns of such, as `mine/*.toml`.

    Raises:
        UserError: for a word that is none of these, and for two scenes with one name.
    """
    heads = bundled_scenes()
    groups: dict[str, list[str]] = {}
    for head in heads.values():
        if head.group is not None:
            groups.setdefault(head.group, []).append(head.name)
    sources = [source for word in words for source in _sources(word, list(heads), groups)] if words else list(heads)
    scenes: dict[str, Scene] = {}
    for source in dict.fromkeys(sources):
        scene = load_scene(source)
        if scenes.setdefault(scene.name, scene) != scene:
            raise UserError(f"two of these scenes are called {scene.name}, among them {source}; rename one.")
    return list(scenes.values())


def choose_optimizers(names: Sequence[str]) -> list[str]:
    """Optimizers in the order asked for, each once; where nothing is asked for all that are installed and load."""
    if not names:
        return list(optimizers())
    known = installed()
    for name in names:
        if name not in known:
            raise UserError(
                f"there is no optimizer {name!r}; installed: {', '.join(known)}.{did_you_mean(name, known)}"
            )
    return list(dict.fromkeys(names))


def make_jobs(
    scenes: Iterable[Scene], optimizer_names: Sequence[str], seeds: int, limits: Mapping[str, float]
) -> list[Job]:
    """A job for each scene, optimizer and seed from 0 on, with the same limits."""
    texts = {scene.name: scene.to_json() for scene in scenes}
    return [
        Job(scene=text, scene_name=scene, optimizer=optimizer, seed=seed, limits=limits)
        for scene, text in texts.items()
        for optimizer in optimizer_names
        for seed in range(seeds)
    ]


def _sources(word: str, names: list[str], groups: Mapping[str, list[str]]) -> list[str | Path]:
    """What `load_scene` takes, for one word."""
    if word in names:
        return [word]
    if word in groups:
        return list(groups[word])
    if word.endswith(".toml") or os.sep in word:
        files = sorted(glob.glob(word)) or [word]
        return [Path(file) for file in files]
    raise UserError(
        f"there is no scene and no group {word!r};{did_you_mean(word, [*names, *groups])} groups: {', '.join(groups)}; "
        "`springopt list scenes` names the scenes, and a file of your own ends in .toml."
    )
