"""Equilibria that are known: polished until nothing changes, by residuals in long double precision.

The start is a tight solve of another engine than the scene's own, which also says which of several equilibria is meant.
Newton's corrections take the tangent of the start, factorized once by SciPy: iterative refinement, whose end depends on
the residual alone (Higham 2002, chapter 12), and that is summed in long double precision from springs that are written
anew. Where long double is no more than double, as with some compilers, known positions are good to that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from springopt.checks import Booleans, Floats
from springopt.forward.batch import Equilibria
from springopt.forward.status import MECHANISM, STATUSES, UNDERDETERMINED, has_equilibrium
from springopt.load_case import LoadCase
from springopt.model import Model
from springopt.tradeoff.independent.springs import Reals
from springopt.tradeoff.independent.system import System

TOLERANCE = 1e-12  # of the start
#: Shares of the largest displacement. An equilibrium further from the start is another one than was asked for.
WALK = 1e-6
#: A last correction above this leaves an equilibrium unknown; below the second nothing is left to correct.
UNKNOWN, AT_ROUNDING = 1e-12, 1e-18
MOST_CORRECTIONS = 30
#: A mode of less stiffness than this share of the stiffest one has none.
NO_STIFFNESS = 1e-12
DENSE = 1_500  # unknowns up to which modes are looked for, one by one


@dataclass(frozen=True, eq=False)
class KnownEquilibria:
    """Of m candidates under c load cases."""

    displacements: NDArray[np.longdouble]  #: [length], nan where they are not known, shape (m, c, n, d)
    is_known: Booleans  #: shape (m, c)
    has_none: Booleans  #: whether there is no equilibrium, as a mechanism has none, shape (m, c)
    why: NDArray[np.object_]  #: what is said where nothing is known, shape (m, c)
    doubt: float  #: the largest last correction, as a share of the largest displacement


@dataclass(frozen=True, eq=False)
class Polished:
    """One equilibrium."""

    displacements: Reals  #: [length], shape (n, d)
    doubt: float  #: the last correction, as a share of the largest displacement
    why: str = ""  #: it is not known, where it is not


def known_equilibria(model: Model, engine: str, candidates: Floats, cases: Sequence[LoadCase]) -> KnownEquilibria:
    """The equilibria of candidates (m, s + f) with exact kinematics, on the model's branch, begun by this engine."""
    exact = replace(model, kinematics="exact", engine=engine)
    start = exact.find(exact.groups(cases), candidates, TOLERANCE)
    assert isinstance(start, Equilibria)  # load cases with times have motions
    shape = start.codes.shape
    known = KnownEquilibria(
        displacements=np.full((*shape, *model.lattice.nodes.shape), np.nan, dtype=np.longdouble),
        is_known=np.zeros(shape, dtype=np.bool_),
        has_none=start.codes == MECHANISM,
        why=np.full(shape, "", dtype=object),
        doubt=0.0,
    )
    doubt = 0.0
    for candidate, row in enumerate(candidates):
        system = System.of(model, row)
        for number, case in enumerate(cases):
            at = candidate, number
            if known.has_none[at]:
                known.why[at] = "there is no equilibrium (mechanism)"
                continue
            if not has_equilibrium(start.codes[at]):
                known.why[at] = f"the engine {engine} finds no equilibrium ({STATUSES[start.codes[at]]})"
                continue
            begin = start.displacements[at].reshape(model.lattice.nodes.shape)
            found = polish(system, case, begin, may_have_modes=start.codes[at] == UNDERDETERMINED)
            known.why[at] = found.why
            if not found.why:
                known.displacements[at], known.is_known[at] = found.displacements, True
                doubt = max(doubt, found.doubt)
    return replace(known, doubt=doubt)


def polish(system: System, case: LoadCase, start: Floats, *, may_have_modes: bool = False) -> Polished:
    """The equilibrium next to displacements (n, d); supports are where they are prescribed to be.

    `may_have_modes`: whether there may be modes without stiffness. Nodes that nothing holds stay where they are; other
    modes leave it open where the equilibrium is, so that it is not known.
    """
    u = np.where(case.supports, case.prescribed, start).astype(np.longdouble)
    loads = case.forces.astype(np.longdouble) + system.loads
    tangent = system.tangent(u)
    # Nothing pulls a node whose stiffness is zero.
    is_held = np.zeros(u.size, dtype=np.bool_)
    is_held[np.repeat(abs(tangent).sum(axis=1).reshape(u.shape).sum(axis=1) == 0.0, u.shape[1])] = True
    free = np.flatnonzero(case.free.ravel() & ~is_held)
    if not len(free):
        return Polished(u, 0.0)
    own = tangent[free][:, free].tocsc()
    if may_have_modes and (len(free) > DENSE or _has_modes(own.toarray())):
        return Polished(u, np.inf, "some modes carry no load and no stiffness, and leave it open")
    try:
        factor = splu(own)
    except RuntimeError:  # SuperLU says so of singular matrices
        return Polished(u, np.inf, "its tangent is singular")
    began, last = u.copy(), np.inf
    for _ in range(MOST_CORRECTIONS):
        residual = (loads - system.forces(u)).ravel()[free]
        # Scaled, since what is left of the residual may be too small for double precision.
        size = np.abs(residual).max()
        correction = factor.solve((residual / size).astype(np.float64)) * size if size > 0.0 else np.zeros(len(free))
        share = _share(correction, u)
        if not share < 0.5 * last:  # as small as it gets, or nan
            break
        u.reshape(-1)[free] += correction
        last = share
        if share <= AT_ROUNDING:
            break
    if not last <= UNKNOWN:
        return Polished(u, last, "corrections did not come to rest")
    if _share(u - began, u) > WALK:
        return Polished(u, last, "corrections led away from where it began")
    return Polished(u, last)


def _share(change: Reals, u: Reals) -> float:
    largest = np.abs(u).max()
    changed = np.abs(change).max()
    return float(changed / largest) if largest > 0.0 else float(changed)


def _has_modes(tangent: Floats) -> bool:
    values = np.abs(np.linalg.eigvalsh(tangent))
    return bool(values.min() <= NO_STIFFNESS * values.max())
