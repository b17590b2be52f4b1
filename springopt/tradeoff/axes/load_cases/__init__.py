"""The axis *load-cases*: what more load cases to learn from are worth, as they are given and as they are designed.

A setting is a set of training load cases; its error is that of the identified model in the scene's test load cases,
from which no set learns, and its time that of the identification.
"""

from springopt.tradeoff.axes.load_cases.measure import measure, why_missing
from springopt.tradeoff.point import Axis

AXIS = Axis(
    name="load-cases",
    title="Load cases: so many to learn from",
    error="error in the test load cases, over the displacement",
    time="one identification",
    missing=why_missing,
    measure=measure,
    is_part=False,  # it is the model's, by another way
    shown=("unidentified", "solves", "objective_per_case"),
)
