"""Answers found without the forward solve, in NumPy and SciPy: what judges it must not be its own code."""
