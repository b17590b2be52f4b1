"""Scenes of bridges; the TOML files beside this one, their floors below `floors`."""
