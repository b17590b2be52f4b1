"""The stiffness of each variation, by fits that share some seconds."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springopt.analysis.fit import Fit, fit
from springopt.checks import Floats
from springopt.errors import UserError
from springopt.options import make_optimizer
from springopt.registry import installed, load_optimizer
from springopt.scene import Setup
from springopt.tradeoff.axes.model.variation import (
    CLASSES,
    Variation,
    made_ready,
    with_encoding,
)
from springopt.tradeoff.point import Request

SPARSE_PATH = "sparse-path"
SPARSITY = "sparsity"
#: Of the springs that the lattice has: how many a model may keep.
KEPT = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)
#: Shares of the time, for nodes of which there is one.
OF_CLASSES, OF_FREE = 2, 4
FIRST = 3  # times as much for the scene's own lattice, which the others are compared with
OF_START = 0.2  # of a free fit's time, for classes of springs from which it starts


@dataclass(frozen=True, eq=False)
class Identified:
    """A variation and the best that was found for it."""

    variation: Variation
    point: Floats  #: of the encoding's box, shape (size,)
    unknowns: int
    seconds: float  #: that the fit took on the wall
    is_cut: bool  #: whether the time ended it
    method: str

    @property
    def setup(self) -> Setup:
        return self.variation.setup

    @property
    def row(self) -> Floats:
        """Stiffness, and fitted parameters behind it, shape (s + f,)."""
        return self.setup.encoding.decode(self.point)


def identify(variations: Sequence[Variation], request: Request, until: float) -> list[Identified]:
    """Fits of all variations, by this time of `time.perf_counter`, but for the question that is then being answered.

    Classes of springs start from the fit before, which has fewer; free springs from classes on the same lattice: so
    that more freedom is never worse for want of luck. What one does not need of its share the others have. Where fits
    have taken twice the time, as those of large models may, the last variations are left out.
    """
    most = 2 * until - time.perf_counter()
    found: list[Identified] = []
    shares = [_share(variation) for variation in variations]
    for number, variation in enumerate(variations):
        if found and time.perf_counter() > most:
            break
        left = (until - time.perf_counter()) / sum(shares[number:])
        start = _start(variation, found, left * shares[number] * OF_START, request)
        fitted = fit(variation.setup, left * shares[number] * (1 - OF_START), seed=request.seed, start=start)
        found.append(_identified(variation, fitted))
        if request.progress:
            request.progress(number + 1, len(variations), f"identified: {variation.series}, {variation.name}")
    return found


def sparser(free: Identified, request: Request, until: float) -> tuple[list[Identified], list[str]]:
    """Models of fewer and fewer springs, from the free fit on, and sentences on those that there are not."""
    if SPARSE_PATH not in installed():
        return [], [f"There is no series {SPARSITY}, as {SPARSE_PATH} is not installed; install springopt-gradient."]
    varied = free.setup
    try:
        options = {"agree": 1, **free.setup.scene.optimizer_options(SPARSE_PATH)}
        optimizer = make_optimizer(load_optimizer(SPARSE_PATH), options)
        seconds = until - time.perf_counter()
        path = fit(varied, seconds, seed=request.seed, start=free.point, optimizer=optimizer)
    except UserError as error:
        return [], [f"There is no series {SPARSITY}: {error}"]
    found, last = [], -1
    for share in KEPT:
        most = round(share * varied.lattice.spring_count)
        place = int(np.searchsorted(path.front.springs, most, side="right")) - 1
        name = f"at most {most} springs"
        if place < 0 or (place == last and not request.only):
            continue
        last = place
        variation = Variation(SPARSITY, name, varied)
        point, springs = path.front.points[place], int(path.front.springs[place])
        found.append(Identified(variation, point, springs, path.seconds, path.is_cut, SPARSE_PATH))
    fewest = int(path.front.springs[0]) if len(path.front) else varied.lattice.spring_count
    notes = [f"The time ended the path to fewer springs at {fewest}."] if path.is_cut else []
    return found, notes


def _identified(variation: Variation, fitted: Fit) -> Identified:
    size = variation.setup.encoding.size
    return Identified(variation, fitted.point, size, fitted.seconds, fitted.is_cut, fitted.method)


def _share(variation: Variation) -> float:
    setup = variation.setup
    share = OF_CLASSES if setup.scene.encoding.kind in CLASSES else OF_FREE
    return share * float(np.sqrt(setup.lattice.node_count)) * (FIRST if variation.series == "encodings" else 1)


def _start(variation: Variation, before: Sequence[Identified], seconds: float, request: Request) -> Floats | None:
    """The point of a fit with less freedom on the same lattice; None where there is none."""
    setup, kind = variation.setup, variation.setup.scene.encoding.kind
    same = [each for each in before if each.setup.scene.lattice == setup.scene.lattice and _learn_alike(each, setup)]
    if same:
        return setup.encoding.encode(same[-1].row)
    if kind in CLASSES:
        alike = [each for each in before if each.setup.scene.encoding.kind == kind]
        return _same_share_of_box(alike[-1], setup) if alike else None
    for classes in reversed(CLASSES):
        try:
            simpler = _simpler(setup, classes)
        except UserError:
            continue
        return setup.encoding.encode(simpler.encoding.decode(fit(simpler, seconds, seed=request.seed).point))
    return None


def _same_share_of_box(other: Identified, setup: Setup) -> Floats:
    """Bounds go with the spacing as the stiffness of a material does, see `resampling`."""
    box, own = other.setup.encoding, setup.encoding
    return own.lower + (other.point - box.lower) / (box.upper - box.lower) * (own.upper - own.lower)


def _simpler(setup: Setup, kind: str) -> Setup:
    scene = with_encoding(setup.scene, kind)
    return made_ready(scene, setup.lattice, setup.reference_positions, setup.objective.reference)


def _learn_alike(one: Identified, other: Setup) -> bool:
    return one.setup.reference_positions is other.reference_positions
