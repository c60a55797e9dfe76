"""Claims about a path in time: its motion, and what it deviates from linear motion from row to row.

Between two points the difference from a chord is at most that of its ends, and b x²/8 more, where b bounds
the second derivative and x is the distance (mathematics.md#linear-motion-between-samples). Where that is too
much, the distance is halved.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import accumulate, pairwise

from rpr_solver.verify.arcs import LegRates, Piece, Place, hull_of, point_at
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, finding, judged, worked
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.numbers import sums
from rpr_solver.verify.core.reader import Record, spend, spend_exact
from rpr_solver.verify.motions import KINDS, Motion, Run

_FIRST_DEPTH, _DEEPEST = 4, 20
_ROUNDED = Fraction(1, 10**11)
"""By how much a printed place may differ from where the motion is."""
_NAMES = ("l1", "l2", "l3")
Control = str | tuple[Fraction, Fraction, Fraction]
LegsAt = Callable[[Fraction], Sequence[Interval | Fraction]]
"""The lengths of legs 1, 2 and 3 at a place, that of the fixed leg exact."""


@dataclass(frozen=True)
class Untimed:
    """A path between two places, without a law of time: on each arc the parameter is linear in τ.

    Attributes:
        places: those of the rows, and those where arcs meet between them.
        marks: the parameters there.
    """

    rates: LegRates
    places: Sequence[Fraction]
    marks: Sequence[Fraction]

    @classmethod
    def of(cls, rates: LegRates, ends: tuple[Fraction, Fraction], legs: LegsAt) -> Untimed:
        """That between two places: about in proportion to the ways of the legs from arc to arc."""
        first, last = ends
        corners = [Fraction(n) for n in range(int(first) + 1, -int(-last // 1))]
        places = [first, *corners, last]
        points = [legs(place) for place in places] if corners else [[], []]
        ways = [
            sum(abs(_near(x) - _near(y)) for x, y in zip(*pair, strict=True)) for pair in pairwise(points)
        ]
        shares = [Fraction(x / (sum(ways) or 1)) for x in accumulate(ways[:-1])]
        marks = [Fraction(0), *shares, Fraction(1)]
        if any(x >= y for x, y in pairwise(marks)):
            marks = [Fraction(n, len(ways)) for n in range(len(ways) + 1)]
        return cls(rates, places, marks)

    def _arc(self, x: Fraction) -> int:
        return next(
            n for n in range(len(self.marks) - 1) if x < self.marks[n + 1] or n == len(self.marks) - 2
        )

    def place(self, x: Fraction) -> Fraction:
        """The place at a parameter."""
        n = self._arc(x)
        spend(len(self.marks))
        share = (x - self.marks[n]) / (self.marks[n + 1] - self.marks[n])
        return self.places[n] + share * (self.places[n + 1] - self.places[n])

    def bends(self, low: Fraction, high: Fraction, depth: int) -> Sequence[Fraction] | None:
        """Bounds of the second derivatives by the parameter, between two marks."""
        n = self._arc(low)
        speed = (self.places[n + 1] - self.places[n]) / (self.marks[n + 1] - self.marks[n])
        arc = min(int(self.places[n]), len(self.rates.pieces) - 1)
        start, stop = (self.places[n] + (x - self.marks[n]) * speed - arc for x in (low, high))
        rates = self.rates.on(arc, start, stop, depth)
        return None if rates is None else [leg[1].greatest * speed**2 for leg in rates]


def deviates(
    course: Motion | Untimed,
    marks: Sequence[Fraction],
    rows: tuple[Record, Record],
    most: Record,
    legs: LegsAt,
) -> Finding:
    """Whether linear motion between two rows deviates at most so much from a path.

    Args:
        course: the path, by its time or another parameter.
        marks: the parameters of the rows, and of what lies between them.
        rows: both rows.
        most: how much each leg may deviate.
        legs: the lengths at a place.

    Raises:
        OpenError: it is not decided.
    """
    begin, end = marks[0], marks[-1]
    printed = [[row[name].value for name in _NAMES] for row in rows]

    def off(x: Fraction) -> list[tuple[Fraction, Fraction]]:
        """Bounds of the absolute differences at a parameter."""
        share = (x - begin) / (end - begin)
        chord = [p + share * (q - p) for p, q in zip(*printed, strict=True)]
        return [_gap(leg, y) for leg, y in zip(legs(course.place(x)), chord, strict=True)]

    limits = [most[name] for name in _NAMES]
    known = [off(x) for x in marks]
    queue = deque((*x, *y, _FIRST_DEPTH) for x, y in zip(pairwise(marks), pairwise(known), strict=True))
    while queue:
        low, high, at_low, at_high, depth = queue.popleft()
        if any(x[0] > limit for ends in (at_low, at_high) for x, limit in zip(ends, limits, strict=True)):
            return ClaimStatus.REFUSED, "a leg deviates more"
        bends = course.bends(low, high, depth)
        if bends is not None and all(
            max(x[1], y[1]) + bend * (high - low) ** 2 / 8 <= limit
            for x, y, bend, limit in zip(at_low, at_high, bends, limits, strict=True)
        ):
            continue
        if depth >= _DEEPEST:
            raise OpenError("it is not decided how much legs deviate between rows")
        middle = (low + high) / 2
        between = off(middle)
        queue += [(low, middle, at_low, between, depth + 1), (middle, high, between, at_high, depth + 1)]
    return ClaimStatus.PROVED, "by the second derivatives of the legs"


def _near(x: Interval | Fraction) -> float:
    return float(x.middle if isinstance(x, Interval) else x)


def _gap(leg: Interval | Fraction, y: Fraction) -> tuple[Fraction, Fraction]:
    """Bounds of the absolute difference of a length from a number."""
    if isinstance(leg, Fraction):
        return abs(leg - y), abs(leg - y)
    gap = leg - Interval.of(y, leg.bits)
    return Fraction(max(gap.lower, -gap.upper, 0), 1 << gap.bits), gap.greatest


def is_lawful(own: Record, arcs: Sequence[Sequence[Control]], *, jerk: bool) -> bool:
    """Whether a law is one, and its arcs meet so that one parameter leads through them with its shares.

    The derivatives at both sides of a joint, by exact control points, then agree. With a limit of jerk each
    arc is a run, and the acceleration is continuous.
    """
    speeds, shares = own["speeds"], own["shares"]
    [*_, whole] = sums(shares)
    if speeds[0] or speeds[-1] or not any(speeds) or whole != 1:
        return False
    if jerk and (own["window"] == 1 or len(shares) > 1):
        return False
    return all(
        _agree(arc, following, after / before)
        for (arc, following), (before, after) in zip(pairwise(arcs), pairwise(shares), strict=True)
    )


def _agree(arc: Sequence[Control], following: Sequence[Control], ratio: Fraction) -> bool:
    """Whether the derivative at the start of an arc is ``ratio`` times that at the end of the one before."""
    near = arc[-2], arc[-1], following[1]
    if any(isinstance(p, str) for p in near):
        return False
    before, joint, after = near
    spend_exact(12, ratio, *before, *joint, *after)
    return all(
        (len(following) - 1) * (z - y) == ratio * (len(arc) - 1) * (y - x)  # type: ignore[operator]
        for x, y, z in zip(before, joint, after, strict=True)
    )


def rests(run: Run) -> bool:
    """Whether the legs rest within a run, as its law does, or as the derivative of an arc is 0.

    Raises:
        OpenError: it is not decided whether a derivative is.
    """
    queue = list(run.rates.pieces[run.first : run.first + len(run.shares)])
    while queue:
        piece = queue.pop()
        steps = ([y - x for x, y in pairwise(column)] for column in zip(*piece.controls, strict=True))
        if not any(hull_of(row).sign for row in steps):
            queue += piece.halves
    return not all(speed for _, speed, _, _ in run.law.ticks[1:])


@dataclass(frozen=True)
class Timing:
    """A path in time.

    Attributes:
        members: of its document.
        ends: the exact lengths of the fixed leg at both ends.
        arcs: the control points.
        lengths_at: the lengths of the legs in a box, by name.
    """

    members: Record
    fixed: str
    ends: Mapping[str, Fraction]
    pieces: Sequence[Piece]
    lengths_at: Callable[[Place], Mapping[str, Interval]]

    def claims(self) -> Iterator[Claim]:
        """The claims of the motion, the sampling and the deviation."""
        if (motion := self.members.get("motion")) is not None:
            yield from self._of_motion(motion)
        deviation = self.members.get("deviation")
        if (sampling := self.members.get("sampling")) is not None:
            yield judged(
                "/sampling", "the rows are as they were asked for", self._as_asked(sampling), "as they are"
            )
        if deviation is not None:
            claim = "legs that move linearly from row to row deviate at most so much"
            yield worked("/deviation", claim, partial(self._deviation, deviation))

    @cached_property
    def _lengths(self) -> list[list[Fraction]]:
        """The exact lengths of the fixed leg at the control points of the arcs."""
        return [
            [self.ends[p] if isinstance(p, str) else p[2] for p in arc]
            for arc in self.members["certificate"]["arcs"]
        ]

    @cached_property
    def _rates(self) -> LegRates:
        return LegRates.of(self.pieces, self._lengths)

    @cached_property
    def _motion(self) -> Motion | None:
        """The motion by its laws; None if they are none."""
        certificate = self.members["certificate"]
        laws, arcs = certificate["motion"], certificate["arcs"]
        counts = [len(own["shares"]) for own in laws]
        firsts = [0, *accumulate(counts)]
        jerk = "jerk" in self.members["motion"]
        if firsts[-1] != len(arcs):
            return None
        if all(
            is_lawful(own, arcs[n : n + k], jerk=jerk)
            for own, n, k in zip(laws, firsts, counts, strict=False)
        ):
            return Motion.of(laws, self._rates)
        return None

    def _of_motion(self, limits: Record) -> Iterator[Claim]:
        at, claim = "/certificate/motion", "the laws lead through all arcs, with speeds that have no jumps"
        yield worked(at, claim, lambda: finding(self._motion is not None, "by exact control points"))
        for kind in (x for x in KINDS if x in limits):
            claim = f"all legs keep their limits of {kind} at all times"
            yield worked(f"/motion/{kind}", claim, partial(self._keeps, kind, limits[kind]))
        yield worked(
            "/motion/stops", "the legs rest on the way at these times alone", partial(self._stops, limits)
        )
        yield worked("/duration", "the motion takes so long", self._duration)
        claim = "each row is where the motion is at its time"
        yield worked("/samples", claim, self._rows)

    def _known(self) -> Motion:
        if self._motion is None:
            raise OpenError("the laws of the motion are none")
        return self._motion

    def _keeps(self, kind: str, limits: Record) -> Finding:
        return self._known().keeps(kind, limits)

    def _stops(self, limits: Record) -> Finding:
        motion = self._known()
        right = limits["stops"] == motion.starts[1:-1] and not any(map(rests, motion.runs))
        return finding(right, "by the times of the runs, on which nothing rests", "they rest at others")

    def _duration(self) -> Finding:
        return finding(
            self.members["duration"] == self._known().starts[-1], "by the ticks of all runs", "it is another"
        )

    def _rows(self) -> Finding:
        motion = self._known()
        right = all(abs(x["place"] - motion.place(x["time"])) <= _ROUNDED for x in self.members["samples"])
        return finding(right, "by the law, apart from the digits of places", "a row is elsewhere")

    def _as_asked(self, sampling: Record) -> bool:
        if (step := sampling.get("step")) is not None:
            times = [x["time"] for x in self.members["samples"]]
            return (
                all(time == n * step for n, time in enumerate(times[:-1])) and times[-1] - times[-2] <= step
            )
        deviation = self.members.get("deviation")
        return deviation is not None and all(x <= sampling["chord"] for x in deviation.values())

    def legs(self, place: Fraction) -> list[Interval | Fraction]:
        """The lengths of the legs at a place."""
        arc = min(int(place), len(self.pieces) - 1)
        at = point_at(self.pieces[arc].controls, place - arc)
        found = self.lengths_at(at)
        row = self._lengths[arc]
        spend_exact(2 * len(row) ** 2, place, *row)
        while len(row) > 1:
            row = [x + (place - arc) * (y - x) for x, y in pairwise(row)]
        return [row[0] if name == self.fixed else found[name] for name in _NAMES]

    def _deviation(self, most: Record) -> Finding:
        motion = self._known() if "motion" in self.members else None
        for first, last in pairwise(self.members["samples"]):
            if motion is not None:
                found = deviates(motion, (first["time"], last["time"]), (first, last), most, self.legs)
            else:
                course = Untimed.of(self._rates, (first["place"], last["place"]), self.legs)
                found = deviates(course, course.marks, (first, last), most, self.legs)
            if found[0] is not ClaimStatus.PROVED:
                return found
        return found
