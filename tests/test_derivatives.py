"""Derivatives against differences: of every effect, through every encoding, by every engine.

Differences are Richardson's extrapolation of central ones, on solves to 1e-12. What joins the lists below is tested.
"""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

import springopt as so
from springopt.encoding import ENCODINGS
from springopt.forward.plan import make_plan
from springopt.forward.state import ENERGY
from springopt.forward.terms import Terms
from springopt.forward.workspace import Workspace
from springopt.misfit import MISFITS


def ground_springs(stiffness):
    path = Path(__file__).parent / "effects" / "ground_springs.py"
    specification = importlib.util.spec_from_file_location("ground_springs", path)
    module = importlib.util.module_from_spec(specification)
    sys.modules.setdefault("ground_springs", module)  # where a kernel from the cache looks for itself
    specification.loader.exec_module(module)
    return module.GroundSprings(stiffness)


def stretched(shape):
    """A grid with prestress, and one spring that is to have no length."""
    grid = so.SpringLattice.grid(shape)
    rest = grid.rest_lengths * np.random.default_rng(1).uniform(0.9, 1.1, grid.spring_count)
    rest[3] = 0.0
    return so.SpringLattice(grid.nodes, grid.springs, rest, grid.cells, grid.cell_type)


#: Laws of the strain, which a spring without a rest length has not.
OF_STRAIN = ("stiffening", "exponential")
WITHOUT_EXPANSION = ("tension-only", "plane", "sphere")


def lattice_of(grid, effect):
    lattice = GRIDS[grid]
    if effect not in OF_STRAIN:
        return lattice
    rest = np.where(lattice.rest_lengths == 0, 1.0, lattice.rest_lengths)
    return so.SpringLattice(lattice.nodes, lattice.springs, rest, lattice.cells, lattice.cell_type)


GRIDS = {"2D": stretched((4, 3)), "3D": stretched((3, 3, 2))}
EFFECTS = {
    "springs": lambda d: [],
    "gravity": lambda d: [so.Gravity((0.0, -0.3, 0.1)[:d], mass=0.5)],
    "a stranger's": lambda d: [ground_springs(0.7)],
    "stiffening": lambda d: [so.Stiffening(1.0, 4.0)],
    "exponential": lambda d: [so.ExponentialStiffening(4.0)],
    "tension-only": lambda d: [so.TensionOnly()],
    "prestress": lambda d: [so.Prestress(classes={"boundary straight": 0.95, "diagonal": 0.9})],
    "volume": lambda d: [so.Volume(5.0)],
    "bending": lambda d: [so.Bending(2.0)],
    "plane": lambda d: [so.PlaneContact(9.0, np.full(d, 0.02), np.ones(d))],
    "sphere": lambda d: [so.SphereContact(9.0, np.full(d, 0.8), 3.0, inside=True)],
}
MODELS = {
    "lanes": {},
    "sparse": {"engine": "sparse"},
    "iterative": {"engine": "iterative"},
    "linear": {"kinematics": "linear"},
    "followed": {"branch": "followed"},
}
every_effect = pytest.mark.parametrize("effect", EFFECTS)
every_grid = pytest.mark.parametrize("grid", GRIDS)


def differences(function, point, direction, step):
    """The derivative of a function along a direction: central differences of two steps, extrapolated."""

    def central(h):
        return (function(point + h * direction) - function(point - h * direction)) / (2 * h)

    return (4.0 * central(step / 2) - central(step)) / 3.0


@every_grid
@every_effect
def test_forces_are_those_of_the_energy_and_tangents_those_of_the_forces(effect, grid):
    lattice = lattice_of(grid, effect)
    terms = Terms.of(lattice, EFFECTS[effect](lattice.dimension))
    plan = make_plan(terms, np.zeros(lattice.nodes.shape, dtype=bool))
    work, rng = Workspace.of(plan), np.random.default_rng(2)
    stiffness = terms.rows(rng.uniform(1.0, 9.0, (1, lattice.spring_count)))[0]
    u, direction = 0.1 * rng.standard_normal((2, lattice.nodes.size))

    def energy(displacements):
        work.evaluate(stiffness, displacements[None])
        return work.state.scalars[ENERGY, 0]

    def force(displacements):
        work.evaluate(stiffness, displacements[None])
        return work.state.internal[:, 0].copy()

    assert force(u) @ direction == pytest.approx(differences(energy, u, direction, 1e-2), rel=1e-8)
    work.evaluate(stiffness, u[None])
    at_nodes = np.empty((lattice.nodes.size, 8))
    work.spread_out(work.multiply(work.gather(direction[None])), at_nodes)
    expected = differences(force, u, direction, 1e-2)
    np.testing.assert_allclose(at_nodes[:, 0], expected, atol=1e-8 * np.abs(expected).max())


