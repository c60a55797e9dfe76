"""The cusps of a slice, all found anew: one above each simple root of Q, on other lines by a search.

Above a simple root the common root of J and E in tan(α/2) is that of their linear subresultant. On a line of
a multiple or spurious root, α is cut into pieces until J, or E along either leg, excludes 0 on each; what is
left is a cusp that is proved, or a doubt. Each cusp is proved by Krawczyk's test.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import isqrt

from rpr_solver.verify.claims import ClaimStatus, Finding, OpenError, matching
from rpr_solver.verify.core.intervals import Interval, cos_sin, degrees, pi
from rpr_solver.verify.core.krawczyk import (
    Box,
    Equations,
    Pair,
    angle_of,
    common_on_axis,
    direction,
    meet,
    zero_near,
)
from rpr_solver.verify.core.numbers import HALF_WAY, Printed, bits_of, first_wrong
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.roots import Root, refined
from rpr_solver.verify.core.surds import Ring, Surd, size_of, trimmed
from rpr_solver.verify.core.system import Leg, Surface, System, Trig, at_half_tangent
from rpr_solver.verify.eliminant import Eliminant, nearby, separation, special_lines, unlisted

_SPARE_BITS, _COUNT_BITS = 40, 60
_MOST_DOUBTS = 12
"""The most poses that are looked at on one line; J has degree 4 there."""
Vanishes = Callable[[str], bool]
"""Whether a number of a pose, by its name, is exactly 0."""


@dataclass(frozen=True)
class Point:
    """A printed pose: by their names α and θ in degrees, then the lengths of the free legs."""

    row: Mapping[str, Printed]

    @classmethod
    def of(cls, point: Record, part: System | Surface) -> Point:
        """The point of a document, in a slice or one of all slices."""
        free = (f"l{leg}" for leg in (1, 2, 3) if leg != part.fixed)
        return cls({name: point[name] for name in ("alpha_deg", f"theta{part.fixed}_deg", *free)})

    @property
    def numbers(self) -> tuple[Printed, ...]:
        """All four numbers."""
        return tuple(self.row.values())

    @property
    def angles(self) -> tuple[Printed, Printed]:
        """α and θ."""
        return self.numbers[0], self.numbers[1]

    @property
    def bits(self) -> int:
        """Bits well below the last printed digit of the angles and the lengths."""
        return bits_of(self.numbers)

    def wrong(
        self,
        values: Sequence[Interval],
        vanishes: Callable[[str], bool] = lambda _: True,
        *,
        doubted: bool = True,
    ) -> str | None:
        """The first number that is wrong for a pose with these values; None if all are right."""
        own = dict(zip(self.row, values, strict=True))
        return first_wrong(self.row, own, vanishes, doubted=doubted)


@dataclass(frozen=True)
class Located:
    """A printed cusp, its proved box if there is one, and what is found about its digits."""

    point: Point
    box: Box | None
    finding: Finding


@dataclass(frozen=True)
class Doubt:
    """A line, and an interval of α, where it cannot be excluded that three poses coalesce."""

    line: Pair
    alpha: Interval

    def meets(self, area: Box) -> bool:
        """Whether a pose of an area may be the one in doubt."""
        here = area.directions
        return meet(here.theta, self.line) and meet(here.alpha, cos_sin(self.alpha))


@dataclass(frozen=True)
class Cusps:
    """All cusps of a slice.

    Attributes:
        boxes: proved, each of another cusp.
        doubts: where others may be.
        close: how many cusps on lines of doubt are not proved to be alone within 2^−20 radians.
        missing: how many simple roots have no proved cusp.
    """

    boxes: tuple[Box, ...]
    doubts: tuple[Doubt, ...]
    close: int
    missing: int

    @property
    def complete(self) -> bool:
        """Whether it is proved that there are no others."""
        return not (self.doubts or self.close or self.missing)


class Slice:
    """A slice with its equations, and its cusps as they are asked for; ``known`` is their number if it is."""

    def __init__(self, system: System, known: int | None = None) -> None:
        self.system, self.known = system, known

    @cached_property
    def eliminant(self) -> Eliminant:
        """Its lines.

        Raises:
            OpenError: J and E share a curve, and it is none of α = 0 and 180°.
        """
        eliminant = Eliminant.of(self.system)
        if not (eliminant.form or eliminant.rest):
            raise OpenError("J and E share a curve in this slice that is none of alpha = 0 and 180 degrees")
        return eliminant

    @cached_property
    def _kernel(self) -> list[Equations]:
        radicand = self.system.ring.radicand
        return [Equations.of(self.system.singular, leg.kernel, radicand) for leg in self.system.legs]

    def counted(self) -> tuple[int, bool] | None:
        """The number of cusps, and whether it is proved; None if the resultant vanishes."""
        if not self.eliminant.form:
            return None
        if self.eliminant.generic:
            return len(self.eliminant.single_roots), True
        found = self.cusps()
        return len(found.boxes) + found.missing, found.complete

    def cusps(self, bits: int = _COUNT_BITS) -> Cusps:
        """All cusps, in boxes of some 2^−``bits`` at most."""
        if self.known == 0:
            return Cusps((), (), 0, 0)
        apart = separation(self.eliminant)
        boxes: list[Box] = []
        doubts: list[Doubt] = []
        close = missing = 0
        for root in self.eliminant.single_roots:
            box = self._above(root, max(bits, 2 * apart), apart)
            if box is None or any(box.meets(other) for other in boxes):
                missing += 1
            else:
                boxes.append(box)
        lines = special_lines(self.system, self.eliminant, apart)
        for line in () if len(boxes) == self.known and not missing else lines:
            own, alone = self._on(line, max(bits, 2 * apart), apart, doubts)
            if any(box.meets(other) for box in own for other in boxes):
                missing += 1
            boxes += own
            close += len(own) - alone
        boxes.sort(key=lambda box: box.theta.middle)
        if len(boxes) == self.known and not missing:
            return Cusps(tuple(boxes), (), 0, 0)
        return Cusps(tuple(boxes), tuple(doubts), close, missing)

    def _above(self, root: Root, bits: int, apart: int) -> Box | None:
        """The cusp above a simple root of Q."""
        ring, form = self.system.ring, self.eliminant.single
        for fine in (2 * apart + _SPARE_BITS, 4 * apart + 3 * _SPARE_BITS):
            narrow = refined(ring, form, root, Fraction(1, 1 << fine))
            line = direction(ring, form, narrow, fine)
            j = at_half_tangent(self.system.singular, 2, *narrow.ratio)
            e = at_half_tangent(self.system.legs[0].kernel, 3, *narrow.ratio)
            for alpha in common_angles(ring, j, e, fine):
                for order in (0, 1, 3):
                    box = self.cusp_near(alpha, angle_of(line), max(bits, (order + 1) * apart), order * apart)
                    if box is not None and meet(box.directions.theta, line):
                        return box
        return None

    def _on(self, line: Pair, bits: int, apart: int, doubts: list[Doubt]) -> tuple[list[Box], int]:
        """The cusps on a special line, and how many are proved to be alone; doubts are added to the list."""
        size = line[0].bits
        angles = {"alpha = 0 deg": Interval.of(0, size), "alpha = 180 deg": pi(size)}
        holes = [nearby(angles[curve]) for curve in self.eliminant.cut.curves]
        boxes: list[Box] = []
        alone, most = 0, len(doubts) + _MOST_DOUBTS
        while (alpha := unlisted(self.system, line, holes, apart)) is not None:
            start = Interval.of(alpha, size)
            box = self.cusp_near(start, angle_of(line), bits)
            if box is None or not meet(box.directions.theta, line) or any(box.meets(x) for x in boxes):
                holes.append(nearby(start))
                doubts.append(Doubt(line, holes[-1]))
                if len(doubts) > most:
                    break
                continue
            boxes.append(box)
            room = self._alone(box)
            alone += room is not None
            holes.append(nearby(box.alpha) if room is None else room)
        return boxes, alone

    def cusp_near(self, alpha: Interval, theta: Interval, bits: int, apart: int = 0) -> Box | None:
        """The proved box of the cusp near two angles in radians, others being 2^−``apart`` away; or None."""
        for leg, equations in zip(self.system.legs, self._kernel, strict=True):
            box = zero_near(equations, alpha, theta, bits, apart)
            if box and any(box.directions.value(slope).sign for slope in (leg.alpha, leg.theta)):
                return box
        return None

    def _alone(self, box: Box) -> Interval | None:
        """All α of a wide box about that of a cusp, which holds no other zero of J = E = 0; or None."""
        found = (equations.alone(box) for equations in self._kernel)
        return next((wide.alpha for wide in found if wide is not None), None)

    def located(self, printed: Sequence[Point], bits: int = 0) -> tuple[list[Located], Cusps]:
        """A different cusp for each printed one, and all cusps."""
        cusps = self.cusps(max((bits, *(point.bits for point in printed))))
        boxes = cusps.boxes
        known = [self._values(box) for box in boxes]
        pairs = list(zip(boxes, known, strict=True))
        wrong = [[self._wrong(x, *pair, doubted=False) for pair in pairs] for x in printed]
        chosen = matching(wrong, range(len(boxes)), lambda row, k: row[k] is None)
        result = []
        for point, row, k in zip(printed, wrong, chosen, strict=True):
            if k is not None:
                finding = (
                    ClaimStatus.PROVED,
                    "a proved box holds one regular zero of (J, E); each digit is right",
                )
                if self._wrong(point, boxes[k], known[k], doubted=True):
                    finding = ClaimStatus.CHECKED, HALF_WAY
                result.append(Located(point, boxes[k], finding))
                continue
            names = ", ".join(dict.fromkeys(name for name in row if name)) or "another is printed alike"
            reason = f"it is none of the {len(boxes)} cusps that are found anew: wrong in {names}"
            result.append(Located(point, None, (ClaimStatus.REFUSED, reason)))
        return result, cusps

    def _values(self, box: Box) -> list[Interval]:
        return [degrees(box.alpha), degrees(box.theta), *(self.length(leg, box) for leg in self.system.legs)]

    def _wrong(self, point: Point, box: Box, values: Sequence[Interval], *, doubted: bool) -> str | None:
        """The first printed number that is wrong for a cusp; None if all are right."""

        def vanishes(name: str) -> bool:
            return any(common_on_axis(pair, box, theta=name != "alpha_deg") for pair in self._kernel)

        return point.wrong(values, vanishes, doubted=doubted)

    def area(self, point: Point) -> Box | None:
        """All poses that round to a degenerate one, None if J = E = 0 or its lengths are excluded there."""
        functions = [self.system.singular, *(leg.kernel for leg in self.system.legs)]
        bits = point.bits + max(pair.coefficient_bits for pair in self._kernel)
        box = around(*point.angles, bits, self.system.ring.radicand)
        if any(box.directions.value(p).sign for p in functions):
            return None
        legs = zip(point.numbers[2:], self.system.legs, strict=True)
        return None if any(x.rounds(self.length(leg, box)) is False for x, leg in legs) else box

    def excludes(self, point: Point, cusps: Cusps) -> bool:
        """Whether no pose that rounds to a printed one is degenerate, given all cusps and places in doubt."""
        area = self.area(point)
        if area is None or not cusps.complete or self.eliminant.cut.curves:
            return area is None
        return not any(doubt.meets(area) for doubt in cusps.doubts)

    def length(self, leg: Leg[Trig], box: Box) -> Interval:
        """The length of a free leg in the user's unit."""
        scaled = box.directions.value(leg.squared).root()
        return scaled.over(Interval.of(self.system.unit, scaled.bits))


