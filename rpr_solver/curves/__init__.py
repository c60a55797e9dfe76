"""Cusp curves: each cusp followed through all lengths of the fixed leg."""

from rpr_solver.curves.curve_set import CuspCurves, cusp_curves

__all__ = [
    "CuspCurves",
    "cusp_curves",
]
