"""Prestress: springs whose rest length is not their distance at rest."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.checks import Booleans, Floats, Integers, floats, require_nonnegative, require_shape
from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.effects.spring_law import law_kernel
from springopt.errors import UserError, did_you_mean
from springopt.lattice import SpringLattice

#: Which springs a class has; a spring is straight if it is parallel to an axis.
CLASSES: dict[str, Callable[[SpringLattice], Booleans]] = {
    "straight": lambda lattice: lattice.straight,
    "diagonal": lambda lattice: ~lattice.straight,
    "boundary straight": lambda lattice: lattice.straight & lattice.boundary,
    "inner straight": lambda lattice: lattice.straight & ~lattice.boundary,
}


@dataclass(frozen=True)
class Prestress(Effect):
    """The rest lengths, scaled: below 1 the springs pull, above 1 they push. Data, unless "scale" is fitted."""

    name = "prestress"
    scales_with_stiffness = True
    scale: float | Sequence[float] | None = None  #: [1], one number for all springs or one for each
    #: [1], in place of it: one number for each class, of "straight", "diagonal", "boundary straight" and "inner
    #: straight"; the springs of no class keep their rest length.
    classes: Mapping[str, float] | None = None

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        if (self.scale is None) == (self.classes is None):
            raise UserError("prestress is given by one of scale and classes; name one of them, and not both.")
        if self.classes is not None:
            return {"scale": require_nonnegative("classes", floats("classes", list(self.classes.values())))}
        assert self.scale is not None
        scale = require_nonnegative("scale", floats("scale", self.scale))
        return {"scale": require_shape("scale", scale, (lattice.spring_count,)) if scale.ndim else scale[None]}

    def rest_lengths(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Floats | None:
        if fitted:
            return None
        scales = np.append(self.parameters(lattice)["scale"], 1.0)  # the last is that of springs of no class
        return lattice.rest_lengths * scales[self._owners(lattice)]

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        return law_kernel(_kernel(), lattice, self._owners(lattice)) if fitted else None

    def _owners(self, lattice: SpringLattice) -> Integers:
        """Which number of the scale is each spring's, -1 for none, shape (s,)."""
        if self.classes is not None:
            return _class_numbers(lattice, list(self.classes))
        assert self.scale is not None, "or there would be no parameters"
        return np.arange(lattice.spring_count) * np.ndim(self.scale)


def _class_numbers(lattice: SpringLattice, names: Sequence[str]) -> Integers:
    owners = np.full(lattice.spring_count, -1, dtype=np.int64)
    for number, name in enumerate(names):
        if name not in CLASSES:
            hint = did_you_mean(str(name), CLASSES)
            raise UserError(f"a class of springs to prestress is one of {', '.join(CLASSES)}, not {name!r}.{hint}")
        belongs = CLASSES[name](lattice)
        twice = owners[belongs & (owners >= 0)]
        if len(twice):
            raise UserError(f"{names[twice[0]]} and {name} have springs in common; prestress each spring by one class.")
        owners[belongs] = number
    return owners


def _kernel() -> Any:
    from springopt.effects.prestress_kernel import add_prestress

    return add_prestress
