"""The axis *model*: what a mass-spring model of more springs, more freedom or more nodes costs, and is worth.

A setting is a variation of the scene whose stiffness was identified; a point is its test error against the time of one
forward solve. Beside it stands the step in real time, which is what such a model is for.
"""

from springopt.tradeoff.axes.model.findings import measure, why_missing
from springopt.tradeoff.point import Axis

AXIS = Axis(
    name="model",
    title="The model: encodings, neighbourhoods, fewer springs, resolution",
    error="error in the test load cases, over the displacement",
    time="one forward solve of the identified model",
    second_time="one step in real time",
    missing=why_missing,
    measure=measure,
    shown=("springs", "training_error", "steps_per_second"),
)
