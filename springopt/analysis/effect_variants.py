"""A scene with everything, and with one effect less: what each effect is compared with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from springopt.analysis.point import Point
from springopt.checks import Floats
from springopt.forward.terms import Terms
from springopt.model import Model
from springopt.parameters import Parameters
from springopt.scene import Setup


@dataclass(frozen=True, eq=False)
class Variant:
    """A model with everything, or with one thing less."""

    name: str
    model: Model
    candidate: Parameters

    def solve(self, setup: Setup, copies: int = 1) -> tuple[Floats, Floats]:
        """(displacements (c, ...), codes (c,)) of all load cases, so many times."""
        model, candidates = self.model.candidates(self.candidate, axes=1)
        answers = model.find(model.groups(setup.cases), candidates.repeat(copies, axis=0), setup.objective.tolerance)
        return answers.displacements[0].reshape(len(setup.cases), -1), answers.codes[0]


def candidate_at(setup: Setup, point: Point) -> Parameters:
    """The candidate at a point of the encoding."""
    row = setup.encoding.decode(point.numbers)
    springs = setup.lattice.spring_count
    columns = {name: setup.model.terms.count(name) for name in setup.model.fitted}
    ends = springs + np.cumsum([0, *columns.values()])
    values = {name: row[begin : begin + count] for (name, count), begin in zip(columns.items(), ends, strict=False)}
    return Parameters(row[:springs], values)


def variants_of(setup: Setup, whole: Variant) -> tuple[list[Variant], dict[str, str]]:
    """One without each effect in turn, and with small displacements; what can't be left out, and why not."""
    model, terms = whole.model, whole.model.terms
    variants, left_out = [], {}
    for number, term in enumerate(terms.terms):
        if setup.cases[0].times is not None and [t.name for t in terms.terms if t.has_masses] == [term.name]:
            left_out[term.name] = "without masses nothing moves in time"
            continue
        variants.append(_without(whole, number))
    if model.kinematics == "exact" and setup.cases[0].times is None:
        refusing = [term.name for term in terms.terms if not term.effect.has_expansion_at_rest]
        if refusing:
            left_out["exact kinematics"] = f"small displacements would leave {' and '.join(refusing)} out"
        else:
            variants.append(Variant("exact kinematics", replace(model, kinematics="linear"), whole.candidate))
    return variants, left_out


def _without(whole: Variant, number: int) -> Variant:
    """Everything but one effect; a second one of its kind takes its name."""
    model = whole.model
    effects = [effect for other, effect in enumerate(model.effects) if other != number]
    before = [term.name for other, term in enumerate(model.terms.terms) if other != number]
    after = dict(zip(before, (term.name for term in Terms.of(model.lattice, effects).terms), strict=True))
    values = _renamed(whole.candidate.values, after)
    name = model.terms.terms[number].name
    return Variant(name, replace(model, effects=effects, fitted=tuple(values)), replace(whole.candidate, values=values))


def _renamed(values: Mapping[str, object], names: Mapping[str, str]) -> dict[str, Floats]:
    split = {name: name.split(".", 1) for name in values}
    return {
        f"{names[effect]}.{own}": np.asarray(values[name]) for name, (effect, own) in split.items() if effect in names
    }
