"""Designs: manipulators near a given one that have what is asked for."""

from rpr_solver.designs.plan import Constraints, Goal, Options, Plan, SearchStopped

__all__ = [
    "Constraints",
    "Goal",
    "Options",
    "Plan",
    "SearchStopped",
]
