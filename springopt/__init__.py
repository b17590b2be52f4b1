"""springopt finds the mass-spring model that deforms like a given body.

The public names load on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "Bending": "springopt.effects.bending",
    "Budget": "springopt.budget",
    "Damping": "springopt.effects.damping",
    "Encoding": "springopt.encoding",
    "ExponentialStiffening": "springopt.effects.exponential_stiffening",
    "FemReference": "springopt.reference.fem",
    "Gravity": "springopt.effects.gravity",
    "Inertia": "springopt.effects.inertia",
    "LoadCase": "springopt.load_case",
    "Model": "springopt.model",
    "Objective": "springopt.objective",
    "Optimizer": "springopt.optimizer",
    "Parameters": "springopt.parameters",
    "PlaneContact": "springopt.effects.contact",
    "Prestress": "springopt.effects.prestress",
    "Problem": "springopt.problem",
    "PythonEffect": "springopt.effects.python_effect",
    "Run": "springopt.run",
    "Scene": "springopt.scene",
    "SphereContact": "springopt.effects.contact",
    "SpringLattice": "springopt.lattice",
    "SpringReference": "springopt.reference.spring",
    "Status": "springopt.forward.status",
    "Stepping": "springopt.forward.motion.stepping",
    "Stiffening": "springopt.effects.stiffening",
    "TensionOnly": "springopt.effects.tension_only",
    "Volume": "springopt.effects.volume",
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
