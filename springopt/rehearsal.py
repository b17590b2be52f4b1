"""What the first run of a process would pay for all: imports that an optimizer makes when it is at work, and kernels.

Those seconds are no part of a run: else the first one of a process is slower than the second, and under a time limit it
finds less.
"""

from __future__ import annotations

import contextlib
import json
import os
import warnings
from functools import cache
from weakref import WeakKeyDictionary

import numpy as np

from springopt.budget import Budget
from springopt.errors import BudgetSpent, NoEquilibrium
from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt.scene import Scene, Setup

EVALUATIONS = 100
_STAGE = {
    "name": "rehearsal",
    "title": "Nine nodes",
    "lattice": {"grid": [3, 3]},
    "reference": {"kind": "spring", "stiffness": 5.0},
    "load_cases": {
        "train": [
            {"name": "pull", "hold": "left", "push": {"on": "right", "force": [0.3, 0.0]}},
            {"name": "shear", "hold": "bottom", "push": {"on": "top", "force": [0.1, 0.0]}},
        ]
    },
}
_ENCODINGS = {"real": {"kind": "real", "upper": 10.0}, "binary": {"kind": "binary", "stiffness": 5.0}}

_rehearsed: set[tuple[type[Optimizer], str, str]] = set()
_warm: WeakKeyDictionary[Setup, set[bool]] = WeakKeyDictionary()  # with derivatives, and without


def rehearse(optimizer: Optimizer, setup: Setup) -> None:
    """Has the optimizer at work on a small scene, once a process, and the kernels of this one ready, once a setup.

    What goes wrong with the optimizer here is told when it goes wrong in the run.
    """
    part = (type(optimizer), repr(optimizer), setup.encoding.kind)
    if part not in _rehearsed:
        _rehearsed.add(part)
        _play(optimizer, _stage(setup.encoding.kind))
    derivatives = bool({"gradient", "jacobian"} & set(optimizer.needs))
    done = _warm.setdefault(setup, set())
    if derivatives not in done:
        done.add(derivatives)
        _warm_up(setup, derivatives)


def _warm_up(setup: Setup, derivatives: bool) -> None:
    stiffness = setup.encoding.decode(setup.encoding.upper)
    # The one without springs needs what counts how far a candidate is from an equilibrium.
    without = stiffness.copy()
    without[: setup.lattice.spring_count] = 0.0
    setup.objective.evaluate(np.stack([stiffness, without]))
    if derivatives:
        with contextlib.suppress(NoEquilibrium):
            residuals, operator = setup.objective.linearize(stiffness)
            operator.matvec(stiffness)  # with its transpose, all the kernels of gradients and Jacobians
            operator.rmatvec(residuals)


def _play(optimizer: Optimizer, stage: Setup) -> None:
    problem = Problem(stage.objective, stage.encoding, Budget(evaluations=EVALUATIONS))
    with (
        open(os.devnull, "w") as nowhere,
        contextlib.redirect_stdout(nowhere),
        warnings.catch_warnings(),
        contextlib.suppress(Exception, BudgetSpent),
    ):
        warnings.simplefilter("ignore")
        optimizer.minimize(problem, np.random.default_rng(0))


@cache
def _stage(kind: str) -> Setup:
    return Scene.from_json(json.dumps(_STAGE | {"encoding": _ENCODINGS[kind]})).build()
