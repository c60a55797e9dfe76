"""A range of lengths cut by events: what lies between them, and what is left open about them.

Where the events are all, the number of cusps is constant between them, and one slice proves it
(mathematics.md#completeness-of-the-events); where they may not be all, it is open.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import isqrt
from secrets import randbelow

from rpr_solver.verify.claims import (
    Claim,
    ClaimStatus,
    Finding,
    OpenError,
    brief,
    finding,
    judged,
    matching,
    worked,
)
from rpr_solver.verify.core.intervals import Interval, ends_of
from rpr_solver.verify.core.numbers import SPARE_BITS, Printed, bits_of, exact
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.cusps import UNLIMITED, Limits, Slice
from rpr_solver.verify.events import Crossings, Events
from rpr_solver.verify.landmarks import Event, Landmark, Throughout

_DRAWN_BITS, _SPREAD, _DRAWS = 64, 1 << 20, 3


def in_interval(number: int) -> str:
    """What an interval claims."""
    return f"{number} cusps in every slice of this interval"


_ALONE = "it joins no curve, and it is open whether another cusp passes there"
DEGENERATE = "what is degenerate throughout an interval, or along a curve"
COMPLETE = "all events of this leg are found anew, and each is proved"
Span = tuple[Fraction, Fraction]
"""Two numbers between which a length is."""


@dataclass(frozen=True)
class Requirement:
    """Lengths of the fixed leg, limits of the others, and what numbers of cusps are admitted; None is any."""

    start: Fraction
    stop: Fraction | None
    limits: Limits = UNLIMITED
    least: int | None = None
    most: int | None = None

    @classmethod
    def of(cls, members: Record) -> Requirement:
        """That of a document."""
        span, limits = members["range"], members.get("limits") or {}
        bounds = {int(name[1]): (limit["min"], limit["max"]) for name, limit in limits.items()}
        counts = members["min_cusps"], members["max_cusps"]
        return cls(span["from"], span["to"], Limits(bounds), *counts)

    def admits(self, number: int) -> bool:
        """Whether a number of cusps is admitted."""
        return (self.least is None or number >= self.least) and (self.most is None or number <= self.most)

    def admits_all(self, most: int) -> bool:
        """Whether all numbers of cusps up to a greatest one are admitted."""
        return not self.least and (self.most is None or self.most >= most)

    @property
    def is_bounded(self) -> bool:
        """Whether there is a least or a greatest number."""
        return self.least is not None or self.most is not None


class Range:
    """A range of lengths that is cut by transitions, each with its printed length, and all events.

    Args:
        events: all events.
        cuts: the printed lengths.
        start, stop: the range; None is an open end.
        crossings: where cusps cross joint limits, which are treated as further events.
    """

    def __init__(
        self,
        events: Events,
        cuts: Sequence[Printed],
        start: Fraction,
        stop: Fraction | None,
        crossings: Crossings | None = None,
    ) -> None:
        self.events, self.cuts, self.start, self.stop = events, cuts, start, stop
        found = [*events.found, *events.unnamed, *(crossings.found if crossings else ())]
        lengths = [event.length(events.surface) for event in found]
        self.spans = _spans(found, lengths, events.surface.unit)
        """Of all events; those of one length have one."""
        self._names = [n if x.square is None else (x.square,) for n, x in enumerate(found)]
        self.at = [
            [
                k
                for k in _near(cut, self.spans)
                if found[k].rounds_to(events.surface, cut) and not self.is_beyond(k)
            ]
            for cut in cuts
        ]
        """The events at each cut; where as many cuts are printed alike as they have lengths, each has one."""
        for n, cut in enumerate(cuts):
            alike = [k for k, other in enumerate(cuts) if other.text == cut.text]
            groups = self.grouped(self.at[n])
            if len(alike) == len(groups):
                for k, group in zip(alike, groups, strict=True):
                    self.at[k] = group
        self.twice = {n for n in range(1, len(cuts)) if not set(self.at[n]).isdisjoint(self.at[n - 1])}
        """The cuts that have an event of the one before, which is printed alike."""
        self.others = [k for k in self._inside() if not any(k in group for group in self.at)]
        """The events within the range that are at no cut."""
        self.merged = any(_are_apart(self.spans[k] for k in group) for group in self.at)
        """Whether events of different lengths are at one cut: an interval between them is hidden."""
        also = crossings.open if crossings else ()
        self.open = tuple(sorted({*events.open, *also, *self._left_open()}))
        """What is open about the events; empty if these are all."""

    def _inside(self) -> Iterator[int]:
        for k, (low, high) in enumerate(self.spans):
            if self.start < low and (self.stop is None or high < self.stop):
                yield k

    def is_beyond(self, k: int) -> bool:
        """Whether an event is outside the range."""
        low, high = self.spans[k]
        return high <= self.start or (self.stop is not None and self.stop <= low)

    def holds(self, n: int) -> Finding:
        """Whether a cut whose digits leave it open is within the range: one of its events is."""
        inside = [*self._inside()]
        if any(k in inside for k in self.at[n]):
            return ClaimStatus.PROVED, "an event of each is, whatever its digits"
        if self.at[n] or self.open:
            return ClaimStatus.CHECKED, "up to half a unit of the last digit beside an end of the range"
        return ClaimStatus.REFUSED, "the event is beyond the range"

    def _left_open(self) -> Iterator[str]:
        if self.merged:
            yield "events of different lengths are at one length as printed"
        ends = [self.start] if self.stop is None else [self.start, self.stop]
        if any(low <= end <= high and low < high for low, high in self.spans for end in ends):
            yield "an event is at an end of the range"
        inside = [self.spans[group[0]] for group in self.grouped(self._inside())]
        if any(b[0] <= a[1] for a, b in pairwise(inside)):
            yield "two events have one length, as far as intervals tell"

    def gaps(self, n: int) -> list[Span]:
        """The parts of an interval between the events, each without any; empty if one has no length."""
        low = (
            max((self.spans[k][1] for k in self.at[n - 1]), default=self.cuts[n - 1].upper)
            if n
            else self.start
        )
        if n < len(self.cuts):
            high = min((self.spans[k][0] for k in self.at[n]), default=self.cuts[n].lower)
        else:
            geometry = self.events.surface.geometry
            latest = max((high for _, high in self.spans), default=low)
            last = 2 * max(low, latest) + max(geometry.d1, abs(geometry.a2x))
            high = last if self.stop is None else self.stop
        inside = sorted(
            {self.spans[k] for k in self.others if low <= self.spans[k][0] and self.spans[k][1] <= high}
        )
        edges = [low, *(end for span in inside for end in span), high]
        gaps = list(zip(edges[::2], edges[1::2], strict=True))
        return gaps if all(a < b for a, b in gaps) else []

    def counted(self, n: int, number: int, limits: Limits = UNLIMITED) -> Finding:
        """Whether all slices of an interval have so many cusps: by a slice in each part of it."""
        gaps, doubt = self.gaps(n), [*self.open]
        if not gaps:
            raise OpenError("nothing is left between events at its ends")
        for gap in gaps:
            length, found = self.slice_in(gap, limits)
            if found is None:
                raise OpenError("the cusps of a slice in it are not counted")
            if found[0] != number:
                return ClaimStatus.REFUSED, f"the slice at {brief(length)} has {found[0]}"
            if not found[1]:
                doubt.append("the number of cusps of a slice in it is not proved")
        if doubt:
            return ClaimStatus.CHECKED, f"a slice at random has as many; left open: {'; '.join(doubt)}"
        return ClaimStatus.PROVED, f"{COMPLETE}; a slice between them has as many"

    def slice_in(self, gap: Span, limits: Limits = UNLIMITED) -> tuple[Fraction, tuple[int, bool] | None]:
        """A length at random, and the number of cusps of its slice; other lengths if it is not proved."""
        count = self.events.counter(limits)
        for _ in range(_DRAWS):
            length = drawn_within(gap)
            found = count(Slice(self.events.surface.at(length)))
            if found is not None and found[1]:
                break
        return length, found

    def complete(self) -> Finding:
        """Whether the events are all, and each within the range is at a cut."""
        if self.others:
            reason = f"an event at {brief(self.spans[self.others[0]][0])} is missing"
            if self.others[0] >= len(self.events.found):
                return ClaimStatus.NOT_CHECKED, f"{reason}, if it changes anything"
            return ClaimStatus.REFUSED, reason
        if self.merged:
            return ClaimStatus.REFUSED, "events of different lengths are at one transition"
        if self.twice and not self.open:
            return ClaimStatus.REFUSED, "one event is at two transitions"
        return self.rests_on_all()

    def rests_on_all(self) -> Finding:
        """How something stands that holds if the events are all."""
        if self.open:
            return ClaimStatus.CHECKED, f"left open: {'; '.join(self.open)}"
        return ClaimStatus.PROVED, COMPLETE

    def listed(self, end: Record) -> list[Event]:
        """The events that are found anew and listed at an end of a curve."""
        surface = self.events.surface
        return [
            found
            for event in end["events"]
            for found in self.events.found
            if found.is_printed(surface, end[f"l{surface.fixed}"], event)
        ]

    def reached(self, end: Record, last: Fraction, others: int, *, above: bool) -> Finding:
        """Whether curves lead to an end at which they join no other: they have nowhere else to go.

        From the slice of their last point to the length of the end is no event, and as many cusps of it tend
        to the poses of the end as do not pass (mathematics.md#cusps-beside-permanent-poses).

        Args:
            end: the end of a curve.
            last: the length of its last point.
            others: how many cusps of that slice are not proved to pass.
            above: whether the last point is above the end.
        """
        own, found = self.listed(end), self.events.found
        if not own or others <= 0 or self.events.open:
            raise OpenError(_ALONE)
        square = own[0].square
        there = [k for k, x in enumerate(found) if x is own[0] or x.square == square is not None]
        low, high = self.spans[there[0]]
        apart = high < last if above else last < low
        low, high = min(low, last), max(high, last)
        apart &= all(b < low or high < a for k, (a, b) in enumerate(self.spans) if k not in there)
        poses = [found[k] for k in there if found[k].beside[above]]
        listed = all(any(x is known for known in own) for x in poses)
        if not (apart and listed) or sum(x.beside[above] for x in poses) != others:
            raise OpenError(_ALONE)
        return ClaimStatus.PROVED, f"{others} cusps tend to the pose of the end, and all others pass"

    def grouped(self, events: Iterable[int]) -> list[list[int]]:
        """Some events by their lengths, which ascend; that intervals agree does not make two lengths one."""
        groups: dict[object, list[int]] = {}
        for k in events:
            low, high = self.spans[k]
            groups.setdefault(("at", low) if low == high else self._names[k], []).append(k)
        return sorted(groups.values(), key=lambda group: self.spans[group[0]])

    def degenerate(self, listed: Sequence[Record]) -> Finding:
        """What is degenerate throughout an interval: nothing where all events are isolated."""
        known = self.events.throughout(self.start, self.stop)
        if known is None:
            raise OpenError(f"left open: {'; '.join(self.events.open) or 'lengths are not told apart'}")
        right = len(listed) == len(known) and None not in matching(listed, known, self._is)
        reason = "nothing is, as all events are isolated" if self.events.shape is None else "by the shape"
        return finding(right, COMPLETE, f"{reason}; {len(known)} should be listed")

    def _is(self, row: Record, part: Throughout) -> bool:
        """Whether an entry says what is known."""
        if (row["kind"], row.get("count"), row.get("equation")) != (part.kind, part.count, part.equation):
            return False
        for name, end, outer in (("from", part.low, self.start), ("to", part.high, self.stop)):
            text = row[name]
            if end is None and (text.value if isinstance(text, Printed) else text) != outer:
                return False
            if end and not (isinstance(text, Printed) and end.rounds_to(self.events.surface, text)):
                return False
        return True


def ordered(
    at: str,
    cuts: Sequence[Printed],
    span: tuple[Fraction, Fraction | None],
    rows: Sequence[Record],
    holds: Callable[[int], Finding],
) -> Iterator[Claim]:
    """Whether cuts ascend within a range, and intervals lie between them and fill it.

    Whether the range holds a cut is asked where its digits leave it open.
    """
    start, stop = span
    ends = [start] if stop is None else [start, stop]
    claim = "a range of lengths, and cuts that ascend within it"
    right = stop is None or start < stop
    right = right and all(a.value <= b.value for a, b in pairwise(cuts))
    for x in cuts:
        right = right and start <= x.upper and (stop is None or x.lower <= stop)
    doubtful = [n for n, x in enumerate(cuts) if any(x.lower <= end <= x.upper for end in ends)]
    if right and doubtful:
        yield worked(at, claim, lambda: _worst(map(holds, doubtful)))
    else:
        yield judged(at, claim, right, "as printed", "they contradict each other")
    inner = [x.text for x in cuts]
    right = [row["from"] for row in rows[1:]] == inner and [row["to"] for row in rows[:-1]] == inner
    if right:
        outer = rows[0]["from"], rows[-1]["to"]
        first, last = (None if x is None else exact(x, "/intervals") for x in outer)
        right = (first, last) == (start, stop)
    claim = "the intervals lie between the cuts, and fill the range"
    yield judged("/intervals", claim, right, "as printed", "they contradict each other")


def _worst(findings: Iterable[Finding]) -> Finding:
    """The finding that says least."""
    order = [ClaimStatus.REFUSED, ClaimStatus.CHECKED, ClaimStatus.PROVED]
    return min(findings, key=lambda finding: order.index(finding[0]))


def bits_in(span: tuple[Fraction, Fraction | None], rows: Sequence[Record]) -> int:
    """Bits for lengths beside the ends of a range, and for those between which something is degenerate."""
    sizes = [x.denominator.bit_length() for x in span if x is not None]
    ends = [row[name] for row in rows for name in ("from", "to")]
    return max(bits_of([x for x in ends if isinstance(x, Printed)]), max(sizes) + SPARE_BITS)


def _spans(found: Sequence[Landmark], lengths: Sequence[Interval], unit: int) -> list[Span]:
    """Where the lengths are; that of equal ones is where all of their intervals are, or a known fraction."""
    spans = [ends_of(x) for x in lengths]
    named: dict[object, Span] = {}
    for landmark, (low, high) in zip(found, spans, strict=True):
        before = named.get(landmark.square, (low, high))
        named[landmark.square] = max(low, before[0]), min(high, before[1])
        if (known := _root(landmark.square)) is not None:
            named[landmark.square] = known / unit, known / unit
    return [span if x.square is None else named[x.square] for x, span in zip(found, spans, strict=True)]


def _near(cut: Printed, spans: Sequence[Span]) -> list[int]:
    """The numbers of the lengths that may round to a cut."""
    lower, upper = cut.lower, cut.upper
    return [k for k, (low, high) in enumerate(spans) if lower <= high and low <= upper]


def _root(name: object) -> Fraction | None:
    """The length of a name that is the square of a fraction."""
    match name:
        case (Fraction() as square, 0) | (Fraction() as square):
            n, d = isqrt(square.numerator), isqrt(square.denominator)
            return Fraction(n, d) if Fraction(n, d) ** 2 == square else None
    return None


def _are_apart(spans: Iterable[Span]) -> bool:
    return any(a[1] < b[0] for a, b in pairwise(sorted(spans)))


def drawn_within(span: Span) -> Fraction:
    """A length between two others, drawn at random by the operating system, of few places."""
    low, high = span
    step = (high - low) / (_SPREAD + 2)
    place = low + (high - low - 2 * step) * Fraction(randbelow(1 << _DRAWN_BITS), 1 << _DRAWN_BITS)
    unit = Fraction(1)
    while True:
        candidate = (place // unit + 1) * unit
        if place < candidate < place + 2 * step:
            return candidate
        unit /= 10
