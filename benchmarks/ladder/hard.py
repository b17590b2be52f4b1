"""The hard cases made by others, with the status that each must end in."""

import json

import numpy as np

import springopt as so
from ladder.pressed import HARD_CASES
from ladder.rung import Rung

FAMILY = "hard cases"
#: Where its prose allows several statuses, the one that ours means by it.
STATUS = {
    "C01a": "underdetermined",
    "C02a": "converged",
    "C02c": "underdetermined",
    "C03_chain_1e-08_1e+08": None,
    "C03_chain_0.0001_10000": "converged",
    "C03_grid3x3_1e16": None,
    "C04b": "converged",
    "C04d": "converged",
    "C05": "converged",
    "C06_2D": "converged",
    "C09": "converged",
    "C12a": "converged",
    "C12c": "underdetermined",
    "C12e": "underdetermined",
    "C13_F0.001": "converged",
    "C17": "converged",
    "C20b": "converged",
}
#: A cubic minimum: the residual's tolerance over its curvature.
CLOSE = {"C13_F0.001": 1e-5}


def rungs():
    cases = {case["id"]: case for case in json.loads(HARD_CASES.read_text())}
    for name, status in STATUS.items():
        entry = cases[name]["input"]
        lattice = so.SpringLattice(entry["points"], np.array(entry["springs"]), np.array(entry["L0"], dtype=float))
        effects = (so.Gravity(entry["gravity"], entry["mass"]),) if np.any(entry["gravity"]) else ()
        value = cases[name]["expected"].get("value") or {}
        known = next((np.array(value[key]) for key in ("x", "x_connected", "x_base") if key in value), None)
        case = so.LoadCase(name, entry["fixed"], entry["load"])
        yield Rung(
            "hard cases", name, lattice, np.array(entry["k"]), case, effects, known, CLOSE.get(name, 1e-7), status
        )
