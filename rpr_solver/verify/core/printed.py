"""Printed decimals: what number may stand behind a text that is correctly rounded."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.verify.core.intervals import Interval


@dataclass(frozen=True)
class Printed:
    """A printed decimal: its value, and half a unit of its last digit; reader.py reads it."""

    text: str
    value: Fraction
    half: Fraction

    @classmethod
    def exact_zero(cls) -> Printed:
        """The text "0", which stands for 0 alone."""
        return cls("0", Fraction(0), Fraction(0))

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
