"""Formulas for the stiffness of springs that need no search: lattice moduli, Van Gelder (1998), Maciel et al. (2003).

Each takes the material of the reference and the cells of the lattice, and asks for the value of one point.
"""

from __future__ import annotations

from abc import abstractmethod
from collections import Counter
from dataclasses import dataclass, replace
from itertools import combinations, combinations_with_replacement, permutations
from math import factorial, prod
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple, cast

import numpy as np

from springopt.checks import Booleans, Floats, Integers
from springopt.errors import NotServed, UserError
from springopt.lattice import SpringLattice
from springopt.optimizer import Optimizer
from springopt.problem import Problem

if TYPE_CHECKING:  # kernels, which are not to be imported where optimizers are only listed
    from springopt.objective import Objective
    from springopt.reference import Reference

#: Where each corner of a block lies, in VTK order.
BLOCKS: dict[str, list[tuple[int, ...]]] = {
    "quad": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "hexahedron": [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))],
}
#: Poisson's ratio of an isotropic lattice of springs, by dimension (Cauchy's relations).
CAUCHY_POISSON = {2: 1 / 3, 3: 1 / 4}
#: The mean of cos^4 over all directions, by dimension.
MEAN_COS4 = {2: 3 / 8, 3: 1 / 5}


class Material(NamedTuple):
    """An isotropic elastic body; of one in plane strain the constants that plane stress would give the same law."""

    young: float  #: Young's modulus [force / area]
    poisson: float
    thickness: float  #: [length]; 1 in 3D


class Body(NamedTuple):
    """A lattice as the formulas see it: simplices, and how much of its volume each stands for."""

    lattice: SpringLattice
    simplices: Integers  #: their nodes, shape (q, d + 1)
    volumes: Floats  #: [length^3], shape (q,)
    squares: Floats  #: squared length of each spring, shape (s,)


@dataclass(frozen=True)
class Formula(Optimizer):
    """Asks for one point: the closest of the encoding to the stiffness that a formula gives."""

    needs: ClassVar[tuple[str, ...]] = ("objective", "real")
    young: float | None = None  #: Young's modulus; none: the reference's, or an estimate from its deformation
    poisson: float | None = None  #: Poisson's ratio; none: the reference's, or 1/3 in 2D and 1/4 in 3D

    def __post_init__(self) -> None:
        if self.young is not None and not self.young > 0:
            raise UserError(f"option young of {self.name} is positive, not {self.young:g}; give another.")
        if self.poisson is not None and not -1 < self.poisson < 0.5:
            raise UserError(f"option poisson of {self.name} lies in (-1, 0.5), not at {self.poisson:g}; give another.")

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        objective = cast("Objective", problem.objective)
        lattice = objective.model.lattice
        material = _material(objective.reference, lattice.dimension)
        body = _body(self.name, lattice, material.thickness)
        young = self.young or material.young
        poisson = material.poisson if self.poisson is None else self.poisson
        stiffness = self.stiffness(body, material._replace(young=young or 1.0, poisson=poisson))
        if not young:
            stiffness *= _estimated_young(self.name, objective, stiffness)
        problem.evaluate([problem.encoding.encode(stiffness)])

    @abstractmethod
    def stiffness(self, body: Body, material: Material) -> Floats:
        """The stiffness [force/length] of each spring, shape (s,), in proportion to Young's modulus."""


@dataclass(frozen=True)
class Analytic(Formula):
    """The lattice whose elastic moduli are closest to the body's, cell by cell: boundary springs carry half a cell."""

    name: ClassVar[str] = "analytic"
    #: What is kept of a body whose Poisson's ratio is not the lattice's own: Young's modulus, the tensor of moduli as
    #: well as it can be, or Young's modulus and Poisson's ratio along the axes.
    keep: Literal["young", "moduli", "axes"] = "young"

    def stiffness(self, body: Body, material: Material) -> Floats:
        """Least squares of sum k L^2 n n n n = V C in each cell; of many answers the one with the least sum of k^2."""
        lattice = body.lattice
        assert lattice.cells is not None
        pairs = lattice.cells[:, list(combinations(range(lattice.cells.shape[1]), 2))]
        vectors = lattice.nodes[pairs[..., 1]] - lattice.nodes[pairs[..., 0]]
        columns = fourth_powers(vectors) * (_squares(vectors) * _are_joined(lattice, pairs))[..., None]
        volumes = body.volumes.reshape(len(pairs), -1).sum(axis=1)
        wanted = volumes[:, None] * self._moduli(lattice.dimension, material)
        shares = np.linalg.pinv(np.swapaxes(columns, 1, 2)) @ wanted[..., None]
        return _gather(lattice, pairs, shares[..., 0])

    def _moduli(self, dimension: int, material: Material) -> Floats:
        """The moduli [force / area] that the lattice should have, all with C12 = C44, as `fourth_powers` lists them."""
        young, poisson, _ = material
        if self.keep == "young":
            poisson = CAUCHY_POISSON[dimension]
        if dimension == 2:
            straight = young / (1 - poisson**2)
            across = poisson * straight
        else:
            across = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
            straight = across + young / (1 + poisson)
        if self.keep == "moduli":
            across = straight / 3  # of C12, 2 entries of the tensor, and C44, 4 entries, the mean: (C12 + 2 C44) / 3
        entries = {(4,): straight, (2, 2): across}
        _, powers, roots = _components(dimension)
        return roots * [entries.get(counts, 0.0) for counts in powers]


