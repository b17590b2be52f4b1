"""Checks of any kernel: where it writes, that lanes are alone, and that its numbers are finite."""

from __future__ import annotations

import numpy as np

from springopt.effects.effect import Kernel
from springopt.effects.lanes import LANE_COUNT
from springopt.lattice import SpringLattice
from springopt.testing.effect_trial import (
    EffectSubject,
    kernels,
)
from springopt.testing.effect_verdicts import (
    largest,
    made_ready,
    same_answers,
)
from springopt.testing.kernel_calls import Answers, Failed, Stray, call
from springopt.testing.verdict import NotJudged, require


def check_keeps_to_its_places(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """A kernel adds to forces, energy and the blocks of the pairs that it declared, where their places say, alone."""
    ready = made_ready(effect)
    for trial in kernels(ready, lattice):
        _require_legal(trial.what, trial.kernel, trial.lattice)
        d, q = trial.lattice.dimension, len(trial.kernel.pairs)
        size = d * d
        stored = 2 * size * np.arange(q, dtype=np.int64)
        off = trial.kernel.pairs[:, 0] != trial.kernel.pairs[:, 1]
        try:
            plain = call(trial.kernel, trial.lattice, trial.states, stored, size * q)
            later = call(trial.kernel, trial.lattice, trial.states, stored, size * q, before=0.5)
            turned = call(trial.kernel, trial.lattice, trial.states, stored + off, size * q)
            dropped = call(trial.kernel, trial.lattice, trial.states, np.full(q, -1), size)
        except Failed as error:
            raise NotJudged(f"{trial.what} fails ({error}); mend that first.") from error
        except Stray as stray:
            raise AssertionError(
                f"{trial.what} {stray}; keep to the pairs that are declared, in their order, and to n d forces."
            ) from stray
        require(
            all(
                np.allclose(b - 0.5, a, rtol=0, atol=1e-9 * largest(a, 0.5)) for a, b in zip(plain, later, strict=True)
            ),
            f"{trial.what} does not add to what is there; use `add` and `add_to_block`, never `store` alone.",
        )
        blocks, transposed = (tangent.reshape(q, d, d, LANE_COUNT) for tangent in (plain[2], turned[2]))
        blocks = np.where(off[:, None, None, None], blocks.swapaxes(1, 2), blocks)
        require(
            bool(np.array_equal(blocks, transposed, equal_nan=True)) and not dropped[2].any(),
            f"{trial.what} does not put its blocks where their places say: -1 drops a block, an odd place transposes "
            "it; let `add_to_block` do that.",
        )


def check_lanes_are_independent(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """An answer is the same to the bit whatever states it is computed beside."""
    ready = made_ready(effect)
    for trial in kernels(ready, lattice):
        together = trial.answers(trial.states)
        count = len(together.energy)
        order = (np.arange(count) + 3) % count
        moved = trial.answers(trial.states.take(order))
        alone = [trial.answers(trial.states.take([lane])) for lane in range(count)]
        are_alike = same_answers(Answers(*(array[order] for array in together)), moved) and same_answers(
            together, Answers(*(np.concatenate(arrays) for arrays in zip(*alone, strict=True)))
        )
        require(
            are_alike,
            f"{trial.what} answers otherwise beside other states; let every lane do the same whatever the others hold.",
        )


def check_is_finite_everywhere(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """No NaN and no infinity at rest, where all nodes are at one place, or where the body is inside out."""
    ready = made_ready(effect)
    for trial in kernels(ready, lattice):
        nodes = trial.lattice.nodes
        mirrored = nodes * ([-1.0] + [1.0] * (nodes.shape[1] - 1))
        shapes = {"at rest": nodes, "where all nodes are at one place": np.zeros_like(nodes), "inside out": mirrored}
        for where, positions in shapes.items():
            answer = trial.at(0, displacements=(positions - nodes).reshape(1, -1))
            require(
                all(bool(np.isfinite(array).all()) for array in answer),
                f"{trial.what} is not finite {where}; guard its quotients and roots, as an equilibrium is searched "
                "through any state.",
            )


def _require_legal(what: str, kernel: Kernel, lattice: SpringLattice) -> None:
    pairs = kernel.pairs
    for name, array, kind in (
        ("pairs", pairs, np.int64),
        ("integers", kernel.integers, np.int64),
        ("numbers", kernel.numbers, np.float64),
    ):
        require(
            isinstance(array, np.ndarray) and array.dtype == kind and array.flags.c_contiguous,
            f"the {name} of {what} should be a contiguous array of {kind.__name__}, which a pointer leads to.",
        )
    legal = pairs.ndim == 2 and pairs.shape[1] == 2 and bool(np.all((pairs >= 0) & (pairs < lattice.node_count)))
    require(legal, f"the pairs of {what} should be nodes of the lattice, shape (q, 2).")
