"""The events of all slices of a fixed leg, all found anew: where cusps are born or die.

Above each simple real root of their eliminants is one event, or a pose with the length 0 or ∞, and nothing
else (mathematics.md#completeness-of-the-events); each event is proved by Krawczyk's test. Poses that are
singular for every length are shown to be no events: with the fixed leg along e, J = 0 for every length where

- all three legs are parallel: (m z − a) × e = (n z − b) × e = 0;
- e and m z are parallel to a, or e and n z to b: the gradient of f, or of g, is 0;
- (m − n) z is parallel to a − b, and e to (m b − n a) / (m − n): all legs meet in one point.

At such a pose the slopes of J are of degree 1 in the length, E and v·∇E of degrees 2 and 3. It is degenerate
for some length only if both slopes have a common root, or E and v·∇E along both legs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

from rpr_solver.verify.claims import ClaimStatus, Finding
from rpr_solver.verify.core.intervals import Interval, degrees, radians
from rpr_solver.verify.core.krawczyk import Directions, Pair, Triple, value
from rpr_solver.verify.core.numbers import Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.roots import Root, real_roots, refined
from rpr_solver.verify.core.surds import (
    ONE,
    ZERO,
    Poly,
    Ring,
)
from rpr_solver.verify.core.system import Graded, Surface, slope
from rpr_solver.verify.cusps import common_angles
from rpr_solver.verify.event_lines import DEGREES, EventEliminant, EventLine, event_eliminant

GENERIC = ("swallowtail", "lips", "beak-to-beak")
"""Kinds that are regular zeros of three equations; at one, two cusps are born or die."""
_SPARE_BITS = 40
_STARTS = (128, 512)
_BITS = 256
Vector = tuple[Interval, Interval]


@dataclass(frozen=True)
class Event:
    """A proved event: α and θ in radians and the scaled length, in small intervals."""

    kind: str
    zero: tuple[Interval, Interval, Interval]
    directions: Directions
    alpha_is_zero: bool = False
    theta_is_zero: bool = False
    """Whether an angle is proved to be 0 exactly; θ, or 180 degrees."""

    def length(self, surface: Surface) -> Interval:
        """The length in the user's unit."""
        return self.zero[2].over(Interval.of(surface.unit, self.zero[2].bits))

    def ends(self, surface: Surface) -> tuple[Fraction, Fraction]:
        """The least and the greatest length."""
        length = self.length(surface)
        return Fraction(length.lower, 1 << length.bits), Fraction(length.upper, 1 << length.bits)

    def exactly(self, surface: Surface, event: Record, reason: str) -> Finding:
        """Proved, if an angle that is printed as an exact 0 is one, and no length is."""
        alpha, theta, *lengths = event_numbers(surface, event)
        angles = zip((alpha, theta), (self.alpha_is_zero, self.theta_is_zero), strict=True)
        if any(x.is_zero and not known for x, known in angles) or any(x.is_zero for x in lengths):
            return ClaimStatus.CHECKED, f"{reason}; that a number is exactly 0, beyond the digits"
        return ClaimStatus.PROVED, reason

    def wrong(self, surface: Surface, length: Printed, event: Record) -> str | None:
        """The first printed number that is wrong for this event; None if all are right."""
        unit, theta = Interval.of(surface.unit, self.zero[2].bits), f"theta{surface.fixed}_deg"
        values = [
            (f"l{surface.fixed}", self.length(surface), length, 0),
            ("alpha_deg", degrees(self.zero[0]), event["alpha_deg"], 360),
            (theta, degrees(self.zero[1]), event[theta], 360),
        ]
        for leg in surface.legs:
            squared = value(self.directions, leg.squared, self.zero[2])
            values.append((f"l{leg.number}", squared.root().over(unit), event[f"l{leg.number}"], 0))
        for name, x, number, turn in values:
            if not (x.contains(0) if number.is_zero else number.rounds(x, turn)):
                return name
        return None


def systems(surface: Surface, kind: str) -> Iterator[Triple]:
    """The systems of three equations of a generic kind, any of which finds its events."""
    radicand, j = surface.ring.radicand, surface.singular
    if kind in ("lips", "beak-to-beak"):
        yield Triple((j, *surface.slopes), radicand)
    elif kind == "swallowtail":
        for leg in surface.legs:
            yield Triple((j, leg.kernel, leg.kernel2), radicand)


