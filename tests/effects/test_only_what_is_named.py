"""What a scene does not name is not imported, not allocated and not called."""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

import springopt as so
from springopt.forward.workspace import Workspace

PACKAGE = Path(so.__file__).parent
#: What every forward solve needs of the room; all else belongs to effects that a scene names.
CORE = {"__init__", "blocks", "compile", "effect", "lanes", "probe", "springs"}
OPTIONAL = {path.stem for path in (PACKAGE / "effects").glob("*.py")} - CORE
PLAIN = "paper-stiffness-2d"
SOLVE = """
import json, sys
import springopt as so
from springopt.forward.motion.lanes import follow_motions
setup = so.load_scene({scene!r}).build()
equilibria = setup.model.find(setup.model.groups(setup.cases), setup.objective.reference.stiffness[None], 1e-8)
print(json.dumps({{
    "positions": equilibria.displacements.tolist(),
    "iterations": equilibria.iterations.tolist(),
    "effects": sorted(m.rsplit(".", 1)[1] for m in sys.modules if m.startswith("springopt.effects.")),
    "heavy": [m for m in ("skfem", "scipy.sparse", "pyamg") if m in sys.modules],
    "motion": len(follow_motions.signatures),
}}))
"""
GRID = so.SpringLattice.grid((4, 3))
ONE_EFFECT = """
extends = "paper-stiffness-2d"
title = "One effect"
[[effects]]
kind = "volume"
modulus = 1.0
"""


def solved(scene=PLAIN, package=PACKAGE):
    """What a process of its own says of one forward solve."""
    folder = package.parent
    environment = os.environ | {"PYTHONPATH": str(folder)}
    command = [sys.executable, "-c", SOLVE.format(scene=str(scene))]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment, cwd=folder)
    return json.loads(done.stdout)


def pulled(lattice=GRID):
    forces = np.zeros(lattice.nodes.shape)
    forces[so.side(lattice, "right"), 0] = 0.3
    return so.LoadCase("pull", so.side(lattice, "left"), forces)


def test_a_plain_scene_imports_no_effect_and_compiles_no_motion():
    said = solved()
    assert set(said["effects"]) <= CORE
    assert said["heavy"] == []
    assert said["motion"] == 0


def test_the_effect_that_a_scene_names_is_the_only_one_that_is_imported(tmp_path):
    path = tmp_path / "one.toml"
    path.write_text(ONE_EFFECT)
    assert set(solved(path)["effects"]) - CORE == {"volume", "volume_kernel"}


def test_nothing_is_allocated_for_effects_that_are_not_there():
    (group,) = so.Model(GRID).groups([pulled()])
    plan = group.plan
    assert plan.value_count == 0
    assert len(plan.coupled) == len(plan.potentials.table) == 0
    assert len(plan.potentials.places) == len(plan.potentials.integers) == len(plan.potentials.numbers) == 0
    work = Workspace.of(plan)
    assert work.tangents.coupled.size == work.state.values.size == 0
    rows = so.Model(GRID).terms.rows(np.ones((3, GRID.spring_count)))
    assert rows.shape == (3, GRID.spring_count)


@dataclass(frozen=True)
class Counted(so.PythonEffect):
    """Nothing but a count of its calls."""

    name = "counted"
    calls: list[int] = field(default_factory=list)

    def pairs(self, lattice):
        return []

    def evaluate(self, lattice, displacements, *, stiffness, values):
        self.calls.append(1)
        n, d = lattice.nodes.shape
        return np.zeros(8), np.zeros((8, n, d)), np.zeros((8, 0, d, d))


@pytest.mark.parametrize("engine", ["lanes", "sparse"])
def test_an_effect_that_is_named_is_called_once_an_evaluation(engine):
    """One job in one lane: evaluations are iterations, and one more of the tangent at rest in large systems."""
    counted = Counted()
    stiffness = np.random.default_rng(0).uniform(1.0, 5.0, GRID.spring_count)
    with_it = so.Model(GRID, [counted], engine=engine).solve(stiffness, [pulled()])
    without = so.Model(GRID, engine=engine).solve(stiffness, [pulled()])
    assert len(counted.calls) == with_it.batch.iterations[0, 0] + (engine == "sparse")
    assert with_it.batch.iterations[0, 0] == without.batch.iterations[0, 0]
    np.testing.assert_allclose(with_it.positions, without.positions, atol=1e-12)


@pytest.mark.slow
def test_a_plain_scene_is_the_same_to_the_bit_with_the_files_of_all_effects_deleted(tmp_path):
    assert {"volume", "gravity", "contact", "bending", "inertia", "prestress"} <= OPTIONAL
    copy = tmp_path / "springopt"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    for name in OPTIONAL:
        (copy / "effects" / f"{name}.py").unlink()
    known, found = solved(), solved(package=copy)
    assert found["positions"] == known["positions"]
    assert found["iterations"] == known["iterations"]
    assert found["effects"] == known["effects"]
