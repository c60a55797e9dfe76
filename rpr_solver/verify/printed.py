"""Printed decimals: what number may stand behind a text that is correctly rounded."""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

from rpr_solver.errors import InputError, shown
from rpr_solver.verify.intervals import Interval

_DECIMAL = re.compile(r"(-?)(\d{1,20000})(?:\.(\d{1,20000}))?(?:e([+-]?\d{1,4}))?")


@dataclass(frozen=True)
class Printed:
    """A printed decimal: its value, half a unit of its last digit, and its number of significant digits."""

    text: str
    value: Fraction
    half: Fraction
    digits: int

    @classmethod
    def of(cls, text: object, field: str) -> Printed:
        """Reads a decimal.

        Raises:
            InputError: naming ``field``: not a decimal.
        """
        match = _DECIMAL.fullmatch(text) if isinstance(text, str) and len(text) <= 20_020 else None
        if match is None:
            raise InputError.of(field, f"{shown(text)} is not a decimal as documents print it")
        sign, whole, part, exponent = match.groups()
        places = int(exponent or 0) - len(part or "")
        number = int(Decimal(whole + (part or "")))  # int() alone reads 4300 digits at most
        unit = Fraction(10) ** places
        half = Fraction(0) if text == "0" else unit / 2  # "0" is exact
        digits = len((whole + (part or "")).lstrip("0")) or 1
        return cls(str(text), (-number if sign else number) * unit, half, digits)

    @property
    def is_zero(self) -> bool:
        """Whether the text is an exact zero."""
        return self.text == "0"

    @property
    def lower(self) -> Fraction:
        """The least number that may stand behind the text."""
        return self.value - self.half

    @property
    def upper(self) -> Fraction:
        """The greatest number that may stand behind the text."""
        return self.value + self.half

    def below(self, x: Fraction) -> bool | None:
        """Whether the number behind the text is less than another; None if its digits leave that open."""
        if self.upper < x:
            return True
        return False if x < self.lower or not self.half else None

    def above(self, x: Fraction) -> bool | None:
        """Whether the number behind the text is greater than another; None if its digits leave that open."""
        if x < self.lower:
            return True
        return False if self.upper < x or not self.half else None

    def rounds(self, x: Interval, turn: int = 0) -> bool | None:
        """Whether every number of an interval, perhaps after turns of ``turn``, rounds to the text.

        True only if all are strictly within half a unit; False if none is; None if that is open.
        """
        shift = round((self.value - x.middle) / turn) * turn if turn else 0
        lower, upper = self.lower - shift, self.upper - shift
        if x.inside(lower, upper):
            return True
        unit = 1 << x.bits
        return False if x.upper < lower * unit or x.lower > upper * unit else None
