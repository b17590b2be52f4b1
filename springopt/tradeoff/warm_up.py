"""What the first measurement on a machine would pay for all: kernels that are compiled, once, for any scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from springopt.effects.damping import Damping
from springopt.effects.inertia import Inertia
from springopt.forward.motion.stepping import INTEGRATORS, Stepping
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.model import Model
from springopt.objective import Objective


def compile_kernels(*, in_motion: bool) -> None:
    """Has every engine solve nine nodes, and a gradient taken; also in motion, where that will be measured."""
    lattice = SpringLattice.grid((3, 3))
    forces = np.where(side(lattice, "right")[:, None], [0.1, 0.0], 0.0)
    case = LoadCase("pull", supports=side(lattice, "left"), forces=forces)
    moving = replace(case, times=np.array([0.1]))
    stiffness = np.ones(lattice.spring_count)
    effects = [Inertia(density=1.0), Damping(springs=0.1)]
    for engine in ("lanes", "sparse"):
        still = Model(lattice, engine=engine)
        for model in (still, replace(still, kinematics="linear")):
            model.solve(stiffness, [case])
        Objective(still, [case], lattice.nodes[None]).gradient(stiffness)
        for integrator in INTEGRATORS if in_motion else ():
            stepping = Stepping(0.1, integrator=integrator)
            Model(lattice, effects, engine=engine, stepping=stepping).solve(stiffness, [moving])
    Model(lattice, kinematics="linear").solve(stiffness, [case])
