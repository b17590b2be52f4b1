"""NaN, infinity, wrong signs and wrong shapes: refused before any solve, by a sentence that names the entry."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import springopt as so
from ladder.rung import RIGHTLY_REFUSED, SILENTLY_WRONG, WRONGLY_REFUSED, Verdict

FAMILY = "bad input"
POINTS = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]
SPRINGS = [[0, 1], [0, 2], [1, 3], [2, 3], [0, 3], [1, 2]]
BAD_NUMBERS = (np.nan, np.inf, -np.inf)


@dataclass(frozen=True)
class BadInput:
    """Something that no solver should take."""

    name: str
    attempt: Callable[[], object]
    entry: str  #: what the sentence must name

    def verdict(self) -> Verdict:
        try:
            self.attempt()
        except so.UserError as refusal:
            reading = RIGHTLY_REFUSED if self.entry in str(refusal) else WRONGLY_REFUSED
            return Verdict(FAMILY, self.name, False, reading, str(refusal))
        except Exception as fault:
            return Verdict(FAMILY, self.name, False, WRONGLY_REFUSED, repr(fault))
        return Verdict(FAMILY, self.name, False, SILENTLY_WRONG, "taken")


def solve(
    *, points=POINTS, springs=SPRINGS, rest_lengths=None, stiffness=None, forces=None, prescribed=None, effects=()
):
    lattice = so.SpringLattice(points, springs, rest_lengths)
    case = so.LoadCase("load", [True, True, False, False], np.zeros((4, 2)) if forces is None else forces, prescribed)
    return so.Model(lattice, effects).solve(np.ones(6) if stiffness is None else stiffness, [case])


def replaced(array, index, value):
    changed = np.array(array, dtype=float)
    changed[index] = value
    return changed


def rungs():
    forces, lengths = np.zeros((4, 2)), np.ones(6)
    moved = np.full((4, 2), np.nan)
    for value in BAD_NUMBERS:
        yield BadInput(f"stiffness {value}", lambda v=value: solve(stiffness=replaced(lengths, 2, v)), "stiffness")
        yield BadInput(f"position {value}", lambda v=value: solve(points=replaced(POINTS, (3, 0), v)), "nodes[3, 0]")
        yield BadInput(
            f"rest length {value}", lambda v=value: solve(rest_lengths=replaced(lengths, 0, v)), "rest_lengths[0]"
        )
        yield BadInput(f"force {value}", lambda v=value: solve(forces=replaced(forces, (3, 1), v)), "forces[3, 1]")
        yield BadInput(f"gravity {value}", lambda v=value: solve(effects=[so.Gravity((v, 0.0))]), "acceleration")
        yield BadInput(f"mass {value}", lambda v=value: solve(effects=[so.Gravity((0.0, 1.0), [1, 1, v, 1])]), "mass")
    yield BadInput("prescribed inf", lambda: solve(prescribed=replaced(moved, (0, 0), np.inf)), "prescribed")
    yield BadInput("negative stiffness", lambda: solve(stiffness=replaced(lengths, 2, -1.0)), "stiffness")
    yield BadInput("negative rest length", lambda: solve(rest_lengths=replaced(lengths, 0, -1.0)), "rest_lengths[0]")
    yield BadInput("negative mass", lambda: solve(effects=[so.Gravity((0.0, 1.0), [1, 1, -1, 1])]), "mass")
    for name, spring in (
        ("to itself", [2, 2]),
        ("to nowhere", [0, 9]),
        ("to node -1", [-1, 2]),
        ("to half a node", [0.5, 2]),
    ):
        yield BadInput(f"spring {name}", lambda s=spring: solve(springs=[s, *SPRINGS[1:]]), "springs")
    yield BadInput("too few stiffnesses", lambda: solve(stiffness=np.ones(5)), "stiffness")
    yield BadInput("forces for another lattice", lambda: solve(forces=np.zeros((4, 3))), "forces")
