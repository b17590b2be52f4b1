"""Motion of many small systems: eight at a time, whatever candidate and load case they belong to."""

from typing import Any

from springopt.effects.compile import compiled
from springopt.effects.lanes import splat
from springopt.forward.factor import factorize, substitute
from springopt.forward.motion.evaluation import evaluate_motion
from springopt.forward.motion.steps import judge_motions, step_on, take_up_motions


@compiled
def follow_motions(plan: Any, jobs: Any, motion: Any, answers: Any, options: Any, ways: Any) -> None:
    """Answer all jobs; `ways` as in `plan.ways_of`."""
    while take_up_motions(plan, jobs, motion, options):
        evaluate_motion(plan, motion, ways, options.is_midpoint)
        if judge_motions(plan, jobs, motion, answers, options):
            factorize(plan, motion.tangent, motion.inverse, motion.scaled, motion.scale, splat(1.0), motion.inertia)
            substitute(plan, motion.tangent, motion.inverse, motion.unknowns)
            step_on(plan, motion)
