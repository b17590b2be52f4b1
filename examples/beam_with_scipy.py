"""A cantilever learned with SciPy's L-BFGS-B and adjoint gradients: the library without scenes and plugins.

    ./run python examples/beam_with_scipy.py

The body is a beam of 8 x 2 finite elements, held at its left end, pulled and bent at its right one. Prints the misfit
before and after, and the mean stiffness of each class of springs.
"""

import numpy as np
from scipy.optimize import OptimizeResult, minimize

import springopt as so


def main() -> tuple[so.Objective, OptimizeResult]:
    lattice = so.SpringLattice.grid((9, 3))
    body = so.FemReference(lattice, young=10.0, poisson=0.3)
    left, right = so.side(lattice, "left"), so.side(lattice, "right")
    cases = [
        so.LoadCase(name, supports=left, forces=np.where(right[:, None], force, 0.0))
        for name, force in {"pull": [0.4, 0.0], "bend up": [0.0, 0.01], "bend down": [0.0, -0.01]}.items()
    ]
    positions = [body.deform(case) for case in cases]
    objective = so.Objective(so.Model(lattice), cases, positions, minimize="least-squares")

    start = np.full(lattice.spring_count, 4.0)
    bounds = [(0.5, 20.0)] * lattice.spring_count
    found = minimize(objective.gradient, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 300})

    print(f"half the sum of squares: {objective.gradient(start)[0]:.3g} at 4.0 everywhere, {found.fun:.3g} found")
    for name, springs in {
        "inner straight": lattice.straight & ~lattice.boundary,
        "boundary straight": lattice.straight & lattice.boundary,
        "diagonal": ~lattice.straight,
    }.items():
        print(f"{name}: {found.x[springs].mean():.2f}")
    for error in objective.errors(found.x):
        print(f"{error.name}: nodes off by {error.distance:.2g} in the mean, {error.max_distance:.2g} at most")
    return objective, found


if __name__ == "__main__":
    main()
