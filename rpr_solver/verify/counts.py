"""The number of cusps of a slice, from the exact eliminant alone."""

from __future__ import annotations

from fractions import Fraction

from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.manipulator import Geometry
from rpr_solver.verify.surds import Indivisible
from rpr_solver.verify.system import System


def cusps_counted(geometry: Geometry, fixed: int, length: Fraction) -> tuple[int, bool] | None:
    """The number of cusps on lines that hold one pose each, and whether these are certainly all.

    They are all where every root of Q is simple and apart from the spurious ones; else cusps may lie on other
    lines too. None if the resultant says nothing.
    """
    return count_of(System.of(geometry, fixed, length))


def count_of(system: System) -> tuple[int, bool] | None:
    """As :func:`cusps_counted`, of a slice."""
    try:
        eliminant = Eliminant.of(system)
    except Indivisible:
        return None
    if not eliminant.form:
        return None
    return len(eliminant.single_roots), eliminant.generic


def simplest_between(low: Fraction, high: Fraction) -> Fraction:
    """The decimal of fewest places strictly between two numbers.

    >>> simplest_between(Fraction(1, 3), Fraction(1, 2))
    Fraction(2, 5)
    """
    unit = Fraction(1)
    while True:
        candidate = (low // unit + 1) * unit
        if low < candidate < high:
            middle = round((low + high) / 2 / unit) * unit
            return middle if low < middle < high else candidate
        unit /= 10
