"""Answers for others: programs of computer algebra that check them, tables and references for papers, and
descriptions for robots."""

from rpr_solver.exports.latex import bibtex, latex_table

__all__ = [
    "bibtex",
    "latex_table",
]
