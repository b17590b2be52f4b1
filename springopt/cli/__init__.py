"""The command line: one command a file, imported when it is called."""

from springopt.cli.main import main

__all__ = ["main"]
