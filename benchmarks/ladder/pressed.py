"""Compression through buckling: below the critical load straight, above it bent, and never the saddle in between."""

import json
from pathlib import Path

import numpy as np

import springopt as so
from ladder.rung import Rung
from ladder.shapes import chain, on_nodes, pull

FAMILY = "buckling"
HARD_CASES = Path(__file__).parents[2] / "tests" / "data" / "hard" / "hard_cases.json"


def rungs():
    yield from column_of_the_hard_cases()
    yield from column_through_its_critical_load()
    yield from struts()
    yield from guided_chains()
    yield from slabs()


def column_of_the_hard_cases():
    """Perfect: the straight positions below the critical load, the energy of the bent ones above; imperfect: unique."""
    entry = next(case for case in json.loads(HARD_CASES.read_text()) if case["id"] == "C07")
    problem, answers = entry["input"], entry["expected"]["value"]
    lattice = so.SpringLattice(problem["points"], problem["springs"], np.array(problem["L0"]))
    for kind in ("perfect", "imperfect"):
        for answer in answers[kind]:
            tip = [answer.get("lateral_each", 0.0), -answer["P"] / 2]
            case = on_nodes(np.flatnonzero(problem["fixed"]), dict.fromkeys(problem["tip_nodes"], tip), node_count=18)
            yield Rung(
                FAMILY,
                f"column, {kind}, {answer['P_over_Pcrit']} of the critical load",
                lattice,
                np.array(problem["k"]),
                case,
                known=answer.get("x", answer["x_straight"] if answer.get("min_eig_straight", -1) > 0 else None),
                close=1e-5,
                status="converged",
                check=energy_is(answer["potential_buckled"]) if "potential_buckled" in answer else None,
            )


def energy_is(expected):
    def check(solution):
        return "" if abs(solution.energy[0] - expected) <= 1e-9 * abs(expected) else "not the energy of the bent column"

    return check


def column_through_its_critical_load():
    """A slender perfect column under loads from far below to far above: whatever it does, a minimum."""
    lattice = so.SpringLattice.grid((2, 12))
    stiffness = np.full(lattice.spring_count, 10.0)
    for load in (0.01, 0.03, 0.05, 0.06, 0.08, 0.15, 0.4, 1.0):
        yield Rung(
            FAMILY,
            f"slender column, load {load}",
            lattice,
            stiffness,
            pull(lattice, (0, -load), on="top", held="bottom"),
        )
    tower = so.SpringLattice.grid((2, 2, 8))
    stiffness = np.full(tower.spring_count, 10.0)
    for load in (0.05, 0.2, 0.5):
        case = pull(tower, (0, 0, -load), on="top", held="bottom")
        yield Rung(FAMILY, f"tower, load {load}", tower, stiffness, case)


def struts():
    """A node on a strut, held sideways by two springs of stiffness g in a row: P = k L / (...) tips it over."""
    lattice = so.SpringLattice([[0, 0], [0, 1], [-1, 1], [1, 1]], [[0, 1], [1, 2], [1, 3]])
    side_stiffness, stiffness = 0.1, 10.0
    # Sideways stiffness 2 g against P / (L of the pressed strut), L = 1 - P / k.
    critical = 2 * side_stiffness / (1 + 2 * side_stiffness / stiffness)
    for share in (0.5, 0.9, 0.99, 1.01, 1.1, 2.0):
        case = on_nodes([0, 2, 3], {1: (0, -share * critical)}, node_count=4)
        values = np.array([stiffness, side_stiffness, side_stiffness])
        yield Rung(FAMILY, f"strut, {share} of its critical load", lattice, values, case, check=bends_in_time(share))
    pendulum = chain(2, direction=(0.0, 1.0))
    for force in (0.1, 1.0, 4.0):
        known = np.array([[0, 0], [0, -1 - force / 2]])
        case = on_nodes([0], {1: (0, -force)}, node_count=2)
        yield Rung(FAMILY, f"pendulum on its head, {force}", pendulum, [2.0], case, known=known)


def bends_in_time(share):
    """The side springs lose their grip as the strut shortens: near the critical load only the far shares are sure."""

    def check(solution):
        sideways, height = solution.positions[0, 1]
        is_upright = abs(sideways) < 1e-3 and height > 0
        if share <= 0.5:
            return "" if is_upright else "bent below its critical load"
        return "" if share < 1.1 or not is_upright else "upright above its critical load"

    return check


def guided_chains():
    """Pressed between two walls that were moved together: a zigzag of hinges, or a chain with braces."""
    for squeeze in (0.1, 0.5):
        lattice = chain(5)
        prescribed = np.full((5, 2), np.nan)
        prescribed[0], prescribed[4] = (0, 0), (-squeeze, 0)
        case = so.LoadCase("press", np.zeros(5, dtype=bool), np.zeros((5, 2)), prescribed)
        yield Rung(FAMILY, f"chain squeezed by {squeeze}", lattice, np.full(4, 3.0), case)
    beam = so.SpringLattice.grid((9, 2))
    for squeeze in (0.05, 0.5, 1.5):
        moved = np.full(beam.nodes.shape, np.nan)
        moved[so.side(beam, "left")], moved[so.side(beam, "right")] = (0, 0), (-squeeze, 0)
        case = so.LoadCase("press", np.zeros(18, dtype=bool), np.zeros(beam.nodes.shape), moved)
        yield Rung(FAMILY, f"beam squeezed by {squeeze}", beam, np.full(beam.spring_count, 4.0), case)


def slabs():
    """Blocks pressed to a fraction of their height."""
    lattice = so.SpringLattice.grid((4, 4))
    for load in (0.5, 1.0, 2.0):
        stiffness = np.random.default_rng(3).uniform(1, 5, lattice.spring_count)
        yield Rung(FAMILY, f"slab, load {load}", lattice, stiffness, pull(lattice, (0, -load), on="top", held="bottom"))
