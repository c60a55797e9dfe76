"""Lengths of documents in metres, which robots are described in."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from types import MappingProxyType

from rpr_solver.errors import InputError, shown
from rpr_solver.exact.numerals import double

METRES: Mapping[str, Fraction] = MappingProxyType(
    {"m": Fraction(1), "cm": Fraction(1, 100), "mm": Fraction(1, 1000), "in": Fraction(254, 10_000)}
)
"""Units of length, in metres; an inch is 25.4 mm (ISO 80000-3)."""


def metres_of(unit: str | None) -> Fraction:
    """A unit of a geometry in metres.

    Raises:
        InputError: naming ``unit``: it is unknown, or was not told, as documents do not tell it.
    """
    if unit is not None and unit in METRES:
        return METRES[unit]
    fault = "is missing, and documents do not tell it" if unit is None else f"is {shown(unit)}"
    raise InputError.of("unit", f"{fault}; give the unit of the geometry's lengths: {', '.join(METRES)}")


def in_metres(number: str, unit: Fraction) -> float:
    """The nearest double of a length of a document, in metres."""
    return double(Fraction(number) * unit)
