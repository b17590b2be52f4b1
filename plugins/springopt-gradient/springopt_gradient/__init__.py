"""Optimizers that use derivatives: Gauss-Newton, L-BFGS-B, and a path to fewer springs."""

from springopt_gradient.gauss_newton import GaussNewton
from springopt_gradient.l_bfgs_b import LBFGSB
from springopt_gradient.sparse_path import SparsePath

__all__ = ["LBFGSB", "GaussNewton", "SparsePath"]
