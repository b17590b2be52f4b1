"""The same body in other units: nanometres to kilometres, Pa to GPa; bit for bit where they are powers of two."""

import numpy as np

import springopt as so
from ladder.rung import Rung
from ladder.shapes import pull

FAMILY = "units"
LENGTHS = {"nm": 1e-9, "um": 1e-6, "mm": 1e-3, "km": 1e3, "2^-30": 2.0**-30, "2^10": 2.0**10}
STRESSES = {"Pa": 1.0, "kPa": 1e3, "GPa": 1e9, "2^30": 2.0**30}
GRID = so.SpringLattice.grid((4, 4))
COLUMN = so.SpringLattice.grid((2, 9))


def rungs():
    rng = np.random.default_rng(6)
    bodies = {
        "grid": (GRID, rng.uniform(1, 9, GRID.spring_count), pull(GRID, (0.4, -0.3))),
        "bent column": (
            COLUMN,
            np.full(COLUMN.spring_count, 10.0),
            pull(COLUMN, (0.0, -0.11), on="top", held="bottom"),
        ),
        "holes": (GRID, np.where(rng.random(GRID.spring_count) < 0.6, 5.0, 0.0), pull(GRID, (0.2, 0.1))),
    }
    for name, (lattice, stiffness, case) in bodies.items():
        here = so.Model(lattice).solve(stiffness, [case])
        for length_name, length in LENGTHS.items():
            for stress_name, stress in STRESSES.items():
                is_exact = length_name.startswith("2") and stress_name in ("Pa", "2^30")
                if name == "grid" or is_exact or (length_name, stress_name) in (("nm", "GPa"), ("km", "kPa")):
                    # Stiffness of a body of unit thickness is stress times length.
                    yield in_units(
                        f"{name}, {length_name}, {stress_name}",
                        lattice,
                        stiffness,
                        case,
                        here,
                        length,
                        stress,
                        is_exact,
                    )


def in_units(name, lattice, stiffness, case, here, length, stress, is_exact):
    there = so.SpringLattice(lattice.nodes * length, lattice.springs, lattice.rest_lengths * length)
    scaled = so.LoadCase("scaled", case.supports, case.forces * (stress * length * length))

    def check(solution):
        expected = here.displacements[0] * length
        if solution.status[0] != here.status[0]:
            return f"{solution.status[0]} in these units, {here.status[0]} in others"
        if is_exact:
            return "" if np.array_equal(solution.displacements[0], expected) else "other bits"
        off = np.abs(solution.displacements[0] - expected).max() / np.abs(expected).max()
        return "" if off <= 1e-9 else f"off by {off:.1e}"

    return Rung(FAMILY, name, there, stiffness * (stress * length), scaled, check=check)
