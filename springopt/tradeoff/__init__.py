"""What accuracy costs in time, on a scene and a machine: settings measured along each axis that the scene has."""

from springopt.tradeoff.axes import choose_axes
from springopt.tradeoff.cheapest import Answer, find_cheapest
from springopt.tradeoff.document import document
from springopt.tradeoff.measure import Measured, Tradeoff, measure
from springopt.tradeoff.point import Axis, Findings, Point, Request, Setting

__all__ = [
    "Answer",
    "Axis",
    "Findings",
    "Measured",
    "Point",
    "Request",
    "Setting",
    "Tradeoff",
    "choose_axes",
    "document",
    "find_cheapest",
    "measure",
]
