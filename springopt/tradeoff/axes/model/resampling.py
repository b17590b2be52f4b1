"""The scene of a grid on more nodes or fewer: the same body, held, pushed and moved as before."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from springopt.checks import Floats, Integers
from springopt.errors import SceneError
from springopt.lattice import SpringLattice
from springopt.scene import Scene
from springopt.scene.effect_tables import EffectTable
from springopt.scene.lattice_tables import GridTable
from springopt.scene.selection import select_nodes

#: Effects whose options mean the same on any lattice, where none of them is a list; directions may be.
BY_VOLUME = ("gravity", "inertia", "damping", "volume", "prestress", "stiffening", "exponential", "tension-only")
DIRECTIONS = ("acceleration",)


def why_fixed(scene: Scene) -> str | None:
    """Why a scene can't be on other nodes, in words that follow "because"; None if it can."""
    if not isinstance(scene.lattice, GridTable):
        return "its lattice is no grid"
    return why_springs_stay(scene)


def why_springs_stay(scene: Scene) -> str | None:
    """Why a scene can't have other springs, in words that follow "because"; None if it can."""
    fixed = next((effect.kind for effect in scene.effects if not _is_by_volume(effect)), None)
    return None if fixed is None else f"its effect {fixed} is stated for these nodes and springs, one by one"


def resampled(scene: Scene, cells: Sequence[int]) -> Scene:
    """The scene of a grid with so many cells along each axis.

    The spacing is such that the body stays the same. Sides are those of the new lattice, and a force on each node of a
    side becomes the same total, spread evenly as the scene has it. A node that is named is the one in the same place; a
    force at a place without a node is shared by the corners of the cell around it, as a finite element would, so that
    total and moment stay. Bounds of the stiffness go with the spacing to the power d - 2, as the stiffness of the same
    material does. The reference is stated as before, and is another one on other nodes.

    Raises:
        SceneError: where a node without its like is held or moved.
    """
    assert isinstance(scene.lattice, GridTable)
    cells = tuple(int(count) for count in cells)
    transfer = Transfer(scene.lattice, cells)
    tables = json.loads(scene.to_json())
    spacing = (transfer.lengths / cells).tolist()
    tables["lattice"] |= {"grid": [count + 1 for count in cells], "spacing": spacing}
    for role in ("train", "test"):
        tables["load_cases"][role] = [_case(transfer, case) for case in tables["load_cases"][role]]
    factor = stiffness_factor(scene, cells)
    for bound in ("lower", "upper", "threshold", "stiffness"):
        if bound in tables["encoding"]:
            tables["encoding"][bound] = (factor * np.array(tables["encoding"][bound])).tolist()
    return Scene.from_json(json.dumps(tables))


def stiffness_factor(scene: Scene, cells: Sequence[int]) -> float:
    """How much stiffer springs of the same material are on so many cells along each axis: 1 in 2D."""
    assert isinstance(scene.lattice, GridTable)
    ratio = (np.array(scene.lattice.grid) - 1) / np.array(cells)
    return float(np.prod(ratio) ** ((len(ratio) - 2) / len(ratio)))


@dataclass(frozen=True, eq=False)
class Transfer:
    """From the nodes of one grid to those of another one of the same body."""

    table: GridTable
    cells: tuple[int, ...]  #: of the other one along each axis

    @property
    def lattice(self) -> SpringLattice:
        return self.table.build()

    @property
    def lengths(self) -> Floats:
        """Of the body along each axis [length], shape (d,)."""
        return (self._counts - 1) * np.broadcast_to(self.table.spacing, self._counts.shape)

    def place(self, node: int) -> tuple[Integers, Integers]:
        """Where a node is among the other ones, as steps along each axis and what is left, in old cells, (d,) each."""
        index = np.array(np.unravel_index(node, self._counts[::-1])[::-1])
        whole, left = np.divmod(index * np.array(self.cells), self._counts - 1)
        return whole, left

    def same(self, node: int) -> int | None:
        """The node in the same place; None where there is none."""
        whole, left = self.place(node)
        return None if left.any() else self._number(whole)

    def around(self, node: int) -> Iterator[tuple[int, float]]:
        """The corners of the cell around a node, and their shares of what is there: one where they are the same."""
        whole, left = self.place(node)
        shares = left / (self._counts - 1)
        for corner in product((0, 1), repeat=len(whole)):
            share = float(np.prod(np.where(corner, shares, 1.0 - shares)))
            if share > 0.0:
                yield self._number(whole + corner), share

    @property
    def _counts(self) -> Integers:
        return np.array(self.table.grid)

    def _number(self, steps: Integers) -> int:
        return int(np.ravel_multi_index(tuple(steps[::-1]), tuple(np.array(self.cells[::-1]) + 1)))


def parts(push: dict[str, Any], lattice: SpringLattice) -> tuple[list[str], Floats, list[int], Floats]:
    """A push taken apart: sides and the total on them (d,), nodes beside them and the force on each (d,)."""
    sides = [name for name in push["on"] if isinstance(name, str)]
    everything = select_nodes(lattice, push["on"])
    on_sides = select_nodes(lattice, [*sides]) if sides else np.zeros_like(everything)
    given = push.get("force")
    force = np.array(given) if given is not None else np.array(push["total"]) / everything.sum()
    return sides, force * on_sides.sum(), np.flatnonzero(everything & ~on_sides).tolist(), force


def _case(transfer: Transfer, case: dict[str, Any]) -> dict[str, Any]:
    pushes = [new for push in case["push"] for new in _pushes(transfer, push)]
    fixed = {key: [_fixed(transfer, case, entry) for entry in case[key]] for key in ("hold", "move")}
    return case | fixed | {"push": pushes}


def _pushes(transfer: Transfer, push: dict[str, Any]) -> Iterator[dict[str, Any]]:
    sides, total, nodes, force = parts(push, transfer.lattice)
    if sides:
        yield {"on": sides, "total": total.tolist()}
    for node in nodes:
        for corner, share in transfer.around(node):
            yield {"on": [corner], "force": (share * force).tolist()}


def _fixed(transfer: Transfer, case: dict[str, Any], entry: dict[str, Any]) -> dict[str, Any]:
    names = [name if isinstance(name, str) else transfer.same(name) for name in entry["on"]]
    if None in names:
        shape = " x ".join(str(count + 1) for count in transfer.cells)
        raise SceneError(
            f"load case {case['name']!r} holds node {entry['on'][names.index(None)]}, and a grid of {shape} nodes has "
            "none in that place; hold a side."
        )
    return entry | {"on": names}


def _is_by_volume(effect: EffectTable) -> bool:
    options = {name: value for name, value in effect.options.items() if name not in DIRECTIONS}
    # What is given to each node or spring alike would grow with their number.
    is_each = options.get("mass") is not None or bool(options.get("nodes"))
    has_lists = any(isinstance(value, list | tuple) for value in options.values())
    return effect.kind in BY_VOLUME and not is_each and not has_lists
