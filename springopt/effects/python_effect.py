"""The base of an effect in plain NumPy: slow, but all that a first try needs."""

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np

from springopt.checks import Floats, Integers
from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.effects.lanes import LANE_COUNT
from springopt.lattice import SpringLattice

_POINTER = ctypes.POINTER(ctypes.c_double)
_INTEGERS = ctypes.POINTER(ctypes.c_int64)
#: KERNEL_SIGNATURE of `effect`, as ctypes says it.
_SIGNATURE = ctypes.CFUNCTYPE(
    None, ctypes.c_int64, ctypes.c_int64, _POINTER, _INTEGERS, _POINTER, _POINTER, _POINTER, _INTEGERS, *[_POINTER] * 5
)


class PythonEffect(Effect, ABC):
    """A potential as a function of NumPy arrays, called for eight equilibria at once; a subclass is a dataclass.

    Its options are the subclass's; `parameters` names those that may be fitted.
    """

    @abstractmethod
    def pairs(self, lattice: SpringLattice) -> Integers:
        """The nodes (i, j) that it couples, each pair once, a node with itself too, shape (q, 2)."""

    @abstractmethod
    def evaluate(
        self, lattice: SpringLattice, displacements: Floats, *, stiffness: Floats, values: Mapping[str, Floats]
    ) -> tuple[Floats, Floats, Floats]:
        """(energy (8,), internal forces (8, n, d), blocks dF_i / du_j of the pairs (8, q, d, d)).

        At displacements [length] (8, n, d), for the stiffness of the springs (8, s) and its parameters (8, k) by name.
        Threads may call it at the same time.
        """

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        pairs = np.asarray(self.pairs(lattice), dtype=np.int64).reshape(-1, 2)
        return Kernel(_Callback(self, lattice, len(pairs)), pairs, is_compiled=False)


class _Callback:
    """The C function that calls an effect back; it lives as long as the kernel does. Changed only by a failure."""

    def __init__(self, effect: PythonEffect, lattice: SpringLattice, pair_count: int) -> None:
        self._effect, self._lattice, self._pair_count = effect, lattice, pair_count
        self._sizes = {name: len(default) for name, default in effect.parameters(lattice).items()}
        self._function = _SIGNATURE(self._add)
        self.failure: BaseException | None = None  #: the first one inside the effect, for `Kernel.raise_failure`

    def __reduce__(self) -> tuple[Any, ...]:
        return _Callback, (self._effect, self._lattice, self._pair_count)

    @property
    def address(self) -> int:
        address = ctypes.cast(self._function, ctypes.c_void_p).value
        assert address is not None
        return address

    def _add(self, d: int, n: int, *pointers: Any) -> None:
        _, _, _, stiffness, values, places, displacements, _, forces, tangent, energy = pointers
        total = _lanes(energy, 1)[0]
        try:
            if self.failure is None:
                inside = (_lanes(stiffness, self._lattice.spring_count), _lanes(values, sum(self._sizes.values())))
                e, f, blocks = self._evaluate(_lanes(displacements, n * d), *inside)
                total += e
                _lanes(forces, n * d)[:] += f.reshape(LANE_COUNT, n * d).T
                self._add_blocks(blocks, places, tangent, d)
        except BaseException as failure:  # also Ctrl-C: compiled callers let nothing through
            self.failure = failure
        if self.failure is not None:
            total[:] = np.nan  # no search accepts that

    def _evaluate(self, displacements: Floats, stiffness: Floats, values: Floats) -> tuple[Floats, Floats, Floats]:
        shape = self._lattice.nodes.shape
        ends = np.cumsum(list(self._sizes.values()))
        by_name = dict(zip(self._sizes, np.split(values.T, ends[:-1], axis=1), strict=True)) if len(ends) else {}
        u = displacements.T.reshape(LANE_COUNT, *shape)
        e, f, blocks = self._effect.evaluate(self._lattice, u, stiffness=stiffness.T, values=by_name)
        wanted = ((LANE_COUNT,), (LANE_COUNT, *shape), (LANE_COUNT, self._pair_count, shape[1], shape[1]))
        for name, array, want in zip(("energy", "forces", "blocks"), (e, f, blocks), wanted, strict=True):
            if np.shape(array) != want:
                kind = type(self._effect).__name__
                raise ValueError(f"evaluate of {kind} must give {name} of shape {want}, not {np.shape(array)}.")
        return e, f, blocks

    def _add_blocks(self, blocks: Floats, places: Any, tangent: Any, d: int) -> None:
        if not self._pair_count:
            return
        where = np.ctypeslib.as_array(places, (self._pair_count,))
        exists, is_turned = where >= 0, (where & 1).astype(bool)
        blocks = np.where(is_turned[:, None, None], blocks.swapaxes(2, 3), blocks)[:, exists]
        first = where[exists] >> 1
        entries = first[:, None] + np.arange(d * d)
        rows = _lanes(tangent, int(entries.max(initial=-1)) + 1)
        np.add.at(rows, entries.ravel(), blocks.reshape(LANE_COUNT, -1).T)


def _lanes(pointer: Any, count: int) -> Floats:
    """The lane blocks behind a pointer, shape (count, 8)."""
    return np.ctypeslib.as_array(pointer, (count, LANE_COUNT)) if count else np.zeros((0, LANE_COUNT))
