"""Transitions: the lengths at which the number of cusps changes, the census, and checks of requirements."""

from rpr_solver.transitions.requirement import Requirement

__all__ = [
    "Requirement",
]
