"""What physics costs: small displacements, exact ones and motion to rest; and each effect beside the springs.

    ./run python benchmarks/effects.py [--rounds 15]

Processor seconds of one candidate under six load cases, in batches of 64, one thread. Everything in one table is solved
round by round in one process; each figure is the median over the rounds of the ratio to the first row, with its middle
half. Loads are moderate: the largest displacement is about a tenth of the spacing. Motion starts at rest and is damped;
of both integrators, six step lengths and five dampings the one is timed that comes within 1e-6 of the exact equilibrium
(relative to its displacements) in the fewest steps.
"""

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import replace

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import springopt as so
from springopt.effects.effect import Effect

COPIES = 64
AT_REST = 1e-6
MOST_STEPS = 60
GRIDS = {"5 x 5": (5, 5), "4 x 4 x 4": (4, 4, 4)}
STEPS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
DAMPINGS = ((0.0, 1.0), (0.0, 4.0), (0.5, 1.0), (1.0, 0.0), (2.0, 4.0))


def load_cases(lattice: so.SpringLattice) -> list[so.LoadCase]:
    """Six loads on the right side while the left one is held."""
    rng, held, right = np.random.default_rng(0), so.side(lattice, "left"), so.side(lattice, "right")
    cases = []
    for number in range(6):
        forces = np.zeros(lattice.nodes.shape)
        forces[right] = 0.1 * rng.standard_normal(lattice.dimension)
        cases.append(so.LoadCase(f"{number}", held, forces))
    return cases


def stiffness_of(lattice: so.SpringLattice) -> np.ndarray:
    return np.random.default_rng(1).uniform(2.0, 6.0, lattice.spring_count)


def measure(solvers: dict[str, Callable[[], object]], rounds: int) -> dict[str, tuple[float, float, float, float]]:
    """(milliseconds a candidate, ratio to the first, its quartiles) of each, round by round."""
    seconds = np.empty((rounds, len(solvers)))
    for solve in solvers.values():
        solve()
    for number in range(rounds):
        for column, solve in enumerate(solvers.values()):
            begin = time.process_time()
            solve()
            seconds[number, column] = time.process_time() - begin
    ratios = seconds / seconds[:, :1]
    return {
        name: (1e3 * float(np.median(seconds[:, i])) / COPIES, *np.quantile(ratios[:, i], [0.5, 0.25, 0.75]).tolist())
        for i, name in enumerate(solvers)
    }


def rest_of(
    lattice: so.SpringLattice, stiffness: np.ndarray, cases: list[so.LoadCase]
) -> tuple[so.Model, np.ndarray, str]:
    """The model in motion that is at rest in the fewest steps, the time, and what it is in words."""
    known = so.Model(lattice).solve(stiffness, cases, 1e-10).displacements
    best: tuple[int, so.Model, np.ndarray, str] | None = None
    for integrator in ("energy-momentum", "l-stable"):
        for step in STEPS:
            for springs, nodes in DAMPINGS:
                effects = [so.Inertia(mass=1.0), so.Damping(springs=springs, nodes=nodes)]
                model = so.Model(lattice, effects, stepping=so.Stepping(step, integrator))
                times = step * np.arange(1, MOST_STEPS + 1)
                moved = model.solve(stiffness, [replace(case, times=times) for case in cases])
                if not all(status.has_equilibrium for status in moved.status):
                    continue
                off = np.linalg.norm(moved.displacements - known[:, None], axis=(2, 3))
                is_there = (off <= AT_REST * np.linalg.norm(known, axis=(1, 2))[:, None]).all(axis=0)
                if not is_there[-1]:
                    continue
                count = int(np.flatnonzero(~is_there)[-1]) + 2 if not is_there.all() else 1
                if best is None or count < best[0]:
                    words = f"{integrator}, {count} steps of {step:g}, damping springs {springs:g}, nodes {nodes:g}"
                    best = count, model, times[count - 1 : count], words
    assert best is not None, "no combination comes to rest; lengthen STEPS or MOST_STEPS"
    return best[1], best[2], best[3]


