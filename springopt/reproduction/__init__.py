"""The paper from nothing: each figure and table of Bianchi et al. (2004) as runs, numbers, pictures and a verdict."""
