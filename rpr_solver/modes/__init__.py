"""Assembly modes: which poses are joined by paths, and what that takes."""

from rpr_solver.modes.joined_regions import JoinedRegion

__all__ = [
    "JoinedRegion",
]
