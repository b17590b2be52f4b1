"""Stiffness from the command line: a number, or a file with one number for each spring."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from springopt.errors import UserError

if TYPE_CHECKING:
    from springopt.checks import Floats


def read_stiffness(given: str, spring_count: int) -> Floats:
    """Stiffness [force/length], shape (s,), finite and not negative."""
    import numpy as np

    from springopt.checks import floats, require_nonnegative, require_shape

    try:
        numbers = np.full(spring_count, float(given))
    except ValueError:
        numbers = floats(f"the stiffness in {given}", _read(Path(given)))
        require_shape(f"the stiffness in {given}", numbers, (spring_count,))
    return require_nonnegative("stiffness", numbers)


def _read(path: Path) -> Any:
    import numpy as np

    try:
        match path.suffix:
            case ".npy":
                return np.load(path)
            case ".json":
                contents = json.loads(path.read_text(encoding="utf-8"))
                return contents["stiffness"] if isinstance(contents, dict) else contents
            case ".csv" | ".txt":
                return np.loadtxt(path, delimiter="," if path.suffix == ".csv" else None).ravel()
    except (OSError, ValueError, KeyError) as error:
        raise UserError(f"the stiffness file {path} can't be read ({error}); give one number a spring.") from None
    raise UserError(f"--stiffness takes a number or a .npy, .csv, .txt or .json file, not {path}.")
