"""Algorithms of pymoo as optimizers for springopt, one a file.

Source: J. Blank and K. Deb, pymoo: Multi-Objective Optimization in Python, IEEE Access 8 (2020).
"""
