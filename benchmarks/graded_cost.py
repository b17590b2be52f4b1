"""What a candidate without an equilibrium costs: along paths that add springs one by one until the body is rigid.

    ./run python benchmarks/graded_cost.py [FIGURE.png]

Every path begins without a spring and ends with all of them, in a random order of its own. Where an equilibrium is
missing the cost is at or above the cap, and falls with the zero modes at rest; below the cap it is the misfit.
"""

import sys
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

import springopt as so

PATH_COUNT = 200
STIFFNESS = 5.0
FORCES = {"pull": (0.3, 0.0), "press": (-0.3, 0.0), "shear": (0.0, 0.3)}


@dataclass(frozen=True)
class Paths:
    """Costs along random paths."""

    costs: np.ndarray  #: in relation to the cap, shape (paths, springs + 1)
    has_equilibria: np.ndarray  #: in all load cases, shape (paths, springs + 1)


def walk(path_count: int = PATH_COUNT, seed: int = 0) -> Paths:
    """Costs of the paths, on the 5 x 5 grid."""
    lattice = so.SpringLattice.grid((5, 5))
    model = so.Model(lattice)
    cases = [pull(lattice, name, force) for name, force in FORCES.items()]
    reference = model.solve(np.full(lattice.spring_count, STIFFNESS), cases).positions
    objective = so.Objective(model, cases, reference)
    rng = np.random.default_rng(seed)
    orders = np.array([rng.permutation(lattice.spring_count) for _ in range(path_count)])
    ranks = np.argsort(orders, axis=1)
    exists = ranks[:, None, :] < np.arange(lattice.spring_count + 1)[:, None]
    evaluation = objective.evaluate(STIFFNESS * exists.reshape(-1, lattice.spring_count))
    shape = (path_count, lattice.spring_count + 1)
    values = evaluation.values.reshape(shape) / objective.cost_cap
    return Paths(values, (evaluation.codes <= 1).reshape(shape))


def pull(lattice: so.SpringLattice, name: str, force: tuple[float, float]) -> so.LoadCase:
    forces = np.where(so.side(lattice, "right")[:, None], force, 0.0)
    return so.LoadCase(name, so.side(lattice, "left"), forces)


def draw(paths: Paths) -> Figure:
    """All paths, their median, and how many have equilibria."""
    figure = Figure(figsize=(7.0, 5.5), layout="constrained")
    grades, misfits = figure.subplots(2, 1, sharex=True, height_ratios=(1, 1))
    springs = np.arange(paths.costs.shape[1])
    failing = np.where(paths.has_equilibria, np.nan, paths.costs)
    solved = np.where(paths.has_equilibria, paths.costs, np.nan)
    median = np.median(paths.costs, axis=0)
    for axes, values, level in ((grades, failing, median >= 1), (misfits, solved, median < 1)):
        axes.plot(springs, values[:30].T, color="0.7", linewidth=0.7)
        axes.plot(springs, np.where(level, median, np.nan), color="C0", linewidth=2.0, label="median of all paths")
    grades.legend(loc="upper right")
    grades.set_ylabel("cost / cap, no equilibrium")
    grades.set_title(f"Springs added one by one, {len(paths.costs)} random orders")
    misfits.set_ylabel("cost / cap, equilibrium")
    misfits.set_yscale("log")
    misfits.set_ylim(1e-7, 1.0)  # the last spring of all makes it exact
    misfits.set_xlabel("number of springs")
    share = misfits.twinx()
    share.plot(springs, paths.has_equilibria.mean(axis=0), color="C1", linestyle="--")
    share.set_ylabel("share of paths with equilibria", color="C1")
    return figure


def main() -> None:
    paths = walk()
    draw(paths).savefig(sys.argv[1] if len(sys.argv) > 1 else "graded_cost.png", dpi=150)
    first = paths.has_equilibria.argmax(axis=1)
    failing = ~paths.has_equilibria[:, 1:] & ~paths.has_equilibria[:, :-1]
    steps = np.diff(paths.costs, axis=1)[failing]
    print(f"springs at the first equilibrium: median {np.median(first):.0f}, {first.min()} to {first.max()}")
    print(
        f"without one, a spring lowers the cost in {(steps < 0).mean():.1%} and raises it in {(steps > 0).mean():.1%}"
    )
    print(f"the median path rises {(np.diff(np.median(paths.costs, axis=0)) > 0).sum()} times")


if __name__ == "__main__":
    main()
