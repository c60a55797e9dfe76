"""The geometry of a document: six exact numbers, and where the corners of base and platform are."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import isqrt

from rpr_solver.verify.core.reader import POSITIVE, exact, record, refusal, word

LENGTHS = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
_READ = record(
    {
        **dict.fromkeys(LENGTHS[:3], exact),
        **dict.fromkeys(LENGTHS[3:], POSITIVE),
        "orientation": word("ccw", "cw"),
    }
)


@dataclass(frozen=True)
class Geometry:
    """A manipulator: A1 = (0, 0), A2 = (a2x, 0), A3 = (a3x, a3y); d1 = |B1B2|, d2 = |B2B3|, d3 = |B3B1|."""

    a2x: Fraction
    a3x: Fraction
    a3y: Fraction
    d1: Fraction
    d2: Fraction
    d3: Fraction
    clockwise: bool
    texts: Mapping[str, str]

    @classmethod
    def read(cls, value: object, at: str) -> Geometry:
        """Reads the member ``geometry`` of a document.

        Raises:
            InputError: naming what is missing or impossible.
        """
        numbers = _READ(value, at)
        texts = {name: str(value[name]) for name in (*LENGTHS, "orientation")}  # type: ignore[index]
        a2x, a3x, a3y, d1, d2, d3 = (numbers[name] for name in LENGTHS)
        result = cls(a2x, a3x, a3y, d1, d2, d3, numbers["orientation"] == "cw", texts)
        if result.height_squared < 0:
            raise refusal(f"{at}/d1", "d1, d2 and d3 are not the sides of a triangle")
        if len(set(result.base)) < 3:
            raise refusal(f"{at}/a2x", "two corners of the base coincide")
        return result

    @property
    def hash(self) -> str:
        """The hash that the document should have."""
        text = ";".join(f"{name}={text}" for name, text in self.texts.items())
        return "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()

    @property
    def base(self) -> tuple[tuple[Fraction, Fraction], ...]:
        """A1, A2, A3."""
        zero = Fraction(0)
        return (zero, zero), (self.a2x, zero), (self.a3x, self.a3y)

    @property
    def foot(self) -> Fraction:
        """The component of B1B3 along B1B2."""
        return (self.d1**2 + self.d3**2 - self.d2**2) / (2 * self.d1)

    @property
    def height_squared(self) -> Fraction:
        """The square of the distance of B3 from the line B1B2."""
        return self.d3**2 - self.foot**2

    @cached_property
    def height(self) -> tuple[Fraction, int]:
        """The distance of B3 from the line B1B2, positive to the left: (factor, radicand) of a root.

        The radicand is 1 where the height is rational.
        """
        square = self.height_squared
        product = square.numerator * square.denominator
        factor, radicand = 1, product
        if isqrt(product) ** 2 == product:
            factor, radicand = isqrt(product), 1
        else:
            for p in (2, 3, 5, 7, 11, 13):
                while radicand % (p * p) == 0:
                    factor, radicand = factor * p, radicand // (p * p)
        sign = -1 if self.clockwise else 1
        return Fraction(sign * factor, square.denominator), radicand

    @property
    def bits(self) -> int:
        """The size of its longest number."""
        numbers = (self.a2x, self.a3x, self.a3y, self.d1, self.d2, self.d3)
        return max(part.bit_length() for x in numbers for part in x.as_integer_ratio())

    def free_legs(self, fixed: int) -> tuple[int, int]:
        """The legs whose lengths vary while one is fixed."""
        first, second = (leg for leg in (1, 2, 3) if leg != fixed)
        return first, second

    def side_squared(self, i: int, k: int) -> Fraction:
        """|BiBk|²."""
        sides = {frozenset((1, 2)): self.d1, frozenset((2, 3)): self.d2, frozenset((1, 3)): self.d3}
        return sides[frozenset((i, k))] ** 2