def around(alpha: Printed, theta: Printed, bits: int, radicand: int) -> Box:
    """All poses whose angles round to two printed ones."""
    turn = pi(bits)
    first, second = (turn * Interval.of(x.value / 180, bits, x.half / 180) for x in (alpha, theta))
    return Box(first, second, radicand)


def common_angles(ring: Ring, p: Sequence[Surd], q: Sequence[Surd], bits: int) -> Iterator[Interval]:
    """Angles α in radians near the common root tan(α/2) of two forms that nearly have one, in two ways.

    It is the root of the linear remainder of Euclid's algorithm, each of them rounded. A wrong angle does no
    harm.
    """
    near, pair = Ring(1), [_rounded(ring, form, 4 * bits) for form in (p, q)]
    for inverted in (False, True):
        forms = (trimmed(form[::-1] if inverted else form) for form in pair)
        second, first = sorted(forms, key=len)
        while len(second) > 2:
            rest = near.pseudo_remainder(first, second)
            first, second = second, trimmed(_rounded(near, rest, 4 * bits))
        if len(second) < 2:
            continue
        (y, _), (x, _) = second
        y, x = (x, -y) if inverted else (-y, x)
        if size := max(abs(x), abs(y)):
            cos, sin = (Interval.of(Fraction(part, size), bits) for part in (x, y))
            norm = cos * cos + sin * sin
            yield angle_of(((cos * cos - sin * sin).over(norm), (sin * cos).scaled(2).over(norm)))


