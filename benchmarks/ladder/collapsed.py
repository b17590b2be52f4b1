"""Springs at length 0, of length 0, through length 0, and turned inside out."""

import numpy as np

import springopt as so
from ladder.rung import Rung
from ladder.shapes import chain, on_nodes, prescribe

FAMILY = "collapsed springs"


def rungs():
    yield from no_rest_length()
    yield from born_collapsed()
    yield from ends_brought_together()
    yield from turned_inside_out()


def no_rest_length():
    """L0 = 0: force k d, whatever the direction; linear."""
    lattice = so.SpringLattice([[0, 0], [2, 1], [0.5, 0.5]], [[0, 2], [1, 2]], [0.0, 0.0])
    stiffness = np.array([1.0, 3.0])
    for name, force in (("no load", (0, 0)), ("pulled", (0.4, -0.2)), ("pulled far", (40.0, 7.0))):
        known = np.array([[0, 0], [2, 1], (3 * np.array([2, 1]) + force) / 4])
        case = on_nodes([0, 1], {2: force}, node_count=3)
        yield Rung(FAMILY, f"no rest length, {name}", lattice, stiffness, case, known=known)
    tied = so.SpringLattice([[0, 0], [0, 0]], [[0, 1]], [0.0])
    for name, force in (("no load", (0, 0)), ("pulled", (0.4, -0.2))):
        known = np.array([[0, 0], np.array(force) / 2])
        yield Rung(FAMILY, f"tied nodes, {name}", tied, [2.0], on_nodes([0], {1: force}, node_count=2), known=known)
    grid = so.SpringLattice.grid((4, 4))
    zero = so.SpringLattice(grid.nodes, grid.springs, np.zeros(grid.spring_count))
    forces = np.where(so.side(grid, "right")[:, None], [0.3, 0.1], 0.0)
    case = so.LoadCase("pull", so.side(grid, "left") | so.side(grid, "right"), forces)
    yield Rung(FAMILY, "grid without rest lengths", zero, np.full(grid.spring_count, 2.0), case)


def born_collapsed():
    """Nodes at one place with L0 > 0 between them: the worst place to be, never a minimum."""
    lattice = so.SpringLattice([[0, 0], [0, 0]], [[0, 1]], [1.0])
    for name, force, status in (("no load", (0, 0), "underdetermined"), ("pulled", (0.3, 0.4), "converged")):
        case = on_nodes([0], {1: force}, node_count=2)
        known = None if status == "underdetermined" else np.array([[0, 0], [0.75, 1.0]])
        yield Rung(FAMILY, f"born at a point, {name}", lattice, [2.0], case, known=known, status=status)
    space = so.SpringLattice([[0, 0, 0], [0, 0, 0]], [[0, 1]], [1.0])
    yield Rung(FAMILY, "born at a point in space", space, [2.0], on_nodes([0], {}, node_count=2, dimension=3))
    # Two more springs in a row: the node leaves their line or stretches them, but does not stay.
    cross = so.SpringLattice([[0, 0], [-1, 0], [1, 0], [0, 0]], [[0, 3], [1, 3], [2, 3]], [0.5, 1.0, 1.0])
    yield Rung(FAMILY, "born at a point between two springs", cross, [2.0, 1, 1], on_nodes([0, 1, 2], {}, node_count=4))
    two = so.SpringLattice([[0, 0], [0, 0], [0, 0]], [[0, 1], [1, 2]], [1.0, 1.0])
    case = on_nodes([0], {2: (0.2, 0.0)}, node_count=3)
    yield Rung(
        FAMILY, "chain born at a point, pulled", two, [2.0, 2.0], case, known=np.array([[0, 0], [1.1, 0], [2.2, 0]])
    )


def ends_brought_together():
    """Supports move the ends of springs together, exactly and nearly."""
    lattice = chain(3)
    for name, move in (("exactly", -2.0), ("nearly", -2.0 + 1e-4), ("past", -2.5), ("half", -1.0)):
        case = on_nodes([], {}, node_count=3, prescribed=prescribe(3, 2, {0: (0, 0), 2: (move, 0)}))
        yield Rung(FAMILY, f"ends of a chain brought together, {name}", lattice, [2.0, 2.0], case)
    triangle = so.SpringLattice([[0, 0], [1, 0], [0.3, 0.8]], [[0, 1], [0, 2], [1, 2]])
    for name, move in (("exactly", -1.0), ("past", -2.0)):
        forces = {2: (0.0, 0.1)}
        case = on_nodes([], forces, node_count=3, prescribed=prescribe(3, 2, {0: (0, 0), 1: (move, 0)}))
        yield Rung(FAMILY, f"base of a triangle brought together, {name}", triangle, np.full(3, 2.0), case)
    # Pressed to length 0 by its load: there the spring has no direction, and the node swings round.
    strut = chain(2)
    for force in (-1.999999, -2.0, -2.000001, -5.0):
        known = np.array([[0, 0], [-1 + force / 2, 0]])
        case = on_nodes([0], {1: (force, 0)}, node_count=2)
        yield Rung(FAMILY, f"pressed to a point, force {force}", strut, [2.0], case, known=known)


def turned_inside_out():
    """A cell whose one node was pushed to the other side; a grid folded over its support."""
    cell = so.SpringLattice.grid((2, 2))
    for name, move in (("through the middle", (-1.2, -1.2)), ("onto a neighbour", (-1.0, 0.0)), ("far", (-4.0, -3.0))):
        case = on_nodes([], {}, node_count=4, prescribed=prescribe(4, 2, {0: (0, 0), 1: (0, 0), 3: move}))
        yield Rung(FAMILY, f"cell pushed {name}", cell, np.full(6, 2.0), case)
    grid = so.SpringLattice.grid((4, 3))
    stiffness = np.random.default_rng(2).uniform(1, 5, grid.spring_count)
    for force in (-3.0, -6.0, -15.0):
        forces = np.where(so.side(grid, "right")[:, None], [force, 0.0], 0.0)
        case = so.LoadCase("press", so.side(grid, "left"), forces)
        yield Rung(FAMILY, f"grid pressed through its support, {force}", grid, stiffness, case)
