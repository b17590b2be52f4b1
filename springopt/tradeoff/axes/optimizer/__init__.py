"""The axis *optimizer*: how fast each installed one comes down to the floor of the scene.

A setting is an optimizer that is stopped after so many seconds of the processor; its error is what is left of the way
from a start that needs no search to the lowest value known: 1 at the start, 0 at the floor, on a scale that knows no
units. Every run is one seed. One that was content before that time counts with the time it took.
"""

from springopt.tradeoff.axes.optimizer.measure import measure
from springopt.tradeoff.point import Axis

AXIS = Axis(
    name="optimizer",
    title="Optimizers: the objective above the floor",
    error="objective above the floor, over that of a start without search",
    time="one run",
    missing=lambda scene: None,
    measure=measure,
    shown=("evaluations", "solves", "overhead_share"),
    is_part=False,
)