def _rounded(ring: Ring, form: Sequence[Surd], bits: int) -> list[Surd]:
    """About a multiple of a form, with integer coefficients of so many bits."""
    guard = bits + size_of(form)
    omega = isqrt(ring.radicand << (2 * guard))
    values = [(a << guard) + b * omega for a, b in form]
    cut = max(max((x.bit_length() for x in values), default=0) - bits, 0)
    return [(x >> cut, 0) for x in values]


Bounds = tuple[Fraction | None, Fraction | None]
Count = Callable[[Slice], tuple[int, bool] | None]
"""The number of cusps of a slice, and whether it is proved; None if it is open."""


@dataclass(frozen=True)
class Limits:
    """Open joint limits of the free legs, in the user's unit; None is no limit."""

    of_legs: Mapping[int, Bounds]

    @property
    def each(self) -> list[tuple[int, Fraction]]:
        """The number of the leg and its limit, for each limit."""
        return [(leg, x) for leg, bounds in self.of_legs.items() for x in bounds if x is not None]

    def admit(self, part: Slice, box: Box) -> bool | None:
        """Whether the lengths at a cusp are strictly within the limits; None if intervals do not tell."""
        sides: list[bool | None] = []
        for leg in part.system.legs:
            x = part.length(leg, box)
            for bound, side in zip(self.of_legs.get(leg.number, ()), (1, -1), strict=False):
                if bound is not None:
                    off = (x - Interval.of(bound, x.bits)).sign
                    sides.append(None if not off else off == side)
        return False if False in sides else None if None in sides else True

    def counted(self, part: Slice) -> tuple[int, bool] | None:
        """The number of cusps of a slice within the limits, and whether it is proved; None if it is open."""
        if not self.each or not part.eliminant.form:
            return part.counted()
        cusps = part.cusps()
        sides = [self.admit(part, box) for box in cusps.boxes]
        return None if None in sides else (sides.count(True), cusps.complete)


UNLIMITED = Limits({})
