"""Scenes on a line: nodes at whole numbers along x, every node held across it, so that answers are known by hand."""

from collections.abc import Mapping, Sequence
from typing import Any

from springopt.scene import Setup
from springopt.scene.load import check


def line(
    springs: Sequence[tuple[int, int]],
    load_cases: Sequence[Mapping[str, Any]],
    *,
    stiffness: Any = 2.0,
    **tables: Any,
) -> Setup:
    """A scene of these springs; load cases hold `hold` and push `push`, node -> force along x, or are whole tables."""
    count = 1 + max(max(pair) for pair in springs)
    across = {"on": list(range(count)), "axes": ["y"]}
    cases = [
        case
        if "move" in case
        else {
            "name": case.get("name", f"case {number}"),
            "hold": [across, {"on": list(case["hold"]), "axes": ["x"]}],
            "push": [{"on": node, "force": [force, 0.0]} for node, force in case.get("push", {}).items()],
        }
        for number, case in enumerate(load_cases)
    ]
    data = {
        "name": "line",
        "title": "Springs on a line",
        "lattice": {"nodes": [[float(x), 0.0] for x in range(count)], "springs": [list(pair) for pair in springs]},
        "reference": {"kind": "spring", "stiffness": stiffness},
        "encoding": {"kind": "real", "upper": 10.0},
        "load_cases": {"train": cases},
    }
    return check(data | tables, source="line").build()
