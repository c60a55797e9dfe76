"""Lengths at which something happens to the cusps of a slice, with the degenerate pose where it is known.

Of a degenerate pose, what vanishes is decided exactly, what does not by intervals; the kinds are those of
mathematics.md#kinds-of-degenerate-poses. Slices of similar and doubly flat triangles have no cusp: let L e be
the fixed leg, and let the other legs go from a and b on the base to m and n on the platform, as seen from
this leg; if m = κ a and n = κ b, or both triangles are flat, there is none (mathematics.md#special-shapes).
All numbers are rational then: κ is the quotient of two sides on one line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.verify.claims import ClaimStatus, Finding
from rpr_solver.verify.core.intervals import Interval, degrees
from rpr_solver.verify.core.krawczyk import Directions, direction, enclosed, form_on_axis, value
from rpr_solver.verify.core.numbers import HALF_WAY, Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.roots import Root, has_root, real_roots
from rpr_solver.verify.core.surds import ZERO, Poly, primitive, radical
from rpr_solver.verify.core.system import (
    Graded,
    Leg,
    Surface,
    System,
    at_length,
    gradient,
    slope,
)
from rpr_solver.verify.cusps import Limits, Point


@dataclass(frozen=True)
class Landmark:
    """A length at which a cusp may degenerate, or be at a limit: scaled, in a small interval.

    ``square`` is a name of the exact length, if it is known: equal ones are of one length.
    """

    scaled: Interval
    square: object = None

    def length(self, surface: Surface) -> Interval:
        """The length in the user's unit."""
        return self.scaled.over(Interval.of(surface.unit, self.scaled.bits))

    def rounds_to(self, surface: Surface, text: Printed) -> bool:
        """Whether its length rounds to a text; one that is exactly half way between two rounds to both."""
        if (right := text.rounds(self.length(surface))) is not None:
            return right
        ends = [(end * surface.unit) ** 2 for end in (text.lower, text.upper)]
        return self.square in [*ends, *((x, 0) for x in ends)]


@dataclass(frozen=True, kw_only=True)
class Event(Landmark):
    """A proved event: its kind, and a box of its pose, with α and θ in radians and as directions.

    ``zeros`` are the angles and lengths that are proved to be exactly 0, as documents name them; ``beside``
    is how many cusps tend to the pose, at least, as the length grows and as it falls to its own.
    """

    kind: str
    pose: tuple[Interval, Interval]
    directions: Directions
    zeros: frozenset[str] = frozenset()
    beside: tuple[int, int] = (0, 0)

    @classmethod
    def at(
        cls,
        kind: str,
        here: Directions,
        length: Landmark,
        zeros: Iterable[str],
        beside: tuple[int, int] = (0, 0),
    ) -> Event:
        """An event of known directions and length."""
        return cls(
            length.scaled,
            length.square,
            kind=kind,
            pose=(enclosed(here.alpha), enclosed(here.theta)),
            directions=here,
            zeros=frozenset(zeros),
            beside=beside,
        )

    def is_printed(self, surface: Surface, length: Printed, event: Record) -> bool:
        """Whether a printed event at a printed length may be this one."""
        return self.rounds_to(surface, length) and self.is_like(surface, event)

    def is_like(self, surface: Surface, event: Record, *, doubted: bool = False) -> bool:
        """Whether its kind, and all of its numbers but the fixed length, are those of a printed event."""
        unit = Interval.of(surface.unit, self.scaled.bits)
        squares = (value(self.directions, leg.squared, self.scaled) for leg in surface.legs)
        values = [*map(degrees, self.pose), *(square.root().over(unit) for square in squares)]
        wrong = Point.of(event, surface).wrong(values, doubted=doubted)
        return self.kind == event["kind"] and wrong is None

    def exactly(self, surface: Surface, event: Record, reason: str) -> Finding:
        """Proved, if each number that is printed as an exact 0 is one, and each other rounds to its text."""
        if not self.is_like(surface, event, doubted=True):
            return ClaimStatus.CHECKED, HALF_WAY
        if any(event[name].is_zero and name not in self.zeros for name in Point.of(event, surface).row):
            return ClaimStatus.CHECKED, f"{reason}; that a number is exactly 0, beyond the digits"
        return ClaimStatus.PROVED, reason


def distinct(landmarks: Sequence[Landmark]) -> list[Landmark]:
    """Without those whose lengths are exactly those of others."""
    known: dict[object, Landmark] = {}
    for n, landmark in enumerate(landmarks):
        known.setdefault(n if landmark.square is None else landmark.square, landmark)
    return list(known.values())


Vanishes = Callable[[Graded, int], bool]
"""Whether a polynomial is exactly 0, of degree k + 1 in θ in the k-th power of the length, or of degree k."""


