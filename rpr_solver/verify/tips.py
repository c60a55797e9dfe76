"""The image of J = 0 of flat triangles: of half of its strands, between poses where both legs are stationary.

The poses (α, θ) and (−α, −θ) have one image, so half of the strands have it all. Near a pose with α and θ of
0 or 180° J and the legs are even: at s (d + ρ e) they are a constant and s² times a function of ρ, nearly. So
a strand has a *tip* there, whose image is in a narrow cone (mathematics.md#flat-slices).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import hypot, sqrt

from rpr_solver.verify.arrangement import Arrangement
from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.fronts import (
    BITS,
    ERROR,
    FRAME,
    ONE,
    TURN,
    Front,
    Point,
    Series,
    Vector,
    Wave,
    product,
)
from rpr_solver.verify.images import UNDECIDED, Image, Pairs, small
from rpr_solver.verify.pieces import Patches, Piece, piece_between, traced_to

_WIDEST, _NARROWEST = 6, 44


@dataclass(frozen=True, eq=False)
class Arm:
    """A direction d in which J = 0 leaves a pose with α and θ of 0 or 180°; e is its left normal.

    Attributes:
        turns: both angles, in half turns.
        way: d, about of length 1.
    """

    front: Front
    turns: Vector
    way: tuple[Fraction, Fraction]

    def _terms(self, wave: Wave) -> Iterator[tuple[int, Fraction, Fraction]]:
        """The amplitude of each wave, and by how much its phase grows with s and s ρ."""
        (i, k), (x, y) = self.turns, self.way
        for p, q, a, _ in wave.terms:
            yield (-a if (p * i + q * k) % 2 else a), p * x + q * y, q * x - p * y

    def second(self, wave: Wave, reach: int, width: Fraction, *, radial: bool) -> Interval:
        """(wave − its value at the pose) / s² for s ≤ 2^−reach and |ρ| ≤ width; or its slope in s, over s."""
        total, bound = Interval(0, 0, BITS), Fraction(0)
        for a, along, across in self._terms(wave):
            k = Interval.of(along, BITS, width * abs(across))
            total += Interval(a, a, BITS) * k * k
            bound += abs(a) * k.greatest**4
        spend(30, BITS)
        rest = int(bound / (6 if radial else 24) / (1 << (2 * reach))) + ERROR
        total = total.scaled(-1) if radial else (total * Interval.of(Fraction(-1, 2), BITS))
        return Interval(total.lower - rest, total.upper + rest, BITS)

    def _slope(self, reach: int, width: Fraction) -> int:
        """The sign of the slope of J/s² in ρ; 0 if it is open."""
        total, bound = Interval(0, 0, BITS), Fraction(0)
        for a, along, across in self._terms(self.front.singular):
            k = Interval.of(along, BITS, width * abs(across))
            total -= Interval(a, a, BITS) * k * Interval.of(across, BITS)
            bound += abs(a) * abs(across) * k.greatest**3
        rest = int(bound / 6 / (1 << (2 * reach))) + ERROR
        return Interval(total.lower - rest, total.upper + rest, BITS).sign

    def width(self, reach: int) -> tuple[Fraction, int] | None:
        """A width of ρ within which J has one zero for each s ≤ 2^−reach, and the sign of its slope."""
        for width in (Fraction(1, 1 << n) for n in (reach + 4, reach + 2, reach, reach - 2)):
            sides = [self._at(reach, sign * width).sign for sign in (-1, 1)]
            if sides[0] * sides[1] < 0 and (slope := self._slope(reach, width)):
                return width, slope
        return None

    def _at(self, reach: int, rho: Fraction) -> Interval:
        """J/s² for one ρ."""
        way = self.way[0] - rho * self.way[1], self.way[1] + rho * self.way[0]
        arm = Arm(self.front, self.turns, way)
        return arm.second(self.front.singular, reach, Fraction(0), radial=False)

    def point(self, s: Fraction, slope: int) -> Point | None:
        """A point of J = 0 at about an s."""
        alpha, theta = (n * TURN // 2 + int(s * x * ONE) for n, x in zip(self.turns, self.way, strict=True))
        unit = slope * ((1 << FRAME) - 8)
        return self.front.point(alpha, theta, (int(-unit * self.way[1]), int(unit * self.way[0])))

    def holds(self, point: Point, reach: int, width: Fraction) -> bool:
        """Whether a point of J = 0 is the one within these bounds."""
        (x, y), off = self.way, Fraction(4 * point.error, ONE)
        a, t = (
            Fraction((z - n * TURN // 2 + TURN // 2) % TURN - TURN // 2, ONE)
            for z, n in zip((point.alpha, point.theta), self.turns, strict=True)
        )
        size = x * x + y * y
        s, aside = (a * x + t * y) / size, (t * x - a * y) / size
        return s - off > 0 and s + off <= Fraction(1, 1 << reach) and abs(aside) + off <= width * (s - off)


@dataclass(frozen=True, eq=False)
class Tip(Image):
    """The part of a strand from a pose where both legs are stationary to a point, or back from there.

    Attributes:
        exponent: s ≤ 2^−exponent on it.
    """

    arm: Arm
    node: Point
    ends: tuple[Point, Point]
    exponent: int
    bounds: tuple[Fraction, int]

    def at(self, outer: Point, sign: int) -> Tip:
        """One with the same image that comes from a point: by full turns away, and at −α and −θ for −1."""
        (x, y), (i, k) = self.arm.way, (round(Fraction(2 * z, TURN)) for z in (outer.alpha, outer.theta))
        arm = replace(self.arm, turns=(i, k), way=(sign * x, sign * y))
        return replace(self, arm=arm, ends=(outer, self.node))

    @property
    def reach(self) -> int:  # type: ignore[override]
        """How far it reaches."""
        return ONE >> self.exponent

    @property
    def outer(self) -> Point:
        """The end where the legs are not stationary."""
        return self.ends[1] if self.ends[0] is self.node else self.ends[0]

    @cached_property
    def cone(self) -> tuple[Interval, Interval]:
        """(image − that of the pose) / s²."""
        first, second = (
            self.arm.second(leg, self.exponent, self.bounds[0], radial=False) for leg in self.arm.front.legs
        )
        return first, second

    @cached_property
    def image(self) -> tuple[Series, Series]:
        """The squared free legs along it."""
        square, rows = ONE >> (2 * self.exponent), []
        for start, x in zip(self.node.image, self.cone, strict=True):
            half = (square // 2 * ((x.lower + x.upper) // 2)) >> BITS
            rows.append(
                Series(
                    (start + half, half),
                    product(square, (x.upper - x.lower) // 2 + 1) + self.node.blur + ERROR,
                )
            )
        return rows[0], rows[1]

    @cached_property
    def tangents(self) -> tuple[Series, Series]:
        """A tangent of the image along it."""
        rows = []
        for leg in self.arm.front.legs:
            x = self.arm.second(leg, self.exponent, self.bounds[0], radial=True)
            rows.append(Series(((x.lower + x.upper) // 2,), (x.upper - x.lower) // 2 + 1))
        return rows[0], rows[1]

    @property
    def cusps(self) -> frozenset[int]:
        """As if one were on it: at its end the image has no tangent."""
        return frozenset({-1})

    @cached_property
    def halves(self) -> tuple[Image, Image]:  # type: ignore[override]
        """A smaller tip and a piece."""
        tip, leads = tip_of(self.arm, self.node, self.exponent + 1), self.ends[0] is self.node
        if tip is None:
            raise OpenError(UNDECIDED)
        ends = (tip.outer, self.outer) if leads else (self.outer, tip.outer)
        piece = piece_between(self.arm.front, *ends)
        if piece is None:
            raise OpenError(UNDECIDED)
        return (tip, piece) if leads else (piece, tip)


def tip_of(arm: Arm, node: Point, exponent: int) -> Tip | None:
    """A tip that reaches at most to s = 2^−exponent; None if it is not proved."""
    if exponent > _NARROWEST or (bounds := arm.width(exponent)) is None:
        return None
    point = arm.point(Fraction(9, 10 << exponent), bounds[1])
    if point is None or not arm.holds(point, exponent, bounds[0]):
        return None
    ends = (node, point) if bounds[1] > 0 else (point, node)
    return Tip(arm, node, ends, exponent, bounds)


class Corners(Pairs[Image]):
    """Pairs of pieces and tips that do not meet, but at a common end."""

    def __init__(self) -> None:
        self.patches = Patches()

    def hold(self, x: Image, y: Image) -> bool:
        """Whether that is so of a pair."""
        if isinstance(x, Piece) and isinstance(y, Piece):
            return self.patches.hold(x, y)
        common = [p for p in x.ends for q in y.ends if p is q]
        if len(common) != 1:
            return False
        if isinstance(x, Tip) and isinstance(y, Tip):
            (a, b), (c, d) = x.cone, y.cone
            return common[0] is x.node is y.node and (a * d - b * c).sign != 0
        piece = y if isinstance(x, Tip) else x
        normal = small(piece.tangent)
        return not piece.cusps and x.leans(normal) and y.leans(normal)


def image_of_flat(front: Front, strands: int) -> Arrangement:
    """The image of J = 0 of flat triangles, which has so many strands between poses.

    Raises:
        OpenError: not all of them are found.
    """
    tips = tips_of(front)
    stops = [(turns, stop) for turns, (_, own) in tips.items() for stop in (own.outer, _turned(own.outer))]
    left, chains = list(tips), []
    while left:
        chain: list[Image] = []
        here = left[0]
        while here in left:
            left.remove(here)
            leaving, _ = tips[here]
            pieces, n = traced_to(front, leaving.outer, [stop for _, stop in stops])
            here = stops[n][0]
            coming = tips[here][1].at(pieces[-1].ends[1], -1 if n % 2 else 1)
            chain += [leaving, *pieces, coming]
        if chain[0].ends[0] is not chain[-1].ends[1]:
            raise OpenError(UNDECIDED)
        chains.append(chain)
    if 2 * len(tips) != strands:
        raise OpenError("not all strands of the singular curve are found")
    return Arrangement(chains, Corners())


def tips_of(front: Front) -> dict[Vector, tuple[Tip, Tip]]:
    """The strands that leave each pose, and come there, with J > 0 on the left: one each.

    Raises:
        OpenError: they are not proved.
    """
    found = {}
    for turns in ((0, 0), (0, 1), (1, 0), (1, 1)):
        node, arms = _node(front, turns), _arms(front, turns)
        tips = [
            next((x for n in range(_WIDEST, _NARROWEST) if (x := tip_of(arm, node, n))), None) for arm in arms
        ]
        known = {tip.bounds[1]: tip for tip in tips if tip is not None}
        if arms and len(known) < 2:
            raise OpenError(UNDECIDED)
        if arms:
            found[turns] = known[1], known[-1]
    return found


def _turned(point: Point) -> Point:
    """The pose with the same image."""
    return Point(-point.alpha, -point.theta, point.error + (1 << 10), point.image, point.blur)


def _node(front: Front, turns: Vector) -> Point:
    alpha, theta = (n * TURN // 2 for n in turns)
    phases = front.phases(alpha, theta)
    blur = ERROR + max(product(leg.norms[1], 1 << 10) for leg in front.legs)
    return Point(alpha, theta, 1 << 10, (front.legs[0].value(phases), front.legs[1].value(phases)), blur)


def _arms(front: Front, turns: Vector) -> list[Arm]:
    """The directions in which J may be 0 beside a pose; about, and no proof."""
    _, _, _, aa, at, tt = (x / ONE for x in front.singular.jet(front.phases(*(n * TURN // 2 for n in turns))))
    square = at * at - aa * tt
    if square <= 0:
        return []
    found = []
    for sign in (1, -1):
        way = (-at + sign * sqrt(square), aa) if abs(aa) >= abs(tt) else (tt, -at + sign * sqrt(square))
        size = hypot(*way)
        found.append(Arm(front, turns, (Fraction(way[0] / size), Fraction(way[1] / size))))
    return found
