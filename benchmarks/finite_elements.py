"""The finite element reference against another code: dolfinx, which agrees with SfePy and GetFEM to 1e-12.

    ./run python benchmarks/finite_elements.py

Prints the largest relative difference of the displacements for each mesh and material of tests/data/fem.
"""

import json
from pathlib import Path

import numpy as np

import springopt as so

DATA = Path(__file__).parents[1] / "tests" / "data" / "fem"
PLANE = {"plane_stress": "stress", "plane_strain": "strain", "3d": "stress"}


def main() -> None:
    print("| mesh | cells | material | load cases | largest relative difference |")
    print("|---|---|---|---|---|")
    for path in sorted(DATA.glob("*.npz")):
        data = np.load(path)
        mesh = (data["points"], data["cells"], str(data["cell_type"]))
        for material in json.loads(str(data["materials"])):
            reference = so.FemReference(mesh, young=material["E"], poisson=material["nu"], plane=PLANE[material["hyp"]])
            known = data[f"u|{material['name']}"]
            worst = 0.0
            for loads, displacements in zip(data["loads"], known, strict=True):
                case = so.LoadCase("load", data["fixed"], loads * material["E"] / float(data["E_ref"]))
                difference = reference.deform(case) - data["points"] - displacements
                worst = max(worst, np.abs(difference).max() / np.abs(displacements).max())
            print(f"| {path.stem} | {len(data['cells'])} | {material['name']} | {len(known)} | {worst:.1e} |")


if __name__ == "__main__":
    main()
