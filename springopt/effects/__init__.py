"""Physical contributions to the equilibrium, one a file; the folder listing is the list of effects."""
