"""What a scene can tell: which springs its load cases identify, and how low its misfit can get."""
