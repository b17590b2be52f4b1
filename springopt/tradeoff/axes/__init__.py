"""The axes, one a file."""