def compare_physics(shape: tuple[int, ...], rounds: int) -> None:
    lattice = so.SpringLattice.grid(shape)
    stiffness, cases = stiffness_of(lattice), load_cases(lattice)
    candidates = np.tile(stiffness, (COPIES, 1))
    exact, linear = so.Model(lattice), so.Model(lattice, kinematics="linear")
    moving, times, words = rest_of(lattice, stiffness, cases)
    in_time = [replace(case, times=times) for case in cases]
    answers = {
        "exact": exact.solve(stiffness, cases).displacements,
        "linear": linear.solve(stiffness, cases).displacements,
        "motion to rest": moving.solve(stiffness, in_time).displacements[:, -1],
    }
    rows = measure(
        {
            "exact": lambda: exact.solve_many(candidates, cases),
            "linear": lambda: linear.solve_many(candidates, cases),
            "motion to rest": lambda: moving.solve_many(candidates, in_time),
        },
        rounds,
    )
    size = np.linalg.norm(answers["exact"], axis=(1, 2))
    print(f"\n| {' x '.join(map(str, shape))}: physics | ms | to exact | answers differ by |\n|---|---|---|---|")
    for name, (milliseconds, ratio, low, high) in rows.items():
        off = (np.linalg.norm(answers[name] - answers["exact"], axis=(1, 2)) / size).max()
        print(f"| {name} | {milliseconds:.3g} | {ratio:.2f} ({low:.2f} to {high:.2f}) | {off:.1e} |")
    print(f"\nMotion: {words}.")


def effects_of(lattice: so.SpringLattice) -> dict[str, list[Effect]]:
    d, middle = lattice.dimension, lattice.nodes.mean(axis=0)
    down = [0.0] * (d - 1) + [-1.0]
    below = [0.0] * (d - 1) + [0.02]
    return {
        "springs alone": [],
        "gravity": [so.Gravity(down, mass=0.01)],
        "prestress": [so.Prestress(scale=0.98)],
        "stiffening": [so.Stiffening(cubic=5.0)],
        "exponential": [so.ExponentialStiffening(5.0)],
        "tension-only": [so.TensionOnly()],
        "tension-only, prestressed": [so.Prestress(scale=0.8), so.TensionOnly()],
        "volume": [so.Volume(5.0)],
        "bending": [so.Bending(1.0)],
        "plane": [so.PlaneContact(50.0, below, [0.0] * (d - 1) + [1.0])],
        "sphere": [so.SphereContact(50.0, [*middle[:-1], lattice.nodes[:, -1].max() + 0.95], 1.0)],
    }


def compare_effects(shape: tuple[int, ...], rounds: int) -> None:
    lattice = so.SpringLattice.grid(shape)
    stiffness, cases = stiffness_of(lattice), load_cases(lattice)
    candidates = np.tile(stiffness, (COPIES, 1))
    models = {name: so.Model(lattice, effects) for name, effects in effects_of(lattice).items()}
    rows = measure({name: lambda m=model: m.solve_many(candidates, cases) for name, model in models.items()}, rounds)
    print(f"\n| {' x '.join(map(str, shape))}: effect | ms | to springs alone | evaluations | answers |")
    print("|---|---|---|---|---|")
    for name, (milliseconds, ratio, low, high) in rows.items():
        batch = models[name].solve(stiffness, cases).batch
        found = sum(status.has_equilibrium for status in batch.status[0])
        evaluations = f"{np.mean(batch.iterations):.1f}"
        print(
            f"| {name} | {milliseconds:.3g} | {ratio:.2f} ({low:.2f} to {high:.2f}) | {evaluations} | "
            f"{found} of {len(cases)} |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=15)
    rounds = parser.parse_args().rounds
    for shape in GRIDS.values():
        compare_physics(shape, rounds)
    for shape in GRIDS.values():
        compare_effects(shape, rounds)


if __name__ == "__main__":
    main()
