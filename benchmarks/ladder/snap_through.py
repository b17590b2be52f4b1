"""The von Mises truss: two springs of length L0 from (-1, 0) and (1, 0) to an apex at height h, pressed down.

By symmetry the apex at height y is balanced by P(y) = 2 k y (L0 / L - 1), L = sqrt(1 + y^2), which is largest where
L^3 = L0: beyond that the apex snaps through, below it there are two minima.
"""

import numpy as np

import springopt as so
from ladder.rung import Rung
from ladder.shapes import on_nodes

FAMILY = "snap-through"
STIFFNESS = 3.0
SHARES = (0.1, 0.5, 0.9, 0.99, 0.999, 1.001, 1.01, 1.1, 2.0, 10.0)


def rungs():
    for height in (0.2, 0.5):
        yield from (truss(height, share, 2) for share in SHARES)
    yield from (truss(0.3, share, 3) for share in SHARES[::2])
    yield from (lifted(height) for height in (0.2, 0.5))


def load(y, natural, legs):
    return legs * STIFFNESS * y * (natural / np.sqrt(1 + y * y) - 1)


def critical_height(height):
    return np.sqrt((1 + height**2) ** (1 / 3) - 1)


def heights(height, force, legs):
    """The heights of the minima along the axis, from above to below."""
    natural, top = np.sqrt(1 + height**2), critical_height(height)
    found = [bisect(lambda y: load(y, natural, legs) - force, top, height)] if load(top, natural, legs) > force else []
    return [*found, bisect(lambda y: load(y, natural, legs) - force, -height - 10 * force, -height)]


def bisect(function, low, high):
    low, high = np.longdouble(low), np.longdouble(high)
    sign = np.sign(function(low))
    for _ in range(120):
        middle = (low + high) / 2
        low, high = (middle, high) if np.sign(function(middle)) == sign else (low, middle)
    return float(low)


def feet(legs):
    if legs == 2:
        return np.array([[-1.0, 0.0], [1.0, 0.0]])
    angles = 2 * np.pi * np.arange(legs) / legs
    return np.stack([np.cos(angles), np.sin(angles), np.zeros(legs)], axis=1)


def lattice_of(height, legs):
    bases = feet(legs)
    apex = np.zeros((1, bases.shape[1]))
    apex[0, -1] = height
    return so.SpringLattice(np.vstack([bases, apex]), [[i, legs] for i in range(legs)])


def truss(height, share, legs):
    lattice = lattice_of(height, legs)
    force = share * load(critical_height(height), np.sqrt(1 + height**2), legs)
    down = np.zeros(lattice.dimension)
    down[-1] = -force
    case = on_nodes(range(legs), {legs: down}, node_count=legs + 1, dimension=lattice.dimension)
    expected = heights(height, force, legs)

    def check(solution):
        y = solution.positions[0, -1, -1]
        return "" if np.abs(np.array(expected) - y).min() < 1e-7 else f"at height {y:.6f}, not {expected}"

    name = f"{legs} legs, height {height}, {share} of the critical load"
    return Rung(FAMILY, name, lattice, np.full(legs, STIFFNESS), case, check=check, status="converged", close=1e-4)


def lifted(height):
    """Pulled up it only stretches: one minimum."""
    lattice = lattice_of(height, 2)
    natural = np.sqrt(1 + height**2)
    y = bisect(lambda y: load(y, natural, 2) + 0.4, height, 10.0)
    case = on_nodes([0, 1], {2: (0, 0.4)}, node_count=3)
    known = np.vstack([feet(2), [[0.0, y]]])
    return Rung(FAMILY, f"2 legs, height {height}, lifted", lattice, np.full(2, STIFFNESS), case, known=known)
