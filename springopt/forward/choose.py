"""Which engine a group of load cases gets, and the sentence why.

Milliseconds of processor time an equilibrium, grids with one side held, moderate loads, stiffness from U(0.5, 10),
six load cases a candidate (AMD EPYC, one core); "work" is unknowns x half-bandwidth^2, about one band factor:

| grid | unknowns | half-bandwidth | work | lanes | sparse: band | sparse: superlu |
|---|---|---|---|---|---|---|
| 10 x 10 | 180 | 21 | 8e4 | 0.07 | 0.98 | 2.0 |
| 24 x 24 | 1,104 | 49 | 3e6 | 1.8 | 3.2 | 12 |
| 4 x 4 x 4 | 144 | 50 | 4e5 | 0.09 | 0.46 | 1.3 |
| 5 x 5 x 5 | 300 | 77 | 2e6 | 0.37 | 0.79 | 4.2 |
| 6 x 6 x 6 | 540 | 110 | 7e6 | 1.8 | 1.6 | 10 |
| 7 x 7 x 7 | 882 | 149 | 2e7 | 6.5 | 3.5 | 20 |
| 8 x 8 x 8 | 1,344 | 194 | 5e7 | 18 | 6.6 | 38 |
| 10 x 10 x 10 | 2,700 | 302 | 2e8 | 76 | 15 | 96 |

So lanes end at a work of 1e7. Larger ones, seconds for two load cases of one candidate, certified (gigabytes at most):

| grid | unknowns | half-bandwidth | work | band | superlu | multigrid |
|---|---|---|---|---|---|---|
| 16 x 16 x 16 | 11,520 | 770 | 7e9 | 0.66 (0.4) | 3.1 (0.6) | 2.0 (0.3) |
| 24 x 24 x 24 | 39,744 | 1,730 | 1e11 | 11 (1.1) | 34 (2.8) | 10 (0.5) |
| 200 x 200 | 79,600 | 401 | 1e10 | 9.7 (0.8) | 15 (1.0) | 11 (0.4) |

So a band is factorized while that costs at most 2e11 operations and a gigabyte. Beyond it SuperLU's factors are slower
than multigrid but certify a minimum, up to 100,000 unknowns, where they outgrow a desk's memory.
"""

from dataclasses import dataclass

from springopt.errors import UserError, did_you_mean
from springopt.forward.band import BandSolver, half_bandwidth
from springopt.forward.engine import Engine
from springopt.forward.lanes import LanesEngine
from springopt.forward.linear import LinearEngine
from springopt.forward.linear_lanes import LinearLanesEngine
from springopt.forward.plan import Plan
from springopt.forward.solver import Solver
from springopt.forward.sparse import SparseEngine

ENGINES = ("lanes", "sparse", "iterative")
KINEMATICS = ("exact", "linear")

LANES_WORK = 1e7
BAND_WORK = 2e11
BAND_ENTRIES = 1.25e8  # a gigabyte
DIRECT_UNKNOWNS = 100_000


@dataclass(frozen=True)
class Choice:
    """An engine and its solver by name, and why."""

    engine: str  #: one of ENGINES, or "linear"
    solver: str  #: "lanes", "band", "superlu" or "multigrid"
    unknowns: int
    half_bandwidth: int
    why: str  #: one sentence


def choose(plan: Plan, kinematics: str = "exact", engine: str | None = None) -> Choice:
    """The engine for one set of supports; `engine` asks for one by name."""
    unknowns, width = len(plan.first) * plan.dimension, half_bandwidth(plan)
    name, why = _by_size(unknowns, width, kinematics)
    if engine is not None and (engine, kinematics) != ("lanes", "linear"):
        name, why = engine, f"The {engine} engine was asked for"
    solver, how = _solver_by_size(name, unknowns, width)
    engine_name = "linear" if kinematics == "linear" else name
    if engine is None and engine_name == "linear" and _suits_lanes(plan, unknowns, width):
        solver, how = "lanes", "eight candidates at a time are factorized"
    return Choice(engine_name, solver, unknowns, width, f"{why}; {how}.")


def require_known(kinematics: str, engine: str | None) -> None:
    """Refuses names that there are not."""
    for key, name, known in (("kinematics", kinematics, KINEMATICS), ("engine", engine, (*ENGINES, None))):
        if name not in known:
            names = ", ".join(str(each) for each in known if each is not None)
            hint = did_you_mean(str(name), [str(each) for each in known])
            raise UserError(f"{key} must be one of {names}, not {name!r}.{hint}")


def make_engine(choice: Choice, plan: Plan, whole: Plan | None) -> Engine:
    """The engine that was chosen; `whole` is the plan without supports, for small displacements."""
    if choice.engine == "lanes":
        return LanesEngine(plan)
    if choice.solver == "lanes":
        assert whole is not None  # small displacements alone ask for lanes in this way
        return LinearLanesEngine(plan, LinearEngine(plan, whole, BandSolver(plan)))
    solver = _make_solver(choice.solver, plan)
    return SparseEngine(plan, solver) if whole is None else LinearEngine(plan, whole, solver)


def _by_size(unknowns: int, width: int, kinematics: str) -> tuple[str, str]:
    """The engine's name, and the first half of the sentence."""
    work = _work(unknowns, width)
    size = f"{unknowns:,} unknowns with a half-bandwidth of {width:,}"
    if unknowns > DIRECT_UNKNOWNS and not _fits_band(unknowns, width):
        return (
            "iterative",
            f"{size} are beyond direct factors (more than {DIRECT_UNKNOWNS:,} unknowns in too wide a band)",
        )
    if kinematics == "linear":
        return "sparse", f"Displacements are small: {size} take one factor a candidate, which all load cases share"
    if work <= LANES_WORK:
        return "lanes", f"{size} make a factor of {work:.0e} operations, at most {LANES_WORK:.0e}: a small system"
    return "sparse", f"{size} make a factor of {work:.0e} operations, more than {LANES_WORK:.0e}: a large system"


def _solver_by_size(engine: str, unknowns: int, width: int) -> tuple[str, str]:
    """The solver's name, and the second half of the sentence."""
    if engine == "lanes":
        return "lanes", "eight equilibria at a time go through exact Newton steps"
    if engine == "iterative" and unknowns:
        return "multigrid", "multigrid preconditions, and the smallest eigenvalues found speak for a minimum"
    if _fits_band(unknowns, width):
        return "band", "its band is factorized"
    return "superlu", "its band would be too wide, so that SuperLU factorizes it in nested dissection order"


def _suits_lanes(plan: Plan, unknowns: int, width: int) -> bool:
    """Whether small displacements are found in lanes: of small systems, and of springs alone."""
    return _work(unknowns, width) <= LANES_WORK and not len(plan.potentials.table)


def _work(unknowns: int, width: int) -> float:
    """Operations of one band factor."""
    return float(unknowns) * width**2


def _fits_band(unknowns: int, width: int) -> bool:
    return _work(unknowns, width) <= BAND_WORK and float(unknowns) * width <= BAND_ENTRIES


def _make_solver(name: str, plan: Plan) -> Solver:
    match name:
        case "band":
            return BandSolver(plan)
        case "superlu":
            from springopt.forward.superlu import SuperLUSolver

            return SuperLUSolver(plan)
    from springopt.forward.multigrid import MultigridSolver

    return MultigridSolver(plan)
