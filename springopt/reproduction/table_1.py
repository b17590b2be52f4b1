"""Table 1: one stiffness for all springs, one for each of two classes, one for each spring."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from springopt.benchmark import Job
from springopt.encoding.spring_classes import inner_boundary_diagonal, straight_diagonal
from springopt.report.dots import Dots, draw_dots
from springopt.reproduction import baselines, paper
from springopt.reproduction.experiment import Experiment, Picture, Section, Table
from springopt.reproduction.extent import Extent
from springopt.reproduction.jobs import BASELINES, PAPER_GA, baseline_jobs, ga_jobs
from springopt.reproduction.runs import Runs
from springopt.reproduction.spread import Spread
from springopt.reproduction.variants import calibrated, limited
from springopt.reproduction.verdict import Comparison
from springopt.scene import Scene, load_scene
from springopt.store import RunFile

SCENE = "paper-fem-2d"
CALIBRATED, CLAMPED = f"{SCENE}-calibrated", f"{SCENE}-clamped-calibrated"
LIMITATIONS = ("homogeneous", "two-class", "three-class", "unrestricted")
HEADS = ("", "cost", "over homogeneous", "stiffness", *baselines.SPENT)


def readings() -> dict[str, Scene]:
    """What is read of the paper's loads, and the scene that says so."""
    return {
        "the bundled loads": load_scene(SCENE),
        "loads at which the homogeneous cost is the paper's": calibrated(SCENE),
        "the same with one side held throughout": calibrated(f"{SCENE}-clamped"),
    }


def _jobs(extent: Extent) -> list[Job]:
    jobs = [
        job for scene in readings().values() for name in LIMITATIONS for job in ga_jobs(limited(scene, name), extent)
    ]
    return jobs + [job for scene in readings().values() for job in baseline_jobs(scene, extent, BASELINES)]


def _section(runs: Runs, extent: Extent) -> Section:
    scenes = readings()
    costs = {name: _costs(runs, scene) for name, scene in scenes.items()}
    tables = [Table(HEADS, _paper_rows(), "**The paper**")]
    tables += [Table(HEADS, _rows(runs, scene), _note(name, scene)) for name, scene in scenes.items()]
    return Section(
        paper="""Cost at the end: 0.85 with one stiffness for all springs, 0.73 with one for straight and one for
            diagonal springs, 0.58 unrestricted: a linear elastic body is not simulated by homogeneous stiffness.""",
        setting="""72 springs, 12 load cases, 3000 generations of 10; E = 10, plane stress, thickness and spacing 1 are
            the units in which the paper's stiffness comes out. The cost is the sum of the mean node distances over the
            training load cases. How large the paper's loads were is not known: the second table has them so large that
            its homogeneous cost comes out, and the third holds the left side in every load case as well. Three classes
            (straight springs inside, straight ones on the boundary, diagonals) are ours.""",
        tables=tables,
        pictures=[Picture("table-1", draw_dots(_panels(costs)), "Cost over the homogeneous cost, a dot a seed")],
        verdicts=_verdicts(runs, costs),
        explained=_explained(runs, costs),
    )


def _explained(runs: Runs, costs: dict[str, dict[str, list[float]]]) -> str:
    """Why the ratios differ, and what holds under all of the loads."""
    middles = {name: {kind: Spread.of(of[kind]).middle for kind in LIMITATIONS} for name, of in costs.items()}
    bundled, calibrated_loads, held = middles.values()
    fitted = "homogeneous"
    off = max(abs(held[kind] / cost.value - 1) for kind, cost in paper.COSTS.items() if kind != fitted)
    free, free_at_large = (of["unrestricted"] / of[fitted] for of in (bundled, calibrated_loads))
    above = max(of["three-class"] / of["unrestricted"] - 1 for of in middles.values())
    ordered = sum(of["unrestricted"] < of["two-class"] < of[fitted] for of in middles.values())
    formula = [runs.of(scene.name, "analytic")[0].run.objective for scene in readings().values()]
    better = sum(cost < of["two-class"] for cost, of in zip(formula, middles.values(), strict=True))
    return f"""The costs have the paper's order under {ordered} of {len(middles)} loads, and their ratios depend on
        loads and supports. Large loads turn the springs, and what a linear reference does then no spring model can
        follow, however many numbers it has: free springs leave {free:.2f} of the homogeneous cost under the bundled
        loads and {free_at_large:.2f} under those of the second table. With one side held throughout the two costs that
        are not fitted are within {off:.1%} of the paper's. The three classes end at most {above:.1%} above the 72 free
        springs, and the formula `analytic`, which does not search, is below two classes under {better} of
        {len(middles)} loads."""


