"""Effects: the answer with and without each of them, and what leaving it out saves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from springopt.analysis.effect_variants import Variant, candidate_at, variants_of
from springopt.analysis.point import choose_point
from springopt.checks import Floats
from springopt.effects.lanes import LANE_COUNT
from springopt.forward.batch import Equilibria
from springopt.forward.motion.follow import Motions
from springopt.forward.status import STATUSES, has_equilibrium
from springopt.model import Model
from springopt.scene import Scene, Setup
from springopt.tradeoff.errors import errors_of_cases
from springopt.tradeoff.point import Axis, Findings, Request, Setting, measure_settings

EVERYTHING = "everything"
TIGHT = 1e-12


def _missing(scene: Scene) -> str | None:
    is_static = scene.load_cases.times is None
    if scene.effects or (scene.kinematics == "exact" and is_static):
        return None
    return "it has no effects, and its kinematics are as cheap as they get"


def _measure(setup: Setup, request: Request) -> Findings:
    point = choose_point(setup)
    whole = Variant(EVERYTHING, setup.model, candidate_at(setup, point))
    variants, left_out = variants_of(setup, whole)
    known = _known(setup, whole)
    settings = [_setting(setup, variant, known) for variant in (whole, *variants)]
    notes = [f"Measured {point.said}.", *(f"{name} stays: {why}." for name, why in left_out.items())]
    return Findings(measure_settings(settings, request), notes=notes)


def _known(setup: Setup, whole: Variant) -> Floats:
    """Positions with everything [length], shape (c, ..., n, d), by another engine than the one that is timed."""
    usual = {group.choice.engine for group in whole.model.groups(setup.cases)}
    other = replace(whole.model, engine="sparse" if usual == {"lanes"} else "lanes")
    return other.solve(whole.candidate, setup.cases, TIGHT).positions


def _setting(setup: Setup, variant: Variant, known: Floats) -> Setting:
    model, candidates = variant.model.candidates(variant.candidate, axes=1)
    groups = model.groups(setup.cases)
    copies = LANE_COUNT if all(group.choice.engine == "lanes" for group in groups) else 1
    repeated = candidates.repeat(copies, axis=0)

    def run() -> Equilibria | Motions:
        return model.find(groups, repeated, setup.objective.tolerance)

    def judge(answers: Equilibria | Motions) -> Floats:
        return _errors(model, answers, known)

    def why(answers: Equilibria | Motions) -> str:
        return ", ".join(
            f"{setup.cases[number].name}: {STATUSES[answers.codes[0, number]]}" for number in _lost(answers)
        )

    is_whole = variant.name == EVERYTHING
    series, name = ("with", variant.name) if is_whole else ("without", variant.name)
    return Setting(series, name, run, judge, solves=copies * len(setup.cases), is_stated=is_whole, why=why)


def _lost(answers: Equilibria | Motions) -> list[int]:
    return np.flatnonzero(~has_equilibrium(answers.codes[0])).tolist()


def _errors(model: Model, answers: Equilibria | Motions, known: Floats) -> Floats:
    """Of each load case, shape (c,); inf where it has no answer."""
    nodes = model.lattice.nodes
    positions = nodes + answers.displacements[0].reshape(known.shape)
    errors = errors_of_cases(positions, known, nodes)
    return np.where(has_equilibrium(answers.codes[0]), errors, np.inf)


AXIS = Axis(
    name="effects",
    title="Effects: with everything, and without each",
    error="change of the positions, over the displacements",
    time="one forward solve",
    missing=_missing,
    measure=_measure,
    is_graded=False,
)
