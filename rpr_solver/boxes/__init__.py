"""All zeros of systems of functions on boxes, proved; and arrays of balls in doubles.

This room knows boxes, functions and balls, and nothing of manipulators.
"""

from rpr_solver.boxes.balls import Balls, Combinations
from rpr_solver.boxes.box import bits_of, contains
from rpr_solver.boxes.jets import Jet, monomials
from rpr_solver.boxes.prune import Search, search
from rpr_solver.boxes.sieve import Boxes, Sieved, sieved
from rpr_solver.boxes.systems import Box, Functions, System, Undecided
from rpr_solver.boxes.zeros import Zero, turned

__all__ = [
    "Balls",
    "Box",
    "Boxes",
    "Combinations",
    "Functions",
    "Jet",
    "Search",
    "Sieved",
    "System",
    "Undecided",
    "Zero",
    "bits_of",
    "contains",
    "monomials",
    "search",
    "sieved",
    "turned",
]
