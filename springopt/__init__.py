"""springopt finds the mass-spring model that deforms like a given body.

The public names load on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "Budget": "springopt.budget",
    "Encoding": "springopt.encoding",
    "FemReference": "springopt.reference.fem",
    "Gravity": "springopt.effects.gravity",
    "LoadCase": "springopt.load_case",
    "Model": "springopt.model",
    "Objective": "springopt.objective",
    "Optimizer": "springopt.optimizer",
    "Parameters": "springopt.parameters",
    "Problem": "springopt.problem",
    "Run": "springopt.run",
    "Scene": "springopt.scene",
    "SpringLattice": "springopt.lattice",
    "SpringReference": "springopt.reference.spring",
    "Status": "springopt.forward.status",
    "Stepping": "springopt.forward.stepping",
    "load_scene": "springopt.scene",
    "resume": "springopt.runner",
    "side": "springopt.lattice",
    "solve": "springopt.runner",
    "BudgetSpent": "springopt.errors",
    "NoEquilibrium": "springopt.errors",
    "SpringoptError": "springopt.errors",
    "UserError": "springopt.errors",
}

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    """The public name from the module it lives in (PEP 562)."""
    if name not in _HOME:
        raise AttributeError(f"module 'springopt' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
