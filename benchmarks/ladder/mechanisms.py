"""Mechanisms under loads that do and do not work on them, loose parts that balance and that do not."""

import numpy as np

import springopt as so
from ladder.rung import Rung
from ladder.shapes import chain, on_nodes, prescribe, pull

FAMILY = "mechanisms"
SQUARE = so.SpringLattice([[0, 0], [1, 0], [0, 1], [1, 1]], [[0, 2], [1, 3], [2, 3]])
DIAMOND = so.SpringLattice([[0, 0], [1, 0], [0, 1], [4, 4], [5, 4]], [[0, 1], [0, 2], [1, 2], [3, 4]])


def rungs():
    yield from squares()
    yield from chains()
    yield from loose_parts()
    yield from free_bodies()
    yield from in_space()


def squares():
    """A square without diagonal, two nodes held."""
    loads = {
        "no load": ((0, 0), "underdetermined"),
        "pulled along its posts": ((0, 0.8), "converged"),
        "pressed along its posts": ((0, -0.8), "converged"),
        "pushed sideways": ((0.3, 0), "converged"),
        "pushed sideways, hardly": ((1e-6, 0), "converged"),
        "pulled askew": ((0.2, 0.5), "converged"),
    }
    for name, (force, status) in loads.items():
        case = on_nodes([0, 1], {2: force, 3: force}, node_count=4)
        yield Rung(FAMILY, f"square, {name}", SQUARE, np.full(3, 4.0), case, status=status)
    apart = on_nodes([0, 1], {2: (-0.4, 0), 3: (0.4, 0)}, node_count=4)
    # Hardly anything keeps the beam from swaying: a small residual is a long way.
    yield Rung(FAMILY, "square, spread along its beam", SQUARE, np.full(3, 4.0), apart, close=1e-5)


def chains():
    """A hinged chain of five springs, one end or both held."""
    lattice = chain(6)
    loads = {
        "no load": ({}, "underdetermined"),
        "pulled along": ({5: (0.3, 0)}, "converged"),
        "pressed along": ({5: (-0.3, 0)}, "converged"),
        "hangs across": ({5: (0, -0.3)}, "converged"),
        "pulled in the middle": ({3: (0.3, 0)}, "underdetermined"),
        "pulled along, hardly": ({5: (1e-9, 0)}, "converged"),
    }
    for name, (forces, status) in loads.items():
        yield Rung(
            FAMILY, f"chain, {name}", lattice, np.full(5, 2.0), on_nodes([0], forces, node_count=6), status=status
        )
    for name, forces in {
        "no load": {},
        "plucked": {2: (0, 0.05)},
        "every node": dict.fromkeys(range(6), (0, -0.01)),
    }.items():
        yield Rung(FAMILY, f"tight chain, {name}", lattice, np.full(5, 2.0), on_nodes([0, 5], forces, node_count=6))
    # Force 4 k h - 4 k h / sqrt(1 + h^2) lifts the middle of two springs in a row by h.
    rope = so.SpringLattice([[-1, 0], [1, 0], [0, 0]], [[0, 2], [1, 2]])
    for height in (0.01, 0.1, 1.0):
        force = 4.0 * height * (1 - 1 / np.sqrt(1 + height**2))
        known = np.array([[-1, 0], [1, 0], [0, height]])
        case = on_nodes([0, 1], {2: (0, force)}, node_count=3)
        yield Rung(FAMILY, f"rope lifted by {height}", rope, np.full(2, 2.0), case, known=known, close=1e-5)


