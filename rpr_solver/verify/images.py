"""Images of pieces of J = 0 in the plane of the squared free legs, and pairs of them that do not meet.

A *piece* has series of both legs and of a tangent along it, whatever curve it is a piece of
(mathematics.md#regions-of-the-joint-plane).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import Generic, Self, TypeVar

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.fronts import BITS, Point, Series, Vector

_NORMAL, MOST_PIECES = 160, 6000
UNDECIDED = "parts of the singular curve's image are too near each other for intervals"
Part = TypeVar("Part", bound="Image")


def small(vector: Vector) -> Vector:
    """A vector of small integers that has about the direction of one."""
    shift = max(max(map(abs, vector)).bit_length() - _NORMAL, 0)
    return vector[0] >> shift, vector[1] >> shift


def normal_of(vector: Vector) -> Vector:
    """A vector of small integers that is about normal to one, on its left."""
    x, y = small(vector)
    return -y, x


def chord(piece: Image) -> Vector:
    """From the image of its start to that of its end."""
    (a, b), (c, d) = (point.image for point in piece.ends)
    return c - a, d - b


class Image(ABC):
    """A piece of the image of J = 0, by series along it.

    Attributes:
        ends: its ends.
        reach: how far it reaches from its middle, as an angle.
    """

    ends: tuple[Point, Point]
    reach: int

    @property
    @abstractmethod
    def image(self) -> tuple[Series, Series]:
        """The squared free legs along it."""

    @property
    @abstractmethod
    def tangents(self) -> tuple[Series, Series]:
        """A tangent of the image along it; it runs along this, or against it."""

    @property
    @abstractmethod
    def cusps(self) -> frozenset[int]:
        """The cusps that may be on it."""

    @property
    @abstractmethod
    def halves(self) -> tuple[Self, Self]:
        """Two pieces of it.

        Raises:
            OpenError: they are too small.
        """

    def along(self, normal: Vector) -> Vector:
        """The middle and the radius of the image in a direction, a vector of small integers; times this."""
        middle, *terms = _in_direction(self.image, normal)
        return middle, sum(map(abs, terms)) + sum(
            abs(x) * row.rest for x, row in zip(normal, self.image, strict=True)
        )

    @cached_property
    def box(self) -> tuple[int, int, int, int]:
        """Least and greatest first, then second coordinates of the image."""
        (a, r), (b, s) = self.along((1, 0)), self.along((0, 1))
        return a - r, a + r, b - s, b + s

    @property
    def size(self) -> int:
        """The size of the box of its image."""
        a, b, c, d = self.box
        return max(b - a, d - c)

    @property
    def tangent(self) -> Vector:
        """A tangent of the image in the middle."""
        return self.tangents[0].terms[0], self.tangents[1].terms[0]

    @cached_property
    def heading(self) -> int:
        """Whether a piece without a cusp runs along its tangent (1) or against it (−1); 0 if that is open."""
        normal, (start, stop) = small(self.tangent), self.ends
        if self.cusps or not self.leans(normal):
            return 0
        way = sum(n * (y - x) for n, x, y in zip(normal, start.image, stop.image, strict=True))
        room = (abs(normal[0]) + abs(normal[1])) * (start.blur + stop.blur)
        return (way > room) - (way < -room)

    def leans(self, normal: Vector) -> bool:
        """Whether no tangent of the image is normal to a direction."""
        first, *terms = _in_direction(self.tangents, normal)
        rest = sum(abs(x) * row.rest for x, row in zip(normal, self.tangents, strict=True))
        return abs(first) > sum(map(abs, terms)) + rest

    def crosses(self, other: Image) -> int:
        """The sign of the cross product of all tangents of this piece and of another; 0 if that is open."""
        (a, b), (c, d) = self.tangents, other.tangents
        value, *terms = (
            p * s - q * r
            for p, q in zip(a.terms, b.terms, strict=True)
            for r, s in zip(c.terms, d.terms, strict=True)
        )
        change = sum(map(abs, terms))
        for x, y in ((a, d), (b, c)):
            change += (abs(x.terms[0]) + x.change) * y.rest + (abs(y.terms[0]) + y.change) * x.rest
        return (value > change) - (value < -change)


def _in_direction(rows: tuple[Series, Series], normal: Vector) -> list[int]:
    """The polynomial of a direction."""
    return [normal[0] * x + normal[1] * y for x, y in zip(rows[0].terms, rows[1].terms, strict=True)]


def is_simple(run: Sequence[Image]) -> bool:
    """Whether the image of consecutive pieces without a cusp is proved not to meet itself."""
    spend(10 * len(run), BITS)
    normal = small(run[len(run) // 2].tangent)
    return not any(piece.cusps for piece in run) and all(piece.leans(normal) for piece in run)


class Pairs(ABC, Generic[Part]):
    """What is known of pairs of pieces whose images do not meet, but at a common end."""

    @abstractmethod
    def hold(self, x: Part, y: Part) -> bool:
        """Whether it is known of a pair, or found."""

    def cut(self, chain: Sequence[Part]) -> list[Part]:
        """The closed chain, cut so finely that no two neighbours meet but at their common end.

        Raises:
            OpenError: pieces get too small, or there are too many.
        """
        pieces = list(chain)
        while True:
            n = len(pieces)
            pairs = [(pieces[k], pieces[(k + 1) % n]) for k in range(n)]
            bad = {k for k, pair in enumerate(pairs) if not is_simple(pair) and not self.hold(*pair)}
            if n > 2 and not bad:
                return pieces
            if n > MOST_PIECES:
                raise OpenError(UNDECIDED)
            split = bad | {(k + 1) % n for k in bad} if n > 2 else set(range(n))
            pieces = [part for k, x in enumerate(pieces) for part in (x.halves if k in split else (x,))]
