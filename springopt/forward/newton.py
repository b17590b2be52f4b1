"""Static equilibria of many candidates and load cases, eight at a time: exact Newton, lane by lane.

Each lane carries one equilibrium: evaluate energy, residual and tangent at a trial state; accept it or shorten the
step; factorize and step on. A lane that is done takes up the next job at once, so a stubborn equilibrium holds up no
other; threads draw from the same jobs. Steps are accepted by the energy, so the search descends to a minimum; it ends
only where the tangent's inertia certifies one. At a stationary point with a negative pivot it goes on along the
direction of negative curvature that the factor yields.
"""

from typing import Any

from numba import njit

from springopt.effects.compile import compiled
from springopt.effects.lanes import LANE_COUNT, load
from springopt.forward.certificate import SADDLE, certify, safe_pivot
from springopt.forward.courses import keep_accepted, measure_direction, move, set_courses, take_directions
from springopt.forward.evaluation import evaluate
from springopt.forward.factor import factorize, substitute
from springopt.forward.judges import judge_lanes, settle
from springopt.forward.queue import refill
from springopt.forward.state import ACCEPTED, CERTIFYING, PHASE, REPLACEMENT, VERDICT
from springopt.forward.status import CONVERGED


@compiled
def find_equilibria(plan: Any, jobs: Any, state: Any, answers: Any, tolerance: float, iteration_limit: int) -> None:
    """Answer all jobs. `tolerance` is relative to the largest force: loads, reactions and prestress."""
    while refill(plan, jobs, state):
        evaluate(plan, state)
        judge_lanes(plan, state, answers, tolerance, iteration_limit)
        keep_accepted(state)
        _find_directions(plan, state, tolerance)
        set_courses(plan, state, answers)
        move(plan, state)


@njit(error_model="numpy")
def _find_directions(plan: Any, state: Any, tolerance: float) -> None:
    """Newton directions, verdicts on stationary points, and the way down from saddles."""
    lane = state.scalars
    replacement = load(lane, REPLACEMENT)
    factorize(plan, state.tangent, state.inverse, state.scaled, state.scale, replacement, state.inertia)
    substitute(plan, state.tangent, state.inverse, state.unknowns)
    take_directions(state)
    settle(plan, state, tolerance)
    for v in range(LANE_COUNT):
        if lane[PHASE, v] == CERTIFYING and lane[ACCEPTED, v] == 1.0:
            lane[VERDICT, v] = CONVERGED
            if not state.inertia[2, v] > safe_pivot(lane, plan.step_limit, v):
                lane[VERDICT, v] = certify(plan, state, v)
            if lane[VERDICT, v] == SADDLE:
                for at in range(len(state.direction)):
                    state.direction[at, v] = state.unknowns[at, v]
                measure_direction(state, v)
