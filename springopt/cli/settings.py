"""Options of a plugin as `--set` gives them."""

from __future__ import annotations

from springopt.errors import UserError


def settings_of(settings: tuple[str, ...]) -> dict[str, str]:
    """Each NAME=VALUE by its name."""
    options = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        if not (name and equals):
            raise UserError(f"--set takes NAME=VALUE, not {setting!r}; write for example --set population=20.")
        options[name.strip()] = value.strip()
    return options
