"""A manipulator by its exact triangles, as documents give it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import isqrt
from typing import Any, TypeAlias

from flint import acb, arb

from rpr_solver.contract import FIXED_LEGS, LENGTHS
from rpr_solver.verify.claims import Open
from rpr_solver.verify.numbers import NOT_NEGATIVE, ball, exact, square_of
from rpr_solver.verify.reader import Read, record, refusal, rows, word

_NUMBERS: dict[str, Read] = dict.fromkeys(LENGTHS[:3], exact) | dict.fromkeys(LENGTHS[3:], NOT_NEGATIVE)
_SENSE = word("ccw", "cw")
_MEMBERS = record({**_NUMBERS, "orientation": _SENSE})
_SIDES = rows(square_of, 3, 3)
_PAIR = record(
    {"base": _SIDES, "base_orientation": _SENSE, "platform": _SIDES, "platform_orientation": _SENSE}
)

Squares: TypeAlias = tuple[Fraction, Fraction, Fraction]
"""The squares of the sides 12, 23 and 31 of a triangle."""


@dataclass(frozen=True)
class Geometry:
    """Base A1A2A3 and platform B1B2B3, with A1 = (0, 0) and A2 on the x-axis.

    Seen from B1, B2 is in the direction of the platform's angle α; B3 is on the left of it, or on its right
    if the platform is clockwise.

    Attributes:
        base_squares, platform_squares: the squared sides.
        base_clockwise, clockwise: the senses of base and platform.
        half_turn: whether A2 is at a negative x; only with six rational numbers.
        texts: the numbers as a document has them, lists with commas between.
    """

    base_squares: Squares
    platform_squares: Squares
    base_clockwise: bool
    clockwise: bool
    half_turn: bool = False
    texts: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def of_lengths(
        cls, numbers: Sequence[Fraction], *, clockwise: bool, texts: Mapping[str, str] | None = None
    ) -> Geometry:
        """From a2x, a3x, a3y, d1, d2 and d3: A2 = (a2x, 0), A3 = (a3x, a3y), sides of the platform."""
        a2x, a3x, a3y, d1, d2, d3 = numbers
        base = a2x**2, (a3x - a2x) ** 2 + a3y**2, a3x**2 + a3y**2
        return cls(base, (d1**2, d2**2, d3**2), a2x * a3y < 0, clockwise, a2x < 0, texts or {})

    @classmethod
    def read(cls, value: object, at: str) -> Geometry:
        """The member ``geometry`` of a document: six numbers, or the sides of two triangles.

        Raises:
            InputError: naming what is missing or impossible.
        """
        if isinstance(value, Mapping) and "base" in value:
            return cls._of_sides(_PAIR(value, at), value, at)
        members = _MEMBERS(value, at)
        texts = {name: str(value[name]) for name in (*LENGTHS, "orientation")}  # type: ignore[index]
        numbers = [members[name] for name in LENGTHS]
        result = cls.of_lengths(numbers, clockwise=members["orientation"] == "cw", texts=texts)
        if _area16(result.platform_squares) < 0 or not any(result.platform_squares):
            raise refusal(f"{at}/d1", "d1, d2 and d3 are not the sides of a triangle")
        if not any(result.base_squares):
            raise refusal(f"{at}/a2x", "the corners of the base coincide")
        if not members["a2x"] and (members["a3y"] or members["a3x"] < 0):
            raise refusal(f"{at}/a2x", "with A1 = A2 the x-axis leads through A3")
        return result

    @classmethod
    def _of_sides(cls, members: Mapping[str, Any], value: Mapping[str, Any], at: str) -> Geometry:
        names = ("base", "platform")
        for name in names:
            if _area16(members[name]) < 0 or not any(members[name]):
                raise refusal(f"{at}/{name}", "these are not the sides of a triangle")
        base, platform = (members[name] for name in names)
        turns = [members[f"{name}_orientation"] == "cw" for name in names]
        texts = {name: x if isinstance(x, str) else ",".join(x) for name, x in value.items()}
        result = cls(base, platform, turns[0], turns[1], texts=texts)
        if all(length.root is not None for length in (*result._base, *result._sides)):
            raise refusal(at, "has rational lengths alone, which documents give as six numbers")
        return result

    @property
    def hash(self) -> str:
        """The hash that a document with it should have."""
        text = ";".join(f"{name}={text}" for name, text in sorted(self.texts.items()))
        return "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()

    @cached_property
    def _base(self) -> tuple[_Length, _Length, _Length]:
        """a2x, a3x and a3y."""
        a, b, c = self.base_squares
        if not a:
            return _Length.of(a, 0), _Length.of(c, 1), _Length.of(a, 0)
        sign = -1 if self.half_turn else 1
        # a3x = (a + c - b) / (2 a2x), and a3y² = H / (4 a)
        along, height = a + c - b, _area16(self.base_squares) / (4 * a)
        # the sense of the base is that of a2x and a3y together
        side = -sign if self.base_clockwise else sign
        return (
            _Length.of(a, sign),
            _Length.of(along**2 / (4 * a), sign if along > 0 else -sign),
            _Length.of(height, side),
        )

    @cached_property
    def _sides(self) -> tuple[_Length, _Length, _Length]:
        first, second, third = (_Length.of(square, 1) for square in self.platform_squares)
        return first, second, third

    @property
    def lengths(self) -> dict[str, Fraction]:
        """The six numbers.

        Raises:
            Open: one of them is irrational.
        """
        numbers = dict(zip(LENGTHS, (*self._base, *self._sides), strict=True))
        known = {name: length.root for name, length in numbers.items() if length.root is not None}
        if len(known) < len(numbers):
            raise Open("a length of the geometry is irrational")
        return known

    @property
    def base(self) -> tuple[acb, acb, acb]:
        """The corners of the base."""
        a2x, a3x, a3y = (length.ball() for length in self._base)
        return acb(0), acb(a2x), acb(a3x, a3y)

    @cached_property
    def _platform(self) -> tuple[_Length, _Length]:
        """B3 as seen from B1, along B1B2 and across, by the law of cosines; where B1 = B2, along B1B3."""
        a, b, c = self.platform_squares
        if not a:
            return _Length.of(c, 1), _Length.of(a, 0)
        along = a + c - b
        height = _Length.of(_area16(self.platform_squares) / (4 * a), -1 if self.clockwise else 1)
        return _Length.of(along**2 / (4 * a), 1 if along > 0 else -1), height

    @property
    def platform(self) -> tuple[acb, acb, acb]:
        """The corners of the platform at α = 0, with B1 in the origin."""
        x, y = (length.ball() for length in self._platform)
        return acb(0), acb(self._sides[0].ball()), acb(x, y)

    @cached_property
    def size(self) -> int:
        """The exponent of a power of 2 that exceeds all sides, but is not twice as great as their sum."""
        whole = sum(abs(length.near()) for length in (*self._base, *self._sides))
        n, d = whole.as_integer_ratio()
        return n.bit_length() - d.bit_length() + 1

    def free_legs(self, fixed: int) -> tuple[int, int]:
        """The legs whose lengths vary."""
        first, second = (leg for leg in FIXED_LEGS if leg != fixed)
        return first, second

    @cached_property
    def is_similar_pair(self) -> bool:
        """Whether the platform is a turned and scaled copy of the base: their slices have no cusps.

        The squared sides are proportional, and the senses agree; of flat triangles there is no sense
        (mathematics.md#special-shapes).
        """
        base, platform = self.squared_sides
        if self.has_shared_joints:
            return False
        ratio = platform[1, 2] / base[1, 2]
        proportional = all(x * ratio == platform[key] for key, x in base.items())
        return proportional and (self.is_base_flat or self.base_clockwise == self.clockwise)

    @property
    def has_shared_joints(self) -> bool:
        """Whether two corners of a triangle are one point."""
        return 0 in self.base_squares or 0 in self.platform_squares

    @cached_property
    def squared_sides(self) -> tuple[dict[tuple[int, int], Fraction], dict[tuple[int, int], Fraction]]:
        """The squared distances of the corners of the base, and of the platform, by two numbers of legs."""
        base, platform = (
            dict(zip(((1, 2), (2, 3), (1, 3)), squares, strict=True))
            for squares in (self.base_squares, self.platform_squares)
        )
        both = [{**x, **{(k, i): y for (i, k), y in x.items()}} for x in (base, platform)]
        return both[0], both[1]

    @property
    def is_base_flat(self) -> bool:
        """Whether the corners of the base are on a line."""
        return _area16(self.base_squares) == 0

    @property
    def is_platform_flat(self) -> bool:
        """Whether the corners of the platform are on a line."""
        return _area16(self.platform_squares) == 0

    @cached_property
    def is_singular_pair(self) -> bool:
        """Whether both triangles are flat, or they are mirrored: poses are degenerate at all lengths then."""
        base, platform = self.squared_sides
        flat = self.is_base_flat and self.is_platform_flat
        return flat or (base == platform and not self.is_similar_pair)


@dataclass(frozen=True)
class _Length:
    """A number with a rational square: its square, its sign, and the number itself if it is rational."""

    square: Fraction
    sign: int
    root: Fraction | None

    @classmethod
    def of(cls, square: Fraction, sign: int) -> _Length:
        """From the square and the sign."""
        n, d = (isqrt(part) for part in square.as_integer_ratio())
        root = Fraction(n, d) * sign
        return cls(square, sign, root if root**2 == square else None)

    def ball(self) -> arb:
        """The number at the working precision."""
        return self.sign * ball(self.square).sqrt() if self.root is None else ball(self.root)

    def near(self) -> Fraction:
        """The number itself, or one that is less by at most a part in 2^64."""
        if self.root is not None:
            return self.root
        n, d = self.square.as_integer_ratio()
        shift = max(0, 128 - n.bit_length() - d.bit_length())
        # √(n / d) = √(n d) / d
        return Fraction(self.sign * isqrt(n * d << 2 * shift), d << shift)


def _area16(squares: Squares) -> Fraction:
    """16 times the squared area of a triangle (Heron); negative if there is none with these sides."""
    a, b, c = squares
    return 4 * a * c - (a + c - b) ** 2