@dataclass(frozen=True)
class VanGelder(Formula):
    """k = E sum of volumes / L^2, over the triangles or tetrahedra around a spring; Van Gelder (1998)."""

    name: ClassVar[str] = "van-gelder"

    def stiffness(self, body: Body, material: Material) -> Floats:
        pairs = body.simplices[:, list(combinations(range(body.simplices.shape[1]), 2))]
        volumes = _gather(body.lattice, pairs, np.broadcast_to(body.volumes[:, None], pairs.shape[:2]))
        return material.young * _over(volumes, body.squares)


@dataclass(frozen=True)
class MacielConnections(Formula):
    """Each point shares its volume out evenly among its connections; after Maciel, Boulic and Thalmann (2003)."""

    name: ClassVar[str] = "maciel-connections"

    def stiffness(self, body: Body, material: Material) -> Floats:
        """A spring is a bar of what its two ends give it: k = E (V_i / c_i + V_j / c_j) / L^2.

        Of n connections in all directions c = n <cos^4> take part in a stretch.
        """
        springs = body.lattice.springs
        connections = np.bincount(springs.ravel(), minlength=body.lattice.node_count)
        counts = MEAN_COS4[body.lattice.dimension] * connections
        return material.young * _over((_point_volumes(body)[springs] / counts[springs]).sum(axis=1), body.squares)


@dataclass(frozen=True)
class MacielAngles(Formula):
    """Each point shares its volume out by the angles between its springs; after Maciel, Boulic and Thalmann (2003)."""

    name: ClassVar[str] = "maciel-angles"

    def stiffness(self, body: Body, material: Material) -> Floats:
        """As `maciel-connections`, but each connection counts by cos^4 of the angle that it makes with the spring."""
        lattice = body.lattice
        springs = lattice.springs
        powers = fourth_powers(lattice.nodes[springs[:, 1]] - lattice.nodes[springs[:, 0]])
        at_points = np.zeros((lattice.node_count, powers.shape[1]))
        np.add.at(at_points, springs, powers[:, None])
        counts = (at_points[springs] * powers[:, None]).sum(axis=2)
        return material.young * _over((_point_volumes(body)[springs] / counts).sum(axis=1), body.squares)


def fourth_powers(vectors: Floats) -> Floats:
    """n n n n of the directions n of vectors, shape (..., d) -> (..., entries): its different entries, each times the
    root of how often it occurs, so that products of two are those of the tensors: cos^4 of the angle between them."""
    components, _, roots = _components(vectors.shape[-1])
    squares = _squares(vectors)
    return _over(np.prod(vectors[..., components], axis=-1) * roots, np.square(squares)[..., None])


def _components(dimension: int) -> tuple[Integers, list[tuple[int, ...]], Floats]:
    """Of the fourth power of a vector, its different entries: indices (e, 4), their powers, roots of multiplicities."""
    indices = list(combinations_with_replacement(range(dimension), 4))
    powers = [tuple(sorted(Counter(entry).values(), reverse=True)) for entry in indices]
    roots = np.sqrt([factorial(4) / prod(map(factorial, counts)) for counts in powers])
    return np.array(indices), powers, roots


def _body(name: str, lattice: SpringLattice, thickness: float) -> Body:
    if lattice.cells is None or lattice.cell_type is None:
        raise NotServed(
            f"{name} needs the cells of the body, and this lattice has none; give it cells and cell_type.", word="cells"
        )
    parts, share = _division(lattice.cell_type)
    simplices = lattice.cells[:, parts].reshape(-1, lattice.dimension + 1)
    corners = lattice.nodes[simplices]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / factorial(lattice.dimension)
    i, j = lattice.springs.T
    return Body(lattice, simplices, share * thickness * volumes, _squares(lattice.nodes[j] - lattice.nodes[i]))