def event_near(
    surface: Surface, kind: str, start: tuple[Interval, Interval], length: Fraction, bits: int
) -> Event | None:
    """The event of a generic kind near angles in radians and a scaled length; None if none is proved."""
    for triple in systems(surface, kind):
        zero = triple.zero_near(*start, length, bits)
        if zero is None or zero[2].sign <= 0:
            continue
        here = Directions.of(zero[0], zero[1], surface.ring.radicand)
        event = Event(kind, (zero[0], zero[1], zero[2]), here)
        if _is_generic(surface, event):
            return event
    return None


def _is_generic(surface: Surface, event: Event) -> bool:
    """Whether the zero of the system of a kind is an event of this kind."""
    here, length = event.directions, event.zero[2]
    regular = [
        leg for leg in surface.legs if any(value(here, p, length).sign for p in (leg.alpha, leg.theta))
    ]
    if not regular:
        return False
    if event.kind == "swallowtail":
        return any(value(here, p, length).sign for p in surface.slopes)
    rows = [[value(here, slope(p, theta=side), length) for side in (False, True)] for p in surface.slopes]
    (a, b), (c, d) = rows
    if (a * d - b * c).sign != (1 if event.kind == "lips" else -1):
        return False
    return event.kind == "lips" or bool(value(here, regular[0].kernel2, length).sign)


