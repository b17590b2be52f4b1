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
from springopt.forward.status import has_equilibrium
from springopt.model import Model
from springopt.scene import Scene, Setup
from springopt.tradeoff.errors import errors_of_cases, say_failures
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
    engines = _engines(setup, whole)
    copies = LANE_COUNT if engines == {"lanes"} else 1  # the same for all, so that none has emptier lanes
    settings = [_setting(setup, variant, known, copies) for variant in (whole, *variants)]
    notes = [f"Measured {point.said}.", *(f"{name} stays: {why}." for name, why in left_out.items())]
    return Findings(measure_settings(settings, request), notes=notes)


def _known(setup: Setup, whole: Variant) -> Floats:
    """Positions with everything [length], shape (c, ..., n, d), by another engine than the one that is timed."""
    other = replace(whole.model, engine="sparse" if _engines(setup, whole) == {"lanes"} else "lanes")
    return other.solve(whole.candidate, setup.cases, TIGHT).positions


def _engines(setup: Setup, whole: Variant) -> set[str]:
    return {group.choice.engine for group in whole.model.groups(setup.cases)}


def _setting(setup: Setup, variant: Variant, known: Floats, copies: int) -> Setting:
    model, candidates = variant.model.candidates(variant.candidate, axes=1)
    groups = model.groups(setup.cases)
    repeated = candidates.repeat(copies, axis=0)

    def run() -> Equilibria | Motions:
        return model.find(groups, repeated, setup.objective.tolerance)

    def judge(answers: Equilibria | Motions) -> Floats:
        return _errors(model, answers, known)

    def why(answers: Equilibria | Motions) -> str:
        return say_failures(setup.cases, answers.codes[0])

    is_whole = variant.name == EVERYTHING
    series, name = ("with", variant.name) if is_whole else ("without", variant.name)
    return Setting(series, name, run, judge, solves=copies * len(setup.cases), is_stated=is_whole, why=why)


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
