"""The forward solve: static equilibria of many candidates and load cases, each with a status."""