class Unclear(Exception):  # noqa: N818 - a verdict, not a fault
    """Poses are not isolated, or degenerate for every length, or not told apart."""


def kind_of(surface: Surface, here: Directions, length: Interval, vanishes: Vanishes) -> str | None:
    """The kind of a pose with J = 0 that is degenerate and no cusp; None if it is not told.

    Raises:
        Unclear: something is 0 at one of two poses.
    """

    def at(p: Graded) -> Interval:
        return value(here, p, length)

    regular = [leg for leg in surface.legs if at(leg.alpha).sign or at(leg.theta).sign]
    if not regular:
        gradients = [p for leg in surface.legs for p in (leg.alpha, leg.theta)]
        if all(vanishes(p, 0) for p in gradients) and _independent(surface, at).sign:
            return "quadruple"
        return None
    if all(vanishes(p, 1) for p in surface.slopes):
        return _at_a_node(surface, regular[0], at, vanishes)
    if any(at(p).sign for p in surface.slopes):
        leg = regular[0]
        if _third(leg, at).sign and vanishes(leg.kernel, 1) and vanishes(leg.kernel2, 1):
            return "swallowtail"
    return None


def _at_a_node(
    surface: Surface, leg: Leg[Graded], at: Callable[[Graded], Interval], vanishes: Vanishes
) -> str | None:
    """The kind of a pose where J and its gradient vanish, by the Hessian of J."""
    (a, b), (c, d) = ([at(slope(p, theta=theta)) for theta in (False, True)] for p in surface.slopes)
    shape = (a * d - b * c).sign
    moving: Graded = ({}, surface.singular[1])
    doubtful = [p for p in (moving, leg.kernel2) if not at(p).sign]
    if not shape or (doubtful and not any(vanishes(p, 1) for p in doubtful)):
        return None
    if doubtful:
        return "isolated-point" if shape > 0 else "node"
    return "lips" if shape > 0 else "beak-to-beak"


def cusps_beside(surface: Surface, kind: str, here: Directions, length: Interval, vanishes: Vanishes) -> int:
    """How many cusps tend, at least, to a pose that is singular for every length, from each side of its own.

    Near a quadruple pose f and g are a quadratic map of the plane, which has a cusp; at a node one is
    known where v·∇E is exactly 0 (mathematics.md#cusps-beside-permanent-poses). 0 if intervals do not tell.
    """

    def at(p: Graded) -> Interval:
        return value(here, p, length)

    (a, b), (c, d) = ([at(slope(p, theta=theta)) for theta in (False, True)] for p in surface.slopes)
    e, f = (at(gradient(p)[2]) for p in surface.slopes)
    # the determinant of the second derivatives of J in both angles and the length, in which it is linear
    if not (e * (b * f - d * e) - f * (a * f - c * e)).sign:
        return 0
    if kind == "quadruple":
        return 1
    leg = next((leg for leg in surface.legs if at(leg.alpha).sign or at(leg.theta).sign), None)
    if kind != "node" or leg is None or not vanishes(leg.kernel2, 1):
        return 0
    return int(_third(leg, at).sign != 0)


def _third(leg: Leg[Graded], at: Callable[[Graded], Interval]) -> Interval:
    """v·∇(v·∇E)."""
    first, second = (at(slope(leg.kernel2, theta=theta)) for theta in (False, True))
    return at(leg.alpha) * second - at(leg.theta) * first


def _independent(surface: Surface, at: Callable[[Graded], Interval]) -> Interval:
    """The resultant of both Hessians as quadratic forms: if it is not 0, they have no common zero."""
    rows = []
    for leg in surface.legs:
        first, mixed = (at(slope(leg.alpha, theta=theta)) for theta in (False, True))
        rows.append((first, mixed.scaled(2), at(slope(leg.theta, theta=True))))
    f, g = rows
    outer, low, high = (f[i] * g[k] - g[i] * f[k] for i, k in ((0, 2), (0, 1), (1, 2)))
    return outer * outer - low * high


