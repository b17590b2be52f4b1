"""Scenes of other readings of the paper, made from the bundled ones as `extends` would."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

from springopt.analysis.floor import compute_floor
from springopt.reproduction.paper import COSTS
from springopt.scene import Scene, load_scene
from springopt.scene.load import merge

Loads = dict[str, dict[str, list[float]]]  # by load case, the loaded sides and the force on each of their nodes

#: Twelve load cases with the left side held in all of them.
CLAMPED: Loads = {
    "pull right": {"right": [0.31, 0.0]},
    "push right": {"right": [-0.31, 0.0]},
    "shear right up": {"right": [0.0, 0.155]},
    "shear right down": {"right": [0.0, -0.155]},
    "pull top": {"top": [0.0, 0.155]},
    "shear top": {"top": [0.155, 0.0]},
    "shear top back": {"top": [-0.155, 0.0]},
    "pull bottom": {"bottom": [0.0, -0.155]},
    "shear bottom": {"bottom": [0.155, 0.0]},
    "shear bottom back": {"bottom": [-0.155, 0.0]},
    "stretch": {"top": [0.0, 0.155], "bottom": [0.0, -0.155]},
    "bend": {"top": [0.155, 0.0], "bottom": [-0.155, 0.0]},
}
#: Six of the same kind in 3D.
CLAMPED_3D: Loads = {
    "stretch": {"right": [1.0, 0.0, 0.0]},
    "shear along y": {"right": [0.0, 0.4, 0.0]},
    "shear along z": {"right": [0.0, 0.0, 0.4]},
    "drag top": {"top": [0.4, 0.0, 0.0]},
    "lift top": {"top": [0.0, 0.0, 0.4]},
    "press back": {"back": [0.0, 0.4, 0.4]},
}


def variant(base: str, name: str, title: str, tables: dict[str, Any]) -> Scene:
    """A bundled scene under another name, with these tables merged over its own."""
    inherited = json.loads(load_scene(base).to_json())
    return Scene.from_json(json.dumps(merge(inherited, tables | {"name": name, "title": title})))


def clamped(base: str) -> Scene:
    """A bundled scene with its left side held throughout, in training and test."""
    scene = load_scene(base)
    loads = CLAMPED if scene.lattice.build().dimension == 2 else CLAMPED_3D
    test = json.loads(scene.to_json())["load_cases"]["test"]
    held = [case for case in test if any("left" in hold["on"] for hold in case["hold"])]
    train = [
        {"name": name, "hold": "left", "push": [{"on": side, "force": force} for side, force in pushes.items()]}
        for name, pushes in loads.items()
    ]
    title = f"As {base}, with the left side held in every load case"
    return variant(base, f"{base}-clamped", title, {"load_cases": {"train": train, "test": held}})


def limited(scene: Scene, limitation: str) -> Scene:
    """A scene with one stiffness for each class of springs, as in Table 1; "unrestricted" is the scene itself."""
    if limitation == "unrestricted":
        return scene
    tables = json.loads(scene.to_json()) | {"name": f"{scene.name}-{limitation}"}
    tables["encoding"] = {"kind": limitation, "lower": 0.0, "upper": 10.0}
    tables["budget"] = {"evaluations": 2_000}
    return Scene.from_json(json.dumps(tables))


def scaled(scene: Scene, name: str, factor: float) -> Scene:
    """A scene with all its loads times a factor."""
    loads = scene.load_cases.model_copy(update={"scale": factor * scene.load_cases.scale})
    return scene.model_copy(update={"name": name, "load_cases": loads})


@cache
def calibrated(name: str) -> Scene:
    """A bundled or clamped scene with its loads at which the homogeneous cost is that of Table 1.

    The loads of the paper are not known; this is the one number of its own that says how large they were. By the secant
    rule, on the lowest homogeneous cost, which is smooth in the factor.
    """
    scene = clamped(name.removesuffix("-clamped")) if name.endswith("-clamped") else load_scene(name)
    low, high = 1.0, 1.5
    excess = {factor: _homogeneous_excess(scene, factor) for factor in (low, high)}
    while abs(excess[high]) > 1e-5:
        low, high = high, high - excess[high] * (high - low) / (excess[high] - excess[low])
        excess[high] = _homogeneous_excess(scene, high)
    return scaled(scene, f"{name}-calibrated", round(high, 4))


def _homogeneous_excess(scene: Scene, factor: float) -> float:
    homogeneous = limited(scaled(scene, scene.name, factor), "homogeneous")
    return compute_floor(homogeneous.build(), starts=1).value - COSTS["homogeneous"].value
