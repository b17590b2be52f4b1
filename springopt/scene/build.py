"""From a checked scene to the objects that solve it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springopt.checks import Floats
from springopt.encoding import Encoding
from springopt.errors import SceneError, UserError
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.model import Model
from springopt.objective import Objective
from springopt.reference import Reference
from springopt.scene.schema import Scene


@dataclass(frozen=True, eq=False)
class Setup:
    """A scene made ready to be solved."""

    scene: Scene
    lattice: SpringLattice
    model: Model
    cases: list[LoadCase]
    reference_positions: Floats  #: [length], shape (c, n, d), or (c, t, n, d) where cases have times
    encoding: Encoding
    objective: Objective

    def reference_parameters(self) -> dict[str, list[float]]:
        """The fitted parameters of a mass-spring reference, by name; of another reference none."""
        from springopt.reference.spring import SpringReference

        if not isinstance(self.objective.reference, SpringReference):
            return {}
        terms = self.model.terms
        return {name: terms.defaults[terms.columns(name)].tolist() for name in terms.fitted}


def build(scene: Scene, *, threads: int = 1) -> Setup:
    """Lattice, load cases, the reference's positions [length], shape (c, n, d), model, encoding and objective."""
    lattice = scene.lattice.build()
    model = build_model(scene, lattice, threads=threads)
    cases = scene.load_cases.build(lattice)
    reference = scene.reference.build(model)
    reference_positions = deformed(scene, reference, cases)
    objective = Objective(model, cases, reference_positions, reference=reference, **scene.objective.model_dump())
    return Setup(scene, lattice, model, cases, reference_positions, scene.encoding.build_for(model), objective)


def build_model(scene: Scene, lattice: SpringLattice, *, threads: int = 1) -> Model:
    """The model that learns, its stiffness still open."""
    return Model(
        lattice,
        [effect.build() for effect in scene.effects],
        kinematics=scene.kinematics,
        engine=scene.engine,
        branch=scene.branch,
        threads=threads,
        fitted=scene.encoding.fitted,
        stepping=None if scene.stepping is None else scene.stepping.build(),
    )


def deformed(scene: Scene, reference: Reference, cases: Sequence[LoadCase]) -> Floats:
    """What a scene learns from [length], shape (c, n, d), or (c, t, n, d) where cases have times.

    Raises SceneError, with every load case in which the reference has no answer.
    """
    positions, faults = [], []
    for case in cases:
        try:
            positions.append(_measured(scene, case, reference.deform(case)))
        except UserError as error:
            faults.append(str(error))
    if faults:
        raise SceneError(f"the reference of scene {scene.name} can't be deformed: {' '.join(faults)}")
    return np.stack(positions)


def _measured(scene: Scene, case: LoadCase, positions: Floats) -> Floats:
    """What is learned from may be noisy; what judges is the reference itself."""
    noise = scene.reference.noise
    if noise is None or case.role == "test":
        return positions
    from springopt.reference.noise import measured

    return measured(positions, case, **noise.model_dump())