def bits_of(numbers: Sequence[Printed]) -> int:
    """Bits well below the last digits of printed numbers."""
    least = min((x.half for x in numbers if not x.is_zero), default=Fraction(1))
    return (least.denominator // least.numerator).bit_length() + _SPARE_BITS


def event_numbers(surface: Surface, event: Record) -> list[Printed]:
    """The printed angles and lengths of an event."""
    legs = (event[f"l{leg.number}"] for leg in surface.legs)
    return [event["alpha_deg"], event[f"theta{surface.fixed}_deg"], *legs]


def event_finding(surface: Surface, length: Printed, event: Record, events: Events) -> Finding:
    """What is found about a printed event, its length, its digits and its kind: among all, or by itself."""
    numbers, kind = event_numbers(surface, event), event["kind"]
    for own in events.found:
        if own.kind == kind and own.wrong(surface, length, event) is None:
            return own.exactly(surface, event, "it is one of the events that are found anew, with its digits")
    if not events.open:
        return ClaimStatus.REFUSED, f"it is none of the {len(events.found)} events that are found anew"
    if kind not in GENERIC:
        return ClaimStatus.NOT_CHECKED, "no regular system of equations is known for this kind"
    bits = bits_of((*numbers, length))
    start = radians(numbers[0].value, bits), radians(numbers[1].value, bits)
    found = event_near(surface, kind, start, length.value * surface.unit, bits)
    if found is None:
        return ClaimStatus.REFUSED, f"no regular zero of the equations of {kind} is proved near the pose"
    if (wrong := found.wrong(surface, length, event)) is not None:
        return ClaimStatus.REFUSED, f"a digit of {wrong} is wrong"
    return found.exactly(surface, event, "one event is proved in a box, each printed digit is right")


class Events:
    """All events of a manipulator and a fixed leg.

    Attributes:
        surface: the equations.
        eliminants: of both systems.
        found: the proved events, by their length.
        open: what is left open about their completeness; empty if there are no others.
    """

    def __init__(self, surface: Surface, bits: int) -> None:
        self.surface = surface
        self.eliminants = [event_eliminant(surface, name) for name in DEGREES]
        found: list[Event] = []
        reasons: set[str] = set()
        for eliminant in self.eliminants:
            if not any(map(any, eliminant.form)):
                reasons.add("the events are not isolated")
                continue
            for part in (part for m, part in eliminant.parts.items() if m > 1):
                roots = _exact_root(surface.ring, part) or real_roots(surface.ring, part)
                if any(not self._clear(eliminant, root) for root in roots):
                    reasons.add("an eliminant has multiple real roots")
            own: list[Event] = []
            for root in real_roots(surface.ring, eliminant.parts.get(1, (ONE,))):
                event = self._above(eliminant, root, bits)
                if event is None and self._clear(eliminant, root):
                    continue
                if event is None:
                    reasons.add("above a root the length is 0 or infinite, as far as intervals tell")
                elif all(_apart(event.directions.theta, other.directions.theta) for other in own):
                    own.append(event)
                else:
                    reasons.add("two events are above one root, as far as intervals tell")
            found += own
        if not never_degenerate(surface):
            reasons.add("poses that are singular for every length may be degenerate")
        self.found = sorted(found, key=lambda event: event.zero[2].middle)
        self.open = tuple(sorted(reasons))

    def _clear(self, eliminant: EventEliminant, root: Root) -> bool:
        """Whether there is no event above a root, which is decided only where it is known exactly."""
        return not root.width and self._line(root)[0].clear(eliminant.name)

    def _line(self, root: Root) -> tuple[EventLine, int]:
        """The line at the middle of the interval of a root v, and the numerator of v."""
        n, d = ((root.lower + root.upper) / 2).as_integer_ratio()
        n, d = (d, n) if root.inverted else (n, d)
        return EventLine(self.surface, n, d), n

    def _above(self, eliminant: EventEliminant, root: Root, bits: int) -> Event | None:
        """The event above a simple root of an eliminant; None if none is proved."""
        surface, ring = self.surface, self.surface.ring
        kinds = ("swallowtail",) if eliminant.name == "swallowtails" else ("lips", "beak-to-beak")
        for fine in _STARTS:
            narrow = refined(ring, eliminant.parts[1], root, Fraction(1, 1 << fine))
            line, n = self._line(narrow)
            try:
                p, q, _ = line.pair(eliminant.name)
            except ZeroDivisionError:  # beside the line of a permanent pose
                continue
            for alpha in common_angles(ring, p, q, fine):
                for theta in line.angles(fine):
                    length = line.length(alpha, theta)
                    if length is None:
                        continue
                    for kind in kinds:
                        event = event_near(surface, kind, (alpha, theta), length, max(bits, 2 * _SPARE_BITS))
                        if event is not None and line.near(event.directions.theta, narrow):
                            known = narrow.width == 0
                            level = known and p[0] == q[0] == ZERO
                            return replace(event, alpha_is_zero=level, theta_is_zero=known and n == 0)
        return None


def _exact_root(ring: Ring, part: Poly) -> list[Root]:
    """The root of a linear part if it is rational; else nothing."""
    if len(part) != 2 or part[1] == ZERO:
        return []
    (c, d), above = part[1], (-part[0][0], -part[0][1])
    a, b = ring.times(above, (c, -d))
    x = Fraction(a, c * c - ring.radicand * d * d)
    return [] if b else [Root(x, x, inverted=False)]


def _apart(first: Pair, second: Pair) -> bool:
    """Whether two directions, each of either sense, are different."""
    return bool((first[0] * second[1] - first[1] * second[0]).sign)


class Unclear(Exception):  # noqa: N818 - a verdict, not a fault
    """Intervals do not tell where these poses are."""


def never_degenerate(surface: Surface) -> bool:
    """Whether intervals prove that no pose that is singular for every length is degenerate for any.

    A pose and its opposite, with θ + 180° and the length −L, are one.
    """
    try:
        return all(_never(surface, pose) for pose in _poses(surface))
    except (Unclear, ZeroDivisionError, ValueError):
        return False


def _never(surface: Surface, pose: Directions) -> bool:
    def in_length(p: Graded) -> list[Interval]:
        return [pose.value(row) for row in p]

    j = surface.singular
    slopes = [in_length(slope(j, theta=side)) for side in (False, True)]
    if not _coprime(*slopes):
        return False
    conditions = [in_length(p) for leg in surface.legs for p in (leg.kernel, leg.kernel2)]
    return any(_coprime(p, q) for p, q in combinations(conditions, 2))


def _coprime(p: Sequence[Interval], q: Sequence[Interval]) -> bool:
    """Whether Sylvester's determinant excludes 0, so that two polynomials have no common root, even at ∞."""
    m, n = len(p) - 1, len(q) - 1
    zero = Interval(0, 0, p[0].bits)
    rows = [[zero] * k + list(reversed(p)) + [zero] * (n - 1 - k) for k in range(n)]
    rows += [[zero] * k + list(reversed(q)) + [zero] * (m - 1 - k) for k in range(m)]
    return bool(rows) and bool(_determinant(rows).sign)


def _determinant(rows: list[list[Interval]]) -> Interval:
    if len(rows) == 1:
        return rows[0][0]
    total = Interval(0, 0, rows[0][0].bits)
    for k, row in enumerate(rows):
        if row[0].lower or row[0].upper:
            term = row[0] * _determinant([other[1:] for i, other in enumerate(rows) if i != k])
            total = total - term if k % 2 else total + term
    return total


@dataclass(frozen=True)
class _Vectors:
    """a, b: from the fixed leg's base point to those of the free legs; m, n: likewise on the platform."""

    a: Vector
    b: Vector
    m: Vector
    n: Vector

    @classmethod
    def of(cls, surface: Surface) -> _Vectors:
        geometry, fixed = surface.geometry, surface.fixed
        factor, radicand = geometry.height
        omega = Interval.of(radicand, _BITS).root() if radicand != 1 else Interval.of(1, _BITS)
        zero = Interval.of(0, _BITS)
        corners = (
            (zero, zero),
            (Interval.of(geometry.d1, _BITS), zero),
            (Interval.of(geometry.foot, _BITS), omega * Interval.of(factor, _BITS)),
        )
        base = [(Interval.of(x, _BITS), Interval.of(y, _BITS)) for x, y in geometry.base]
        first, second = (leg - 1 for leg in geometry.free_legs(fixed))
        here = fixed - 1
        return cls(
            _minus(base[first], base[here]),
            _minus(base[second], base[here]),
            _minus(corners[first], corners[here]),
            _minus(corners[second], corners[here]),
        )


def _poses(surface: Surface) -> Iterator[Directions]:
    """All of them, one of two opposite ones each."""
    v, radicand = _Vectors.of(surface), surface.ring.radicand
    base, side = _minus(v.a, v.b), _minus(v.m, v.n)
    meeting = _times(_minus(_times(v.m, v.b), _times(v.n, v.a)), _conjugate(side))
    for direction, platform, ground in ((v.a, v.m, v.a), (v.b, v.n, v.b), (meeting, side, base)):
        turned = _unit(_times(ground, _conjugate(platform)))
        for alpha in (turned, (turned[0].scaled(-1), turned[1].scaled(-1))):
            yield Directions(alpha, _unit(direction), radicand)
    for alpha in _parallel(v):
        along = _minus(_times(v.m, alpha), v.a)
        yield Directions(alpha, _unit(along), radicand)


def _parallel(v: _Vectors) -> Iterator[Pair]:
    """The z of (m z − a) × (n z − b) = 0, which is r − p cos α − q sin α."""
    mixed = _minus(_times(_conjugate(v.m), v.b), _times(v.a, _conjugate(v.n)))
    r = _imaginary(_times(_conjugate(v.m), v.n)) + _imaginary(_times(_conjugate(v.a), v.b))
    # Im(conj(z) (conj(m) b − a conj(n))) = Im(mixed) cos α − Re(mixed) sin α
    p, q = mixed[1], mixed[0].scaled(-1)
    square = p * p + q * q
    rest = square - r * r
    if rest.sign < 0:
        return
    if not rest.sign:
        raise Unclear
    root = rest.root()
    for sign in (1, -1):
        s = root.scaled(sign)
        yield (p * r - q * s).over(square), (q * r + p * s).over(square)


def _minus(x: Vector, y: Vector) -> Vector:
    return x[0] - y[0], x[1] - y[1]


def _times(x: Vector, y: Vector) -> Vector:
    return x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0]


def _conjugate(x: Vector) -> Vector:
    return x[0], x[1].scaled(-1)


def _imaginary(x: Vector) -> Interval:
    return x[1]


def _unit(x: Vector) -> Pair:
    """The direction of a vector.

    Raises:
        ZeroDivisionError: it may be 0.
    """
    size = (x[0] * x[0] + x[1] * x[1]).root()
    return x[0].over(size), x[1].over(size)
