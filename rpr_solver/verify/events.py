"""All events of a range of lengths: poses at which cusps are born or vanish, or pass the limit of a leg.

They are the zeros of two systems (mathematics.md#events-by-boxes): J = E = W = 0, swallowtails, and J = 0,
∇J = 0, lips and beak-to-beaks; with limits those of J = E = 0 at which a leg has the length of a limit, too.
Each is regular, so it is isolated, and J = E = 0 is a curve there, with the tangent

    T = ∇J × ∇E,    of which the component in t is D = J_α E_θ − J_θ E_α.

Where D = 0 ≠ T·∇D, t has an extremum on the curve: two cusps are born, or vanish.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from flint import arb, ctx

from rpr_solver.boxes import Balls, Box, Boxes, System, Undecided, Zero, contains, sieved
from rpr_solver.verify.claims import Open
from rpr_solver.verify.equations import ALPHA, LENGTH, THETA, Closing, Jets, Lengths, Mechanism, Poses
from rpr_solver.verify.finding import OF_SIEVE, TURNED, solved, torus
from rpr_solver.verify.listed import pose_numbers
from rpr_solver.verify.meetings import Meeting
from rpr_solver.verify.numbers import angle, ball
from rpr_solver.verify.systems import AtLimit, Coalescing, Critical, regular_leg
from rpr_solver.verify.work import Work

_PARTS, _SIEVED, _SIEVED_APART = 16, 250_000, 20_000
"""The torus is cut in 16 by 16 parts at first; so many boxes are looked at, at most, and where legs close."""
_RADII = (2.0**-5, 2.0**-7, 2.0**-10, 2.0**-14)
"""Within one of them, in units, is no event about a pose at which two legs close, or it is open."""
_SMALL = 2.0**-12
"""A box of this size that is left there says that there may be one."""
_NODE_BITS = 256
_BITS = (32, 64, 128, 256, 512, 1024)
"""Bits after the point with which signs are sought."""
SWALLOWTAIL, LIPS, BEAK_TO_BEAK, LIMIT = "swallowtail", "lips", "beak-to-beak", "limit"
QUADRUPLE = "quadruple"
"""Both free legs vanish, and four poses coalesce."""


@dataclass(frozen=True)
class Limit:
    """A limit of a free leg: the length is to be less than it, or greater."""

    leg: int
    length: Fraction
    is_upper: bool

    def admits(self, lengths: Mapping[int, arb]) -> bool | None:
        """Whether the legs of a pose keep it strictly; None if that is open."""
        room = ball(self.length) - lengths[self.leg]
        if not self.is_upper:
            room = -room
        return True if room > 0 else False if room <= 0 else None


@dataclass(frozen=True)
class Event:
    """A pose at which the number of cusps changes, or may.

    Attributes:
        kind: what it is.
        space: the lengths in whose variables it is a zero.
        zero: α, θ and t.
        limit: that which is passed, for the kind ``"limit"``.
    """

    kind: str
    space: Lengths
    zero: Zero
    limit: Limit | None = None

    def lengths(self, bits: int) -> dict[int, arb]:
        """The lengths of the legs."""
        return {**self.space.on(self.zero.within(bits), 0).lengths, **self._closed}

    def numbers(self, box: Box) -> Mapping[str, arb]:
        """The numbers that documents print, by the names of the members, for a box of it."""
        return {**pose_numbers(self.space, box), **{f"l{leg}": x for leg, x in self._closed.items()}}

    @property
    def _closed(self) -> Mapping[int, arb]:
        """The legs that vanish, of which squares in balls have no roots."""
        return dict.fromkeys(self.space.mechanism.free, arb(0)) if self.kind == QUADRUPLE else {}

    def change(self, limits: Sequence[Limit]) -> int:
        """By how much the number of cusps strictly within limits changes as the length grows.

        Raises:
            Open: it is not decided.
        """
        if self.kind == QUADRUPLE:
            return 0
        others = [x for x in limits if x is not self.limit]
        if not decided(lambda bits: all_of(x.admits(self.lengths(bits)) for x in others)):
            return 0
        step = 1 if decided(lambda bits: _sign(self._step(bits))) else -1
        return step * (1 if self.limit else 2) * (-1 if self.space.beyond else 1)

    def _step(self, bits: int) -> arb:
        """A number with the sign of the change of the number of cusps as t grows."""
        box = self.zero.within(bits)
        poses = self.space.on(box, 3)
        j, e = poses.singular, poses.along(poses.singular, regular_leg(self.space, box))
        d = j.d(ALPHA) * e.d(THETA) - j.d(THETA) * e.d(ALPHA)
        a, b = j.gradient, e.gradient
        tangent = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], d.value)
        if self.limit is None:
            # t has a minimum on the curve if T·∇D > 0: there are two cusps for greater t
            return _along(tangent, d)
        # as t grows, the squared length grows if T·∇f and D have one sign
        growth: arb = _along(tangent, self._excess(poses)) * d.value
        return -growth if self.limit.is_upper else growth

    def _excess(self, poses: Poses) -> Jets:
        assert self.limit is not None
        return AtLimit(self.space, self.limit.leg, self.limit.length).excess(poses)


def _along(tangent: Sequence[arb], function: Jets) -> arb:
    return sum((x * y for x, y in zip(tangent, function.gradient, strict=True)), arb(0))


def _sign(x: arb) -> bool | None:
    """Whether a number is > 0, None if that is open."""
    return True if x > 0 else False if x < 0 else None


def all_of(sides: Iterator[bool | None]) -> bool | None:
    """Whether all hold; None if that is open."""
    found = list(sides)
    return False if False in found else None if None in found else True


def decided(ask: Callable[[int], bool | None]) -> bool:
    """An answer, with as many bits as it needs.

    Raises:
        Open: it is not decided.
    """
    for bits in _BITS:
        with ctx.workprec(bits + 64):
            try:
                if (answer := ask(bits)) is not None:
                    return answer
            except Undecided:
                continue
    raise Open("a number is too near to 0 for its sign to be decided")


def events_of(
    mechanism: Mechanism, start: Fraction, stop: Fraction | None, limits: Sequence[Limit], work: Work
) -> list[Event]:
    """All events with lengths of the fixed leg strictly between two, in no order; no stop is infinity.

    Raises:
        Open: they are not all isolated, or not decided with the work that is left.
    """
    if mechanism.geometry.is_similar_pair:
        return []
    if mechanism.geometry.is_singular_pair:
        raise Open("such triangles have degenerate poses at all lengths")
    unit, events = Fraction(2) ** mechanism.geometry.size, []
    for beyond in (False, True):
        low, high = start / unit, None if stop is None else stop / unit
        ends = [low, Fraction(1) if high is None else min(high, Fraction(1))]
        if beyond:
            ends = [Fraction(0) if high is None else 1 / high, Fraction(1) if low <= 1 else 1 / low]
        if ends[0] >= ends[1]:
            continue
        space = Lengths(mechanism, beyond=beyond)
        infinite = nodes_at_infinity(mechanism) if beyond and not ends[0] else []
        span = _down(ends[0]), _up(ends[1])
        boxes = torus(_PARTS, span) if beyond else _apart(mechanism, limits, span, work)
        for event in _zeros(space, limits, boxes, infinite, work):
            if _is_between(event.zero, ends):
                events.append(event)
    return events


def nodes_at_infinity(mechanism: Mechanism) -> list[Box]:
    """The zeros of both systems at 1/L = 0 if a triangle is flat (mathematics.md#events-by-boxes).

    J₁ is a product then, of a sine of α − θ and one of θ; they are where both are 0.
    """
    with ctx.workprec(_NODE_BITS):
        f, g = mechanism.legs.squares.values()
        arms, bases = ([own.moving[key] for own in (f, g)] for key in ((1, -1), (0, 1)))
        if mechanism.geometry.is_platform_flat:
            factors = arms[0], bases[1] - bases[0] * (arms[1] / arms[0]).real
        elif mechanism.geometry.is_base_flat:
            factors = arms[1] - arms[0] * (bases[1] / bases[0]).real, bases[0]
        else:
            return []
        turn, theta = (-angle(c) for c in factors)
        halves = [(i * arb.pi(), k * arb.pi()) for i in (0, 1) for k in (0, 1)]
        return [[turn + theta + x + y, theta + y, arb(0)] for x, y in halves]


def _apart(mechanism: Mechanism, limits: Sequence[Limit], span: tuple[float, float], work: Work) -> Boxes:
    """All poses with lengths between two, in units, but for those beside poses at which two legs close.

    Those with |α − α₀| ≤ r and L ≤ r/2 are left out if it is proved that there is no event with t ≤ r in the
    space of these poses: t² = tan² ((α − α₀)/2) + L² is less than r² there (mathematics.md#legs-that-close).

    Raises:
        Open: there may be events however small r is.
    """
    spaces = [Closing(mechanism, closing=leg) for leg in mechanism.closing_legs]
    radii = [r for r in _RADII if r > 2 * span[0]]
    if not spaces or not radii:
        return torus(_PARTS, span)
    r = next((r for r in radii if all(_is_empty(space, limits, r, work) for space in spaces)), None)
    if r is None:
        raise Open("there may be events, or a limit is passed, beside a pose at which two legs vanish")
    with ctx.workprec(_NODE_BITS):
        places = sorted((angle(space.start) for space in spaces), key=lambda x: x.mid())
        lows, _ = Balls.of([x + r for x in places]).ends()
        _, highs = Balls.of([x - r for x in [*places[1:], places[0] + 2 * arb.pi()]]).ends()
    top = min(r / 2, span[1])
    near = [torus(_PARTS, (span[0], top), alpha=x) for x in zip(lows, highs, strict=True) if x[0] < x[1]]
    return Boxes.joined([*near, *([torus(_PARTS, (top, span[1]))] if top < span[1] else [])])


def _is_empty(space: Closing, limits: Sequence[Limit], r: float, work: Work) -> bool:
    """Whether it is proved that a space has no event with 0 < t ≤ r.

    Raises:
        Open: nor will it be for a smaller r, as functions vanish on curves; or there is no work left.
    """
    # L = t cos ψ is not negative
    start = torus(_PARTS, (0.0, r), alpha=(-1.6, 1.6))
    for system in (Coalescing(space, 2), Critical(space)):
        sieve = sieved(system, start, _SMALL, _SIEVED_APART)
        work.spend(sieve.looked // OF_SIEVE)
        if not sieve.ended:
            raise Open("poses are degenerate where two legs vanish")
        if len(sieve.boxes):
            return False
    # in units, the corners of the platform are within L + 2 |y| |m| ≤ 3 t of where they are at t = 0
    unit = arb(2) ** space.mechanism.geometry.size
    near = {leg: arb(abs(gap).mid(), abs(gap).rad() + 3 * r * unit) for leg, gap in space.gaps.items()}
    return not any(near[x.leg].overlaps(ball(x.length)) for x in limits)


def _zeros(
    space: Lengths,
    limits: Sequence[Limit],
    start: Boxes,
    infinite: Sequence[Box],
    work: Work,
) -> Iterator[Event]:
    """The events of lengths up to the unit, or beyond it, but for those that are known to be at infinity."""

    meeting = Meeting.of(space, start, work)
    rooms = [meeting.room] if meeting else []

    def found(system: System, known: Sequence[Box] = ()) -> Sequence[Zero]:
        result = solved(system, start, _SIEVED, work, known=known)
        if result.open:
            raise Open("events are not all isolated, or two are very near to each other")
        with ctx.workprec(_NODE_BITS):
            return [x for x in result.zeros if not any(contains(x.room, TURNED(y, x.room)) for y in infinite)]

    if meeting:
        yield Event(QUADRUPLE, space, meeting)
    for zero in found(Coalescing(space, 2), rooms):
        event = Event(SWALLOWTAIL, space, zero)
        decided(lambda bits, x=event: _is_smooth(x, bits))  # type: ignore[misc]
        yield event
    for zero in found(Critical(space), rooms):
        is_oval = decided(lambda bits, x=zero: _is_definite(space, x.within(bits)))  # type: ignore[misc]
        yield Event(LIPS if is_oval else BEAK_TO_BEAK, space, zero)
    for limit in limits:
        for zero in found(AtLimit(space, limit.leg, limit.length)):
            yield Event(LIMIT, space, zero, limit)


def _is_smooth(event: Event, bits: int) -> bool | None:
    """Whether the gradient of J in α and θ is not 0, as at swallowtails; None if it is open."""
    slopes = event.space.on(event.zero.within(bits), 1).singular.gradient
    return None if all(x.contains(0) for x in slopes[:2]) else True


def _is_definite(space: Lengths, box: Box) -> bool | None:
    """Whether the Hessian of J is definite; None if that is open."""
    j = space.on(box, 2).singular
    first, second = j.d(ALPHA), j.d(THETA)
    return _sign(first.gradient[0] * second.gradient[1] - first.gradient[1] * second.gradient[0])


def _is_between(zero: Zero, ends: Sequence[Fraction]) -> bool:
    """Whether t is strictly between two numbers.

    Raises:
        Open: it is not decided.
    """

    def ask(bits: int) -> bool | None:
        x, (low, high) = zero.within(bits)[LENGTH], map(ball, ends)
        return True if x > low and x < high else False if x < low or x > high else None

    return decided(ask)


def _down(x: Fraction) -> float:
    return float(np.nextafter(float(x), -np.inf)) if x else 0.0


def _up(x: Fraction) -> float:
    return float(np.nextafter(float(x), np.inf))


@dataclass(frozen=True)
class Exchange:
    """The symmetry of a manipulator whose triangles are isosceles at the fixed leg.

    With |a| = |b| and |m| = |n|, α ↦ arg w − α and θ ↦ arg u − θ, where u = b/ā and w = u n̄/m, take each pose
    to one of the same length of the fixed leg in which the free legs have each other's lengths.
    """

    mechanism: Mechanism

    @cached_property
    def exists(self) -> bool:
        """Whether there is one, exactly."""
        fixed = self.mechanism.fixed
        base, platform = self.mechanism.geometry.squared_sides
        return len({base[fixed, leg] for leg in self.mechanism.free}) == 1 and (
            len({platform[fixed, leg] for leg in self.mechanism.free}) == 1
        )

    def image(self, box: Box) -> Box:
        """That of a box of poses and t."""
        fixed, geometry = self.mechanism.fixed, self.mechanism.geometry
        (a, b), (m, n) = (
            [x[leg - 1] - x[fixed - 1] for leg in self.mechanism.free]
            for x in (geometry.base, geometry.platform)
        )
        u = b / a.conjugate()
        w = u * n.conjugate() / m
        return [angle(w) - box[0], angle(u) - box[1], *box[2:]]

    def takes(self, first: Event, second: Event) -> bool:
        """Whether it is proved that it takes an event to another, so that both have the same length."""
        if not self.exists or first.kind != second.kind or first.space is not second.space:
            return False
        with ctx.workprec(256):
            image = TURNED(self.image(first.zero.within(128)), second.zero.room)
        return contains(second.zero.room, image)
