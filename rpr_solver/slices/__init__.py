"""Slices: the eliminant, and all cusps at one length of the fixed leg."""

from rpr_solver.slices.eliminant import Eliminant, eliminate, kept_eliminant

__all__ = [
    "Eliminant",
    "eliminate",
    "kept_eliminant",
]
