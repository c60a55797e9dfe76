"""What is asked about angles of legs: their names and their tolerance; it loads nothing that computes."""

from __future__ import annotations

from fractions import Fraction

from rpr_solver.errors import InputError
from rpr_solver.exact.rationals import Exact, parse_positive

ANGLES = ("angle1", "angle2", "angle3")
"""The names of the legs' angles."""
LEAST = 3
"""So many data determine a pose, up to a finite number."""


def read_tolerance(tolerance: Exact | None, *, is_needed: bool) -> Fraction | None:
    """The tolerance of angles in degrees.

    Raises:
        InputError: naming ``angle_tolerance_deg``: it is missing, or not > 0.
    """
    if tolerance is None:
        if is_needed:
            raise InputError.of(
                "angle_tolerance_deg", "is missing; more than three data agree only within one"
            )
        return None
    return parse_positive(tolerance, "angle_tolerance_deg", "a tolerance must be > 0")
