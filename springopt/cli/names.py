"""Names given to an option that may be repeated."""

from __future__ import annotations

import re
from collections.abc import Sequence

from springopt.errors import UserError


def split_names(option: str, given: Sequence[str]) -> list[str]:
    """The names, with commas between them; a comma within brackets belongs to a name. Empty where nothing is given."""
    names = [name.strip() for text in given for name in re.split(r",(?![^(]*\))", text) if name.strip()]
    if given and not names:
        raise UserError(f"{option} names nothing, perhaps for want of a variable; leave it out for all that there are.")
    return names
