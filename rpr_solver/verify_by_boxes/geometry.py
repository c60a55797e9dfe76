"""The manipulator of a document: six exact numbers, and what follows from them."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from rpr_solver.contract import LENGTHS
from rpr_solver.verify_by_boxes.numbers import POSITIVE, exact
from rpr_solver.verify_by_boxes.reader import Read, record, refusal, word

_NUMBERS: dict[str, Read] = dict.fromkeys(LENGTHS[:3], exact) | dict.fromkeys(LENGTHS[3:], POSITIVE)
_MEMBERS = record({**_NUMBERS, "orientation": word("ccw", "cw")})


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
    texts: Mapping[str, str] = field(compare=False, repr=False)

    @classmethod
    def read(cls, value: object, at: str) -> Geometry:
        """The member ``geometry`` of a document.

        Raises:
            InputError: naming what is missing or impossible.
        """
        members = _MEMBERS(value, at)
        texts = {name: str(value[name]) for name in (*LENGTHS, "orientation")}  # type: ignore[index]
        numbers = (members[name] for name in LENGTHS)
        result = cls(*numbers, clockwise=members["orientation"] == "cw", texts=texts)
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
        """The square of the distance of B3 from the line B1B2; B3 is to its left unless ``clockwise``."""
        return self.d3**2 - self.foot**2

    def free_legs(self, fixed: int) -> tuple[int, int]:
        """The legs whose lengths vary while one is fixed."""
        first, second = (leg for leg in (1, 2, 3) if leg != fixed)
        return first, second