def objective(grid, effect="springs", minimize="least-squares", unloaded=(), **options):
    """Supports on two sides in turn, one of them moved; a reference that the model can't reach."""
    lattice = lattice_of(grid, effect)
    shape, rng = lattice.nodes.shape, np.random.default_rng(3)
    cases = []
    for number, side in enumerate(("left", "bottom", "left")):
        held = so.side(lattice, side)
        prescribed = np.zeros(shape)
        prescribed[held, -1] = 0.02 * number
        forces = 0.1 * rng.standard_normal(shape)
        forces[list(unloaded)] = 0.0
        cases.append(so.LoadCase(f"{number}", held, forces, prescribed))
    model = so.Model(lattice, EFFECTS[effect](lattice.dimension), **options)
    reference = lattice.nodes + 0.1 * rng.standard_normal((len(cases), *shape))
    return so.Objective(model, cases, reference, minimize=minimize, weights=[1.0, 0.5, 2.0], tolerance=1e-12)


def encodings(lattice):
    return {name: encoding(lattice) for name, encoding in ENCODINGS.items() if name != "grouped"}


DIFFERENTIABLE = [name for name, encoding in encodings(GRIDS["2D"]).items() if encoding.differentiable]
COMBINATIONS = [
    *(("2D", effect, minimize, "real", "lanes") for effect in EFFECTS for minimize in MISFITS),
    *(("2D", "springs", "distance", encoding, "lanes") for encoding in DIFFERENTIABLE),
    *((grid, "gravity", "distance", "real", model) for grid in GRIDS for model in MODELS),
    *(("3D", effect, "distance", "real", "sparse") for effect in EFFECTS),
    *(("2D", effect, "distance", "real", "linear") for effect in EFFECTS if effect not in WITHOUT_EXPANSION),
]


def problem(grid, effect, minimize, encoding, model):
    goal = objective(grid, effect, minimize, **MODELS[model])
    return so.Problem(goal, encodings(GRIDS[grid])[encoding], so.Budget(evaluations=1000))


@pytest.mark.parametrize("combination", COMBINATIONS, ids=str)
def test_gradients_and_jacobians_are_those_of_differences(combination):
    asked = problem(*combination)
    rng = np.random.default_rng(4)
    point, direction = rng.uniform(3.0, 7.0, asked.size), rng.standard_normal(asked.size)
    value, gradient = asked.gradient(point)
    assert value == pytest.approx(asked.evaluate(point[None])[0], rel=1e-12)
    expected = differences(lambda z: asked.evaluate(z[None])[0], point, direction, 2e-2)
    assert gradient @ direction == pytest.approx(expected, rel=1e-6)
    residuals, jacobian = asked.jacobian(point)
    np.testing.assert_array_equal(residuals, asked.residuals(point))
    expected = differences(asked.residuals, point, direction, 2e-2)
    np.testing.assert_allclose(jacobian @ direction, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("combination", COMBINATIONS, ids=str)
def test_products_are_those_with_the_jacobian_and_its_transpose(combination):
    asked = problem(*combination)
    rng = np.random.default_rng(5)
    point, v = rng.uniform(3.0, 7.0, asked.size), rng.standard_normal(asked.size)
    residuals, operator = asked.linearize(point)
    w = rng.standard_normal(residuals.size)
    known, jacobian = asked.jacobian(point)
    np.testing.assert_array_equal(residuals, known)
    forward, backward = operator.matvec(v), operator.rmatvec(w)
    np.testing.assert_allclose(forward, jacobian @ v, atol=1e-10 * np.abs(forward).max())
    np.testing.assert_allclose(backward, w @ jacobian, atol=1e-10 * np.abs(backward).max())
    scale = np.linalg.norm(forward) * np.linalg.norm(w)
    assert abs(forward @ w - v @ backward) <= 1e-12 * scale


def test_an_encoding_without_derivatives_has_none():
    asked = problem("2D", "springs", "distance", "binary", "lanes")
    with pytest.raises(so.UserError, match="derivatives need an encoding that has them"):
        asked.linearize(np.ones(asked.size))


@pytest.mark.parametrize("model", MODELS)
def test_a_node_without_springs_does_no_harm_to_derivatives(model):
    lattice = GRIDS["2D"]
    last = lattice.springs.max()
    goal = objective("2D", "springs", "distance", unloaded=[last], **MODELS[model])
    corner = (lattice.springs == last).any(axis=1)
    stiffness = np.where(corner, 0.0, np.random.default_rng(6).uniform(3.0, 7.0, lattice.spring_count))
    direction = np.where(corner, 0.0, np.random.default_rng(7).standard_normal(lattice.spring_count))
    _, gradient = goal.gradient(stiffness)
    expected = differences(lambda k: goal.evaluate(k[None]).values[0], stiffness, direction, 2e-2)
    assert gradient @ direction == pytest.approx(expected, rel=1e-6)
    residuals, operator = goal.linearize(stiffness)
    _, jacobian = goal.jacobian(stiffness)
    np.testing.assert_allclose(operator.rmatvec(residuals), residuals @ jacobian, atol=1e-9 * np.abs(jacobian).max())