def _division(cell_type: str) -> tuple[Integers, float]:
    """The simplices of a cell, by local numbers, and which share of its volume each counts with.

    A block has one for each way along its edges from a corner to the opposite one: the mean of all Kuhn divisions.
    """
    if cell_type not in BLOCKS:
        return np.arange({"triangle": 3, "tetra": 4}[cell_type])[None], 1.0
    corners = BLOCKS[cell_type]
    dimension = len(corners[0])
    ways = [
        [
            corners.index(tuple(np.bitwise_xor(start, np.isin(range(dimension), axes[:steps]))))
            for steps in range(dimension + 1)
        ]
        for start in corners
        for axes in permutations(range(dimension))
    ]
    return np.array(ways), 1 / len(corners)


def _material(reference: Reference | None, dimension: int) -> Material:
    """The reference's, or one without a Young's modulus, 0, where it has no material."""
    from springopt.reference.fem import FemReference

    if not isinstance(reference, FemReference):
        return Material(0.0, CAUCHY_POISSON[dimension], 1.0)
    young, poisson = reference.young, reference.poisson
    if dimension == 2 and reference.plane == "strain":
        young, poisson = young / (1 - poisson**2), poisson / (1 - poisson)
    return Material(young, poisson, reference.thickness if dimension == 2 else 1.0)


def _estimated_young(name: str, objective: Objective, unit: Floats) -> float:
    """Young's modulus [force / area] by the principle of virtual work, `unit` (s,) being the stiffness for 1.

    The reference's own displacements are the virtual ones, zero at the supports: the work that the loads do on them is
    that of the springs, in proportion to Young's modulus. Exact where the reference is a lattice of this formula.
    """
    model = objective.model
    if any(case.times is not None for case in objective.cases):
        raise NotServed(
            f"{name} tells Young's modulus from a body at rest, and these load cases have times; give it by "
            "--set young=NUMBER.",
            word="motion",
        )
    training = [number for number, case in enumerate(objective.cases) if case.role == "train"]
    positions = objective.reference_positions[training]
    moves = np.where([objective.cases[number].supports for number in training], 0.0, positions - model.lattice.nodes)
    stated = replace(model, fitted=())  # where masses are fitted their weight is no constant force
    loads = [objective.cases[number].forces + stated.constant_forces() for number in training]
    i, j = model.lattice.springs.T
    done = float((np.array(loads) * moves).sum())
    pulls = unit[:, None] * model.forces_per_stiffness(positions)
    taken = float((pulls * (moves[:, j] - moves[:, i])).sum())
    if not (done > 0 and taken > 0):
        raise NotServed(
            f"{name} can't tell Young's modulus from this reference, on which the loads do no work; "
            "give it by --set young=NUMBER.",
            word="forces",
        )
    return done / taken


def _point_volumes(body: Body) -> Floats:
    """What each node stands for [length^3], shape (n,): an equal share of each simplex."""
    size = body.simplices.shape[1]
    shares: Floats = np.repeat(body.volumes / size, size)
    return np.bincount(body.simplices.ravel(), shares, minlength=body.lattice.node_count).astype(float)


def _gather(lattice: SpringLattice, pairs: Integers, amounts: Floats) -> Floats:
    """The sum of amounts (...) over pairs of nodes (..., 2) for each spring, shape (s,), in equal parts where several
    join the same nodes; what falls on pairs without a spring is dropped."""
    joined, which, counts = np.unique(_keys(lattice, lattice.springs), return_inverse=True, return_counts=True)
    keys = _keys(lattice, pairs).ravel()
    found = np.minimum(np.searchsorted(joined, keys), len(joined) - 1)
    totals = np.bincount(found, np.where(joined[found] == keys, amounts.ravel(), 0.0), minlength=len(joined))
    return (totals / counts)[which]


def _are_joined(lattice: SpringLattice, pairs: Integers) -> Booleans:
    """Which pairs of nodes (..., 2) a spring joins, shape (...)."""
    return np.isin(_keys(lattice, pairs), _keys(lattice, lattice.springs))


def _keys(lattice: SpringLattice, pairs: Integers) -> Integers:
    """One number for each pair of nodes, whichever comes first."""
    keys: Integers = pairs.min(axis=-1) * lattice.node_count + pairs.max(axis=-1)
    return keys


def _squares(vectors: Floats) -> Floats:
    return np.square(vectors).sum(axis=-1)


def _over(numbers: Floats, divisors: Floats) -> Floats:
    """Numbers over divisors, 0 where these are: springs without a length."""
    return np.divide(numbers, divisors, out=np.zeros_like(numbers), where=divisors > 0)
