"""Figures of answers: documents in, scenes of simple shapes out.

This room stands above all others of the solver.
"""

from rpr_solver.figures.views import figure_of

__all__ = [
    "figure_of",
]
