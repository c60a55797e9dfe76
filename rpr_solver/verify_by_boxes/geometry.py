"""A manipulator by its exact lengths, as documents give it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

from flint import acb

from rpr_solver.contract import FIXED_LEGS, LENGTHS
from rpr_solver.verify_by_boxes.numbers import POSITIVE, ball, exact
from rpr_solver.verify_by_boxes.reader import Read, record, refusal, word

_NUMBERS: dict[str, Read] = dict.fromkeys(LENGTHS[:3], exact) | dict.fromkeys(LENGTHS[3:], POSITIVE)
_MEMBERS = record({**_NUMBERS, "orientation": word("ccw", "cw")})


@dataclass(frozen=True)
class Geometry:
    """A1 = (0, 0), A2 = (a2x, 0), A3 = (a3x, a3y), and the sides d1 = |B1B2|, d2 = |B2B3|, d3 = |B3B1|.

    Seen from B1, B2 is in the direction of the platform's angle α; B3 is on the left of it, or on its right
    if the platform is clockwise. ``texts`` are the numbers as a document has them.
    """

    a2x: Fraction
    a3x: Fraction
    a3y: Fraction
    d1: Fraction
    d2: Fraction
    d3: Fraction
    clockwise: bool
    texts: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def read(cls, value: object, at: str) -> Geometry:
        """The member ``geometry`` of a document.

        Raises:
            InputError: naming what is missing or impossible.
        """
        members = _MEMBERS(value, at)
        texts = {name: str(value[name]) for name in (*LENGTHS, "orientation")}  # type: ignore[index]
        numbers = {name: members[name] for name in LENGTHS}
        result = cls(**numbers, clockwise=members["orientation"] == "cw", texts=texts)
        if abs(result.foot) > result.d3:
            raise refusal(f"{at}/d1", "d1, d2 and d3 are not the sides of a triangle")
        if len({(0, 0), (result.a2x, 0), (result.a3x, result.a3y)}) < 3:
            raise refusal(f"{at}/a2x", "two corners of the base coincide")
        return result

    @property
    def hash(self) -> str:
        """The hash that a document with it should have."""
        text = ";".join(f"{name}={text}" for name, text in self.texts.items())
        return "sha256:" + hashlib.sha256(f"3-RPR;{text}".encode()).hexdigest()

    @cached_property
    def foot(self) -> Fraction:
        """How far B3 is from B1 in the direction of B2, by the law of cosines."""
        return (self.d1**2 + self.d3**2 - self.d2**2) / (2 * self.d1)

    @property
    def base(self) -> tuple[acb, acb, acb]:
        """The corners of the base."""
        return acb(0), acb(ball(self.a2x)), acb(ball(self.a3x), ball(self.a3y))

    @property
    def platform(self) -> tuple[acb, acb, acb]:
        """The corners of the platform at α = 0, with B1 in the origin."""
        height = ball(self.d3**2 - self.foot**2).sqrt()
        return acb(0), acb(ball(self.d1)), acb(ball(self.foot), -height if self.clockwise else height)

    @cached_property
    def size(self) -> int:
        """The exponent of a power of 2 that exceeds all sides, but is not twice as great as their sum."""
        whole = abs(self.a2x) + abs(self.a3x) + abs(self.a3y) + self.d1 + self.d2 + self.d3
        n, d = whole.as_integer_ratio()
        return n.bit_length() - d.bit_length() + 1

    def free_legs(self, fixed: int) -> tuple[int, int]:
        """The legs whose lengths vary."""
        first, second = (leg for leg in FIXED_LEGS if leg != fixed)
        return first, second

    @cached_property
    def is_similar_pair(self) -> bool:
        """Whether the platform is a turned and scaled copy of the base: their slices have no cusps.

        The squared sides are proportional, and the senses agree; of flat triangles there is no sense.
        """
        base, platform = self.squared_sides
        ratio = platform[1, 2] / base[1, 2]
        proportional = all(x * ratio == platform[key] for key, x in base.items())
        sense = self.a2x * self.a3y
        return proportional and (sense == 0 or (sense < 0) == self.clockwise)

    @cached_property
    def squared_sides(self) -> tuple[dict[tuple[int, int], Fraction], dict[tuple[int, int], Fraction]]:
        """The squared distances of the corners of the base, and of the platform, by two numbers of legs."""
        base = {
            (1, 2): self.a2x**2,
            (2, 3): (self.a3x - self.a2x) ** 2 + self.a3y**2,
            (1, 3): self.a3x**2 + self.a3y**2,
        }
        platform = {(1, 2): self.d1**2, (2, 3): self.d2**2, (1, 3): self.d3**2}
        both = [{**x, **{(k, i): y for (i, k), y in x.items()}} for x in (base, platform)]
        return both[0], both[1]

    @property
    def is_base_flat(self) -> bool:
        """Whether the corners of the base are on a line."""
        return self.a3y == 0

    @property
    def is_platform_flat(self) -> bool:
        """Whether the corners of the platform are on a line."""
        return self.foot**2 == self.d3**2

    @cached_property
    def is_singular_pair(self) -> bool:
        """Whether both triangles are flat, or they are mirrored: poses are degenerate at all lengths then."""
        base, platform = self.squared_sides
        flat = self.is_base_flat and self.is_platform_flat
        return flat or (base == platform and not self.is_similar_pair)
