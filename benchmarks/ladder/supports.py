"""Forces on what is held, no load, everything held, rollers, moved supports, and prestress."""

import numpy as np

import springopt as so
from ladder.rung import Rung
from ladder.shapes import on_nodes, prescribe, pull

FAMILY = "supports and zero load"
GRID = so.SpringLattice.grid((4, 3))
STIFFNESS = np.random.default_rng(9).uniform(1, 6, GRID.spring_count)


def rungs():
    yield from forces_on_supports()
    yield from zero_loads()
    yield from prestressed()
    yield from moved_supports()


def forces_on_supports():
    """They enter the reaction only."""
    case = pull(GRID, (0.2, 0.1))
    known = so.Model(GRID).solve(STIFFNESS, [case]).positions[0]
    for size in (1e-3, 1.0, 1e6):
        forces = case.forces + np.where(case.supports, size, 0.0)
        yield Rung(
            FAMILY,
            f"force {size:g} on supports",
            GRID,
            STIFFNESS,
            so.LoadCase("both", case.supports, forces),
            known=known,
        )
    held = so.LoadCase("held", np.ones(GRID.node_count, dtype=bool), np.full(GRID.nodes.shape, 0.3))
    yield Rung(FAMILY, "everything held", GRID, STIFFNESS, held, known=GRID.nodes)
    yield Rung(FAMILY, "everything held, no spring", GRID, 0 * STIFFNESS, held, known=GRID.nodes)


def zero_loads():
    for name, shape in (("plane", (4, 3)), ("space", (3, 2, 2))):
        lattice = so.SpringLattice.grid(shape)
        case = pull(lattice, np.zeros(len(shape)))
        yield Rung(FAMILY, f"no load, {name}", lattice, np.full(lattice.spring_count, 3.0), case, known=lattice.nodes)
    rng = np.random.default_rng(1)
    for density in (0.4, 0.6, 0.8):
        stiffness = STIFFNESS * (rng.random(GRID.spring_count) < density)
        yield Rung(FAMILY, f"no load, density {density}", GRID, stiffness, pull(GRID, (0, 0)), known=GRID.nodes)
    tiny = pull(GRID, (1e-200, 0))
    yield Rung(FAMILY, "a load of 1e-200", GRID, STIFFNESS, tiny)


def prestressed():
    """Rest lengths other than the distances, without load."""
    for share in (0.5, 0.9, 1.1, 1.5):
        lattice = so.SpringLattice(GRID.nodes, GRID.springs, share * GRID.rest_lengths)
        both = so.side(GRID, "left") | so.side(GRID, "right")
        case = so.LoadCase("prestress", both, np.zeros(GRID.nodes.shape))
        yield Rung(FAMILY, f"rest lengths times {share}", lattice, STIFFNESS, case)
        one_side = so.LoadCase("prestress", so.side(GRID, "left"), np.zeros(GRID.nodes.shape))
        yield Rung(FAMILY, f"rest lengths times {share}, one side held", lattice, STIFFNESS, one_side)


def moved_supports():
    right = np.flatnonzero(so.side(GRID, "right"))
    left = dict.fromkeys(np.flatnonzero(so.side(GRID, "left")), (0, 0))
    for name, move in (
        ("stretched", (0.5, 0)),
        ("sheared", (0, 2.0)),
        ("squeezed", (-1.0, 0)),
        ("far away", (30.0, 10.0)),
    ):
        moved = prescribe(GRID.node_count, 2, {**left, **dict.fromkeys(right, move)})
        yield Rung(
            FAMILY, f"sides {name}", GRID, STIFFNESS, on_nodes([], {}, node_count=GRID.node_count, prescribed=moved)
        )
    rolling = np.zeros((GRID.node_count, 2), dtype=bool)
    rolling[so.side(GRID, "left"), 0] = True
    rolling[0] = True
    forces = np.where(so.side(GRID, "right")[:, None], [0.4, 0.1], 0.0)
    yield Rung(FAMILY, "rollers", GRID, STIFFNESS, so.LoadCase("roll", rolling, forces), status="converged")
