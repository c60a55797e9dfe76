"""Margins: how far the lengths of a manipulator may change before a property is lost."""

from rpr_solver.margins.options import changes

__all__ = [
    "changes",
]
