"""Section 4.4, left to future work: larger meshes, and how much of the distribution is the boundary's effect."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from springopt.benchmark import Job
from springopt.checks import Booleans, Floats
from springopt.encoding.spring_classes import inner_boundary_diagonal, straight_diagonal
from springopt.report.meshes import Mesh, draw_meshes
from springopt.reproduction import baselines
from springopt.reproduction.experiment import Experiment, Picture, Section, Table
from springopt.reproduction.extent import Extent
from springopt.reproduction.jobs import PAPER_GA, ga_jobs, make_jobs
from springopt.reproduction.runs import Runs
from springopt.reproduction.spread import Spread
from springopt.reproduction.variants import limited
from springopt.scene import Scene, load_scene
from springopt.store import RunFile

BASE = "paper-fem-2d"
SIDES = (5, 9, 17, 33)  #: nodes along a side
LIMITATIONS = ("homogeneous", "two-class", "three-class")
LOCAL = "l-bfgs-b"
#: What fits all springs freely; on the larger meshes it is cut off by the budget.
FREE = {5: "gauss-newton", 9: "gauss-newton", 17: LOCAL, 33: LOCAL}
BUDGETS = {5: 30_000, 9: 30_000, 17: 3_000, 33: 600}
GA_SIDE = 9
YOUNG = 10.0
PARTS = ("straight or diagonal", "boundary")


def larger(side: int) -> Scene:
    """The scene on side x side nodes, with the same stress: small displacements and least squares.

    Displacements then grow with the body, and the mean strain is the same. Geometric nonlinearity, which no spring
    model can follow, is left out, so that what remains is the lattice's own.
    """
    tables = json.loads(load_scene(BASE).to_json())
    for case in tables["load_cases"]["train"]:
        for push in case["push"]:
            push["force"] = [force * (side - 1) / 4 * 5 / side for force in push["force"]]
    tables |= {
        "name": f"{BASE}-small-{side}x{side}",
        "title": f"As {BASE} for small displacements, on {side} x {side} nodes",
        "kinematics": "linear",
        "objective": {"minimize": "least-squares"},
        "load_cases": {"train": tables["load_cases"]["train"]},
        "budget": {"evaluations": BUDGETS[side]},
    }
    tables["lattice"]["grid"] = [side, side]
    return Scene.from_json(json.dumps(tables))


def _jobs(extent: Extent) -> list[Job]:
    one, jobs = extent.seeds[:1], []
    for side in SIDES:
        for name in LIMITATIONS:
            jobs += make_jobs(limited(larger(side), name), LOCAL, extent, one, options={"starts": 1}, start="analytic")
    for side, optimizer in FREE.items():
        options = {"starts": 1} if optimizer == LOCAL else {}
        start = "analytic" if optimizer == LOCAL else None
        jobs += make_jobs(larger(side), optimizer, extent, one, options=options, start=start)
    return jobs + [job for job in ga_jobs(larger(GA_SIDE), extent) if job.seed in extent.baseline_seeds]


def _section(runs: Runs, extent: Extent) -> Section:
    limits = {side: {name: _one(runs, limited(larger(side), name), LOCAL) for name in LIMITATIONS} for side in SIDES}
    free = {side: _one(runs, larger(side), optimizer) for side, optimizer in FREE.items()}
    meshes = [Mesh(f"{side} x {side}", file.lattice, file.run.stiffness) for side, file in free.items()]
    parts = {f"{side}": variance_parts(of["three-class"])[:2] for side, of in limits.items()}
    return Section(
        paper="""Because of the small meshes it is not clear how far boundary effects explain the distribution; larger
            ones are left to future work.""",
        setting=f"""The body of `{BASE}` on more nodes, with the same forces per length, so that the mean strain is the
            same; small displacements and least squares, since the error of large turns, which no spring stiffness
            mends, would hide the rest. *Boundary* is the share of the stiffness's variance that tells straight springs
            on the boundary from those inside, *straight or diagonal* what these two classes tell.""",
        tables=[_by_size(limits), _by_freedom(runs, limits)],
        pictures=[
            Picture(
                "larger-meshes",
                draw_meshes(meshes, parts, PARTS),
                "Stiffness of all springs fitted freely, and what the variance of three classes is made of",
            )
        ],
        verdicts=[
            _faded(parts),
            _within(free, limits),
        ],
        explained=_explained(limits),
    )


def _explained(limits: dict[int, dict[str, RunFile]]) -> str:
    left = {side: of["two-class"].run.objective / of["homogeneous"].run.objective for side, of in limits.items()}
    small, large = min(left), max(left)
    return f"""A lattice of square cells has C11 = k_s + k_d and C12 = C66 = k_d (straight, diagonal; E t = 4/3 k_s
        where it is isotropic): inside, straight springs are twice as stiff as diagonals on a mesh of any size, 7.5 and
        3.75 for this E. A straight spring on the boundary has a cell on one side only, and half the stiffness. On the
        paper's mesh 16 of 40 straight springs lie there, and two classes, straight and diagonal, leave
        {left[small]:.0%} of the squared error of homogeneous springs; on {large} x {large} nodes they leave
        {left[large]:.0%}."""


def _one(runs: Runs, scene: Scene, label: str) -> RunFile:
    return runs.of(scene.name, label)[0]


def variance_parts(file: RunFile) -> tuple[float, float, float]:
    """Shares of the variance of the stiffness: between straight and diagonal, by the boundary beyond that, the rest."""
    stiffness = file.run.stiffness
    whole = _within_classes(stiffness, [np.ones(len(stiffness), dtype=bool)])
    two = _within_classes(stiffness, list(straight_diagonal(file.lattice).values()))
    three = _within_classes(stiffness, list(inner_boundary_diagonal(file.lattice).values()))
    return 1 - two / whole, (two - three) / whole, three / whole


def _within_classes(stiffness: Floats, masks: Sequence[Booleans]) -> float:
    """The sum of squares about the means of classes."""
    return sum(float(((stiffness[mask] - stiffness[mask].mean()) ** 2).sum()) for mask in masks)


def _by_size(limits: dict[int, dict[str, RunFile]]) -> Table:
    rows = []
    for side, of in limits.items():
        file = of["three-class"]
        classes = inner_boundary_diagonal(file.lattice)
        means = (f"{file.run.stiffness[mask].mean():.2f}" for mask in classes.values())
        between, boundary, _ = variance_parts(file)
        errors = (of[name].run.objective / of["homogeneous"].run.objective for name in LIMITATIONS[1:])
        share = np.count_nonzero(classes["boundary straight"]) / file.lattice.spring_count
        rows.append(
            (
                f"{side} x {side}",
                f"{file.lattice.spring_count:,}",
                f"{share:.0%}",
                *means,
                f"{between:.0%}",
                f"{boundary:.0%}",
                *(f"{error:.4f}" for error in errors),
            )
        )
    heads = (
        "nodes",
        "springs",
        "on the boundary",
        "inner straight",
        "boundary straight",
        "diagonal",
        "variance: straight or diagonal",
        "boundary",
        "squared error over homogeneous: two classes",
        "three classes",
    )
    return Table(heads, rows, "Three classes, fitted by `l-bfgs-b`:")


def _by_freedom(runs: Runs, limits: dict[int, dict[str, RunFile]]) -> Table:
    rows = []
    for side, label in [*FREE.items(), (GA_SIDE, PAPER_GA)]:
        files = runs.of(larger(side).name, label)
        whole = limits[side]["homogeneous"].run.objective
        errors = Spread.of(file.run.objective / whole for file in files).said(".4f")
        parts = (Spread.of(100 * variance_parts(file)[part] for file in files).said(".0f") for part in range(3))
        percent = (f"{part} %" for part in parts)
        spent = baselines.spent([file.run for file in files])
        rows.append((f"{side} x {side}", f"`{label}`", errors, *percent, *spent))
    heads = ("nodes", "", "squared error over homogeneous", "variance: straight or diagonal", "boundary", "rest")
    return Table((*heads, *baselines.SPENT), rows, "Every spring on its own:")


def _faded(parts: dict[str, tuple[float, float]]) -> str:
    """How much of the variance the boundary makes on the paper's mesh and on the largest."""
    (small, first), *_, (large, last) = ((side, of_side[1]) for side, of_side in parts.items())
    most = "most" if first > 0.5 else "not most"
    return (
        f"The boundary makes {first:.0%} of the variance on {small} x {small} nodes, the paper's mesh, {last:.0%} on "
        f"{large} x {large}: **{most} of the paper's distribution is a boundary effect**."
    )


def _within(free: dict[int, RunFile], limits: dict[int, dict[str, RunFile]]) -> str:
    said = ", ".join(f"{variance_parts(file)[2]:.1%} on {side} x {side}" for side, file in free.items())
    stopped = [side for side, file in free.items() if file.run.why_stopped == "budget"]
    over = {side: free[side].run.objective / limits[side]["three-class"].run.objective for side in stopped}
    cut = " and ".join(
        f"{side} x {side} (at {share:.0%} of three classes' squared error)" for side, share in over.items()
    )
    ended = f" The budget ended the search on {cut}: what differs there is not yet the body's." if cut else ""
    return f"With every spring on its own, what is neither class nor boundary is {said}.{ended}"


EXPERIMENT = Experiment("larger-meshes", "Future work: larger meshes", _jobs, _section)
