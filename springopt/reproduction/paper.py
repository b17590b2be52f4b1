"""What the paper reports, each number as it is printed and where.

G. Bianchi, B. Solenthaler, G. Székely, M. Harders, "Simultaneous Topology and Stiffness Identification for Mass-Spring
Models Based on FEM Reference Deformations", MICCAI 2004.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Published:
    """A number as printed: its last digit says how exactly it is known."""

    printed: str
    where: str

    @property
    def value(self) -> float:
        return float(self.printed)

    @property
    def rounding(self) -> float:
        """Half a unit of the last digit; a count has none."""
        decimals = len(self.printed.partition(".")[2])
        return 0.5 * 10**-decimals if decimals else 0.0


SPRINGS_3D = Published("463", "section 3.2")  #: found, of 468
ERROR_3D = Published("0", "section 3.2")  #: "the normalized difference of point positions ... is equal to zero"

MEAN_STIFFNESS = Published("5.01", "section 4.2")
SPREAD_OF_STIFFNESS = Published("0.65", "section 4.2")
SPRINGS_2D = Published("72", "section 4.2")  #: "the complete topology"

#: Mean distance of the nodes over the smallest rest length: four of the twelve training cases, and three test cases.
TRAINING_ERRORS = tuple(Published(error, "Figure 3") for error in ("0.08", "0.08", "0.02", "0.02"))
TEST_ERRORS = tuple(Published(error, "Figure 3") for error in ("0.04", "0.01", "0.05"))
MEAN_TRAINING_ERROR = Published("0.05", "Figure 3, mean of the four")
MEAN_TEST_ERROR = Published("0.03", "Figure 3, mean of the three")

#: Final cost of each limitation.
COSTS = {
    "homogeneous": Published("0.85", "Table 1"),
    "two-class": Published("0.73", "Table 1"),
    "unrestricted": Published("0.58", "Table 1"),
}
ALL_SPRINGS = Published("4.07", "Table 1")
STRAIGHT = Published("4.76", "Table 1")
DIAGONAL = Published("3.35", "Table 1")

#: The intervals of the two peaks of Figure 4, as Table 1 calls them.
PEAKS = ((3.0, 4.0), (6.0, 8.0))