def on_axis(system: System, cos: int, bits: int) -> Iterator[Event]:
    """The poses of a slice with α = 0 (``cos`` is 1) or 180° (−1) where J and its gradient are 0, exactly.

    They are the common roots of three polynomials in tan(θ/2).
    """
    surface, ring, scaled = system.surface, system.ring, system.length * system.surface.unit

    def here(p: Graded) -> Poly:
        return form_on_axis(at_length(p, scaled), theta=False, cos=cos)

    forms = [here(p) for p in (surface.singular, *surface.slopes)]
    common: Poly = ()
    for form in forms:
        common = ring.gcd(common, primitive(form)) if common else primitive(form)
    if not common:
        return
    once = radical(ring, common)
    if all(form[-1] == ZERO for form in forms):
        once += (ZERO,)
    one = Interval.of(cos, bits), Interval.of(0, bits)
    for root in real_roots(ring, once) if len(once) > 1 else ():
        pose = Directions(one, direction(ring, once, root, bits), ring.radicand)
        length = Interval.of(scaled, bits)

        def vanishes(p: Graded, _: int, root: Root = root) -> bool:
            return has_root(ring, once, root, here(p))

        kind = kind_of(surface, pose, length, vanishes)
        zeros = {f"l{leg.number}" for leg in surface.legs if vanishes(leg.squared, 0)}
        zeros |= {"alpha_deg"} if cos > 0 else set()
        if root.axis == 1:
            zeros.add(f"theta{surface.fixed}_deg")
        if kind is not None:
            yield Event.at(kind, pose, Landmark(length), zeros)


_APART_BITS = 512
Side = tuple[int, int]
"""x + i y, scaled."""


@dataclass(frozen=True)
class Throughout:
    """Poses that all slices between two lengths have, or a curve; None is the end of the range."""

    kind: str
    count: int | None = None
    equation: str | None = None
    low: Landmark | None = None
    high: Landmark | None = None


class Shape:
    """Similar or doubly flat triangles: no slice has a cusp.

    Args:
        surface: the equations.
        a, b: the sides of the base.
        ratio: κ; 0 if the triangles are not similar.
    """

    def __init__(self, surface: Surface, a: Side, b: Side, ratio: Fraction) -> None:
        self.surface, self.a, self.b, self.ratio = surface, a, b, ratio
        self.area = a[0] * b[1] - a[1] * b[0]

    def events(self, bits: int) -> list[Event]:
        """All at which the number of cusps changes, and those beside which cusps are."""
        del bits
        return []

    def crossings(self, leg: int, limit: Fraction, bits: int) -> list[Landmark]:
        """The lengths at which a cusp is at a limit of a free leg, the first or the second."""
        del leg, limit, bits
        return []

    def counted(self, length: Fraction, limits: Limits) -> tuple[int, bool] | None:
        """The number of cusps of a slice within the limits, as it is proved; None if it is not told."""
        del length, limits
        return 0, True

    def throughout(self, start: Fraction, stop: Fraction | None, bits: int) -> list[Throughout]:
        """What is degenerate in all slices of a range but those of single lengths.

        Raises:
            Unclear: intervals do not tell.
        """
        found = []
        if self.ratio in (1, -1):
            found.append(Throughout("curve", equation=f"alpha = {0 if self.ratio > 0 else 180} deg"))
        if not self.area:
            shared = 2 * len(found)
            found += [Throughout("higher", shared)] if shared else []
            return [*found, Throughout("quadruple", 4 - shared)]
        sides = (self.a, self.b, (self.a[0] - self.b[0], self.a[1] - self.b[1]))
        first, second, third = (x * x + y * y for x, y in sides)
        # (2 R (κ ± 1))², R being the radius of the circle through the corners of the base
        circle = Fraction(first * second * third, self.area**2)
        squares = sorted(circle * (self.ratio + sign) ** 2 for sign in (1, -1))
        bits = _APART_BITS + 2 * bits
        ends = [Landmark(Interval.of(square, bits).root(), square) for square in squares if square]
        return [*found, *self._runs([*range(2 * len(ends), -1, -2)], ends, start, stop)]

    def _runs(
        self, counts: Sequence[int], ends: Sequence[Landmark], start: Fraction, stop: Fraction | None
    ) -> list[Throughout]:
        """Nodes, their numbers between the ends, in a range."""
        found: list[Throughout] = []
        after = [None if self._side(end, start) <= 0 else end for end in ends]
        for count, low, high in zip(counts, (None, *after), (*ends, None), strict=True):
            if high is not None and self._side(high, start) <= 0:
                continue
            if low is not None and stop is not None and self._side(low, stop) >= 0:
                break
            inside = high is None or stop is None or self._side(high, stop) < 0
            if found and found[-1].count == count:
                low = found.pop().low
            found.append(Throughout("node", count, None, low, high if inside else None))
        return [part for part in found if part.count]

    def _side(self, end: Landmark, length: Fraction) -> int:
        """Whether a length is less or greater than another one, which is in the user's unit."""
        scaled = length * self.surface.unit
        if isinstance(end.square, Fraction):
            return (end.square > scaled**2) - (end.square < scaled**2)
        return told((end.scaled - Interval.of(scaled, end.scaled.bits)).sign)


def told(sign: int) -> int:
    """A sign that is not 0.

    Raises:
        Unclear: it is.
    """
    if not sign:
        raise Unclear
    return sign
