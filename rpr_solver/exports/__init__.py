"""Answers for others: programs of computer algebra that check them, and tables and references for papers."""

from rpr_solver.exports.latex import bibtex, latex_table

__all__ = [
    "bibtex",
    "latex_table",
]