def loose_parts():
    """A triangle on two supports, and apart from it a node, or two nodes on a spring."""
    base = {2: (0.1, 0.1)}
    two = np.ones(4)
    node_only = np.array([1.0, 1.0, 1.0, 0.0])
    for name, stiffness, forces in (
        ("loose node, no load on it", node_only, base),
        ("loose node, pulled", node_only, {**base, 3: (0.1, 0)}),
        ("loose node, pulled a little", node_only, {**base, 3: (0, 1e-7)}),
        ("loose spring, no load on it", two, base),
        ("loose spring, pulled as a whole", two, {**base, 3: (0.1, 0)}),
        ("loose spring, pulled apart", two, {**base, 3: (-0.1, 0), 4: (0.1, 0)}),
        ("loose spring, pressed together", two, {**base, 3: (0.1, 0), 4: (-0.1, 0)}),
        ("loose spring, turned", two, {**base, 3: (0, 0.1), 4: (0, -0.1)}),
        ("no spring at all, no load", np.zeros(4), {}),
        ("no spring at all, pulled", np.zeros(4), base),
    ):
        yield Rung(FAMILY, name, DIAMOND, stiffness, on_nodes([0, 1], forces, node_count=5))
    arm = so.SpringLattice([[0, 0], [1, 0], [0, 1], [1, 1]], [[0, 1], [0, 2], [1, 2], [2, 3]])
    for name, force in (("unloaded", (0, 0)), ("pulled", (0.1, 0)), ("across", (0, 0.1)), ("pressed", (-0.1, 0))):
        case = on_nodes([0, 1], {2: (0.05, 0), 3: force}, node_count=4)
        yield Rung(FAMILY, f"arm on one spring, {name}", arm, np.full(4, 3.0), case)
    roller = np.zeros((4, 2), dtype=bool)
    roller[:2, 0] = True
    for name, force in (("along the rail", (0, 0.1)), ("off the wall", (0.1, 0))):
        forces = np.zeros((4, 2))
        forces[2:] = force
        yield Rung(FAMILY, f"on rollers, {name}", SQUARE, np.full(3, 4.0), so.LoadCase("load", roller, forces))


def free_bodies():
    """Nothing is held: forces that balance deform, forces that do not accelerate."""
    lattice = so.SpringLattice.grid((3, 3))
    stiffness = np.full(lattice.spring_count, 5.0)
    nothing = np.zeros(9, dtype=bool)
    left, right = so.side(lattice, "left")[:, None], so.side(lattice, "right")[:, None]
    for name, forces in (
        ("no load", np.zeros((9, 2))),
        ("pulled apart", np.where(right, [0.3, 0], 0) - np.where(left, [0.3, 0], 0)),
        ("pushed", np.where(right, [0.3, 0], 0.0)),
        ("sheared", np.where(right, [0, 0.3], 0) - np.where(left, [0, 0.3], 0)),
    ):
        yield Rung(FAMILY, f"free body, {name}", lattice, stiffness, so.LoadCase("load", nothing, forces))


def in_space():
    """A flat grid in space bends out of its plane without resistance; a cube without diagonals shears."""
    flat = so.SpringLattice.grid((3, 3))
    sheet = so.SpringLattice(np.hstack([flat.nodes, np.zeros((9, 1))]), flat.springs)
    stiffness = np.full(sheet.spring_count, 4.0)
    for name, force in (("no load", (0, 0, 0)), ("pulled flat", (0.2, 0, 0)), ("lifted", (0, 0, 0.05))):
        forces = np.where(sheet.nodes[:, :1] == 2, force, 0.0)
        case = so.LoadCase("load", sheet.nodes[:, 0] == 0, forces)
        yield Rung(FAMILY, f"sheet in space, {name}", sheet, stiffness, case)
    cube = so.SpringLattice.grid((2, 2, 2), neighbourhood="von-neumann")
    for name, force in (("no load", (0, 0, 0)), ("stretched", (0.3, 0, 0)), ("sheared", (0, 0.3, 0))):
        yield Rung(FAMILY, f"cube without diagonals, {name}", cube, np.full(12, 3.0), pull(cube, force))
    rod = so.SpringLattice([[0, 0, 0], [1, 0, 0]], [[0, 1]])
    moved = prescribe(2, 3, {0: (0, 0, 0)})
    for name, force in (("unloaded", (0, 0, 0)), ("pressed", (-0.5, 0, 0))):
        case = on_nodes([0], {1: force}, node_count=2, dimension=3, prescribed=moved)
        yield Rung(FAMILY, f"rod in space, {name}", rod, [2.0], case)
