"""What a generation of ten candidates costs beside the solve: encoding, checks, digest, journal, bookkeeping.

    ./run python benchmarks/overhead.py

Method: an objective that costs nothing, generations of 10 candidates through a `Problem` with a `Journal` on disk, as
`springopt solve` has it; processor seconds of 2,000 generations over 2,000, median and range of 7 repeats. The
objective and the making of the candidates are measured alone and subtracted.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from springopt.budget import Budget
from springopt.encoding import Binary, Real
from springopt.journal import Journal
from springopt.lattice import SpringLattice
from springopt.problem import Encoding, Problem
from springopt.run import Order
from springopt.testing import Bowl

GENERATIONS = 2000
CANDIDATES = 10
REPEATS = 7


def processor_milliseconds(work: Callable[[], object]) -> float:
    """Processor time of one generation."""
    start = time.process_time()
    for _ in range(GENERATIONS):
        work()
    return 1e3 * (time.process_time() - start) / GENERATIONS


def overhead(encoding: Encoding, folder: Path) -> float:
    """Milliseconds that a generation takes beside making the candidates and the objective."""
    rng = np.random.default_rng(0)
    bowl = Bowl(np.zeros(encoding.decode(encoding.lower).size))
    stiffness = encoding.decode(encoding.sample(rng, CANDIDATES))
    bare = processor_milliseconds(lambda: bowl.evaluate(stiffness)) + processor_milliseconds(
        lambda: encoding.sample(rng, CANDIDATES)
    )
    order = Order(scene="{}", optimizer="none", options={}, seed=0, budget={}, origin={})
    with Journal.create(folder / "overhead.journal", order) as journal:
        problem = Problem(bowl, encoding, Budget(evaluations=GENERATIONS * CANDIDATES), journal)
        whole = processor_milliseconds(lambda: problem.evaluate(problem.sample(rng, CANDIDATES)))
        journal.delete()
    return whole - bare


def main() -> None:
    plane, solid = SpringLattice.grid((5, 5)), SpringLattice.grid((4, 4, 4))
    encodings = {
        "real, 72 springs": Real(plane, lower=0.0, upper=10.0, threshold=0.5),
        "binary, 468 springs": Binary(solid, stiffness=5.0),
    }
    print(f"beside the solve, per generation of {CANDIDATES} candidates, milliseconds of processor time")
    for name, encoding in encodings.items():
        with tempfile.TemporaryDirectory() as folder:
            times = [overhead(encoding, Path(folder)) for _ in range(REPEATS)]
        print(f"{name:20} median {statistics.median(times):.3f}, from {min(times):.3f} to {max(times):.3f}")


if __name__ == "__main__":
    main()
