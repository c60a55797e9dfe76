"""Figures of answers: documents in, pictures by matplotlib out.

This room stands above all others of the solver.
"""

from rpr_solver.figures.views import figure_of

__all__ = [
    "figure_of",
]
