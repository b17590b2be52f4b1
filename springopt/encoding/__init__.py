"""From an optimizer's vector to stiffness and topology."""

from collections.abc import Callable

from springopt.encoding.binary import Binary
from springopt.encoding.encoding import Encoding
from springopt.encoding.grouped import Grouped, Homogeneous, ThreeClass, TwoClass
from springopt.encoding.real import Real
from springopt.encoding.with_parameters import Fitted, WithParameters

ENCODINGS: dict[str, Callable[..., Encoding]] = {
    encoding.name: encoding for encoding in (Binary, Real, Homogeneous, TwoClass, ThreeClass)
}

__all__ = [
    "ENCODINGS",
    "Binary",
    "Encoding",
    "Fitted",
    "Grouped",
    "Homogeneous",
    "Real",
    "ThreeClass",
    "TwoClass",
    "WithParameters",
]