def _note(name: str, scene: Scene) -> str:
    return f"**Here: {name}** (forces times {scene.load_cases.scale:.3f})"


def _costs(runs: Runs, scene: Scene) -> dict[str, list[float]]:
    return {name: [file.run.objective for file in _files(runs, scene, name)] for name in LIMITATIONS}


def _files(runs: Runs, scene: Scene, limitation: str) -> list[RunFile]:
    return runs.of(limited(scene, limitation).name, PAPER_GA)


def _paper_rows() -> list[tuple[str, ...]]:
    stiffness = {
        "homogeneous": "all 4.07",
        "two-class": "straight 4.76, diagonal 3.35",
        "unrestricted": "main classes in [3, 4] and [6, 8]",
    }
    whole = paper.COSTS["homogeneous"].value
    return [
        (
            name,
            cost.printed,
            f"{cost.value / whole:.2f}",
            stiffness[name],
            "30,000" if name == "unrestricted" else "-",
            "-",
        )
        for name, cost in paper.COSTS.items()
    ]


def _rows(runs: Runs, scene: Scene) -> list[tuple[str, ...]]:
    whole = Spread.of(_costs(runs, scene)["homogeneous"]).middle

    def numbers(files: Sequence[RunFile]) -> tuple[str, ...]:
        costs = Spread.of(file.run.objective for file in files)
        return costs.said(".3f"), f"{costs.middle / whole:.3f}", _stiffness(files)

    limitations = [baselines.row(f"`paper-ga`, {name}", _files(runs, scene, name), numbers) for name in LIMITATIONS]
    return limitations + baselines.rows(runs, scene.name, BASELINES, numbers)


def _stiffness(files: Sequence[RunFile]) -> str:
    """Means of the classes that differ, of the best run."""
    best = min(files, key=lambda file: file.run.objective)
    lattice, stiffness = best.lattice, best.run.stiffness
    if np.ptp(stiffness) == 0:
        return f"all {stiffness[0]:.2f}"
    two, three = straight_diagonal(lattice), inner_boundary_diagonal(lattice)
    classes = two if all(np.ptp(stiffness[mask]) == 0 for mask in two.values()) else three
    return ", ".join(f"{name} {stiffness[mask].mean():.2f}" for name, mask in classes.items())


def _panels(costs: dict[str, dict[str, list[float]]]) -> list[Dots]:
    """One for each limitation that the paper has beside the homogeneous one."""
    whole = paper.COSTS["homogeneous"].value
    return [
        Dots(
            f"{limitation} over homogeneous",
            {
                name: [cost / Spread.of(of["homogeneous"]).middle for cost in of[limitation]]
                for name, of in costs.items()
            },
            round(paper.COSTS[limitation].value / whole, 3),
        )
        for limitation in ("two-class", "unrestricted")
    ]


def _verdicts(runs: Runs, costs: dict[str, dict[str, list[float]]]) -> list[str]:
    _, second, third = readings()
    compared = []
    for name in ("two-class", "unrestricted"):
        held = {third: costs[third][name]}
        compared.append(Comparison(f"Cost, {name}", paper.COSTS[name], costs[second][name], ".3f", held))
    for what, published, limitation, class_name in (
        ("Homogeneous stiffness", paper.ALL_SPRINGS, "homogeneous", None),
        ("Straight springs of two classes", paper.STRAIGHT, "two-class", "straight"),
        ("Diagonal springs of two classes", paper.DIAGONAL, "two-class", "diagonal"),
    ):
        means = {name: _means(_files(runs, scene, limitation), class_name) for name, scene in readings().items()}
        ours = means.pop(second)
        compared.append(Comparison(what, published, ours, ".2f", means))
    return [comparison.said() for comparison in compared]


def _means(files: Sequence[RunFile], class_name: str | None) -> list[float]:
    masks = [slice(None) if class_name is None else straight_diagonal(file.lattice)[class_name] for file in files]
    return [float(file.run.stiffness[mask].mean()) for file, mask in zip(files, masks, strict=True)]


EXPERIMENT = Experiment("table-1", "Table 1: classes of springs", _jobs, _section)
