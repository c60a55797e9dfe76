"""Censuses: their transitions against all events, one slice in each interval, and their full certificate.

The events are found anew (events.py). Where they are all, the number of cusps is constant between them
(mathematics.md#completeness-of-the-events), and one slice proves it; where they may not be all, it is open.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from secrets import randbelow

from rpr_solver.contract import Progress
from rpr_solver.verify.claims import Claim, ClaimStatus, judged, matching
from rpr_solver.verify.core.intervals import Interval, degrees
from rpr_solver.verify.core.numbers import Printed, exact
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Slice
from rpr_solver.verify.events import Crossings, Event, Events, bits_of, event_finding, event_numbers
from rpr_solver.verify.tables import form_of, isolation_claim, proportional, simple_claim

_DRAWN_BITS, _SPREAD, _DRAWS = 64, 1 << 20, 3
_AT = "/certificate/full"
_WIDEST = Fraction(1, 1000)
DEGENERATE = "what is degenerate throughout an interval, or along a curve"
COMPLETE = "all events of this leg are found anew, and each is proved"
Count = Callable[[Slice], tuple[int, bool] | None]
"""The number of cusps of a slice, and whether it is proved; None if it is open."""
Span = tuple[Fraction, Fraction]
"""Two numbers between which a length is."""


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
        self.spans = [(_end(x.lower, x), _end(x.upper, x)) for x in lengths]
        """Of all events."""
        self.at = [[k for k, x in enumerate(lengths) if cut.rounds(x)] for cut in cuts]
        """The events at each cut; where as many cuts are printed alike, each has one."""
        for n, cut in enumerate(cuts):
            alike = [k for k, other in enumerate(cuts) if other.text == cut.text]
            if len(alike) > 1 and len(alike) == len(self.at[n]):
                for k, event in zip(alike, list(self.at[n]), strict=True):
                    self.at[k] = [event]
        self.others = [k for k in self._inside() if not any(k in group for group in self.at)]
        """The events within the range that are at no cut."""
        self.merged = any(self._are_apart(group) for group in self.at)
        """Whether events of different lengths are at one cut: an interval between them is hidden."""
        also = crossings.open if crossings else ()
        self.open = tuple(sorted({*events.open, *also, *self._left_open()}))
        """What is open about the events; empty if these are all."""

    def _inside(self) -> Iterator[int]:
        for k, (low, high) in enumerate(self.spans):
            if self.start < low and (self.stop is None or high < self.stop):
                yield k

    def _are_apart(self, group: Sequence[int]) -> bool:
        spans = sorted(self.spans[k] for k in group)
        return any(a[1] < b[0] for a, b in pairwise(spans))

    def _left_open(self) -> Iterator[str]:
        if self.merged:
            yield "events of different lengths are at one length as printed"
        ends = [self.start] if self.stop is None else [self.start, self.stop]
        if any(low <= end <= high for low, high in self.spans for end in ends):
            yield "an event is at an end of the range"
        inside = sorted(self.spans[k] for k in self._inside())
        if any(b[0] <= a[1] for a, b in pairwise(inside)):
            yield "two events have one length, as far as intervals tell"

    def ordered(self, at: str, rows: Sequence[Record]) -> Iterator[Claim]:
        """Whether the cuts ascend within the range, and intervals lie between them and fill it."""
        ends = [self.start] if self.stop is None else [self.start, self.stop]
        claim = "a range of lengths, and cuts that ascend within it"
        right = self.stop is None or self.start < self.stop
        right = right and all(a.value <= b.value for a, b in pairwise(self.cuts))
        for x in self.cuts:
            right = right and self.start <= x.upper and (self.stop is None or x.lower <= self.stop)
        if right and any(x.lower <= end <= x.upper for x in self.cuts for end in ends):
            reason = "up to half a unit of the last digit beside an end of the range"
            yield Claim(at, claim, ClaimStatus.CHECKED, reason)
        else:
            yield judged(at, claim, right, "as printed", "they contradict each other")
        inner = [x.text for x in self.cuts]
        right = [row["from"] for row in rows[1:]] == inner and [row["to"] for row in rows[:-1]] == inner
        if right:
            outer = rows[0]["from"], rows[-1]["to"]
            first, last = (None if x is None else exact(x, "/intervals") for x in outer)
            right = (first, last) == (self.start, self.stop)
        claim = "the intervals lie between the cuts, and fill the range"
        yield judged("/intervals", claim, right, "as printed", "they contradict each other")

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
            self.spans[k] for k in self.others if low <= self.spans[k][0] and self.spans[k][1] <= high
        )
        edges = [low, *(end for span in inside for end in span), high]
        gaps = list(zip(edges[::2], edges[1::2], strict=True))
        return gaps if all(a < b for a, b in gaps) else []

    def counted(self, n: int, number: int, count: Count) -> Claim:
        """That all slices of an interval have so many cusps: by a slice in each part of it."""
        at, claim = f"/intervals/{n}/count", f"{number} cusps in every slice of this interval"
        gaps, doubt = self.gaps(n), [*self.open]
        if not gaps:
            return Claim(at, claim, ClaimStatus.NOT_CHECKED, "nothing is left between events at its ends")
        for gap in gaps:
            length, found = self.slice_in(gap, count)
            if found is None:
                return Claim(at, claim, ClaimStatus.NOT_CHECKED, "the cusps of a slice in it are not counted")
            if found[0] != number:
                return Claim(at, claim, ClaimStatus.REFUSED, f"the slice at {length} has {found[0]}")
            if not found[1]:
                doubt.append("the number of cusps of a slice in it is not proved")
        if doubt:
            reason = f"a slice at random has as many; left open: {'; '.join(doubt)}"
            return Claim(at, claim, ClaimStatus.CHECKED, reason)
        return Claim(at, claim, ClaimStatus.PROVED, f"{COMPLETE}; a slice between them has as many")

    def slice_in(self, gap: Span, count: Count = Slice.counted) -> tuple[Fraction, tuple[int, bool] | None]:
        """A length at random, and the number of cusps of its slice; other lengths if it is not proved."""
        for _ in range(_DRAWS):
            length = drawn_within(gap)
            found = count(Slice(self.events.surface.at(length)))
            if found is not None and found[1]:
                break
        return length, found

    def complete(self, at: str, claim: str) -> Claim:
        """A claim that holds if the events are all, and each within the range is at a cut."""
        if self.others:
            length = float(self.spans[self.others[0]][0])
            named = self.others[0] < len(self.events.found)
            reason = f"an event at {length:.12g} is missing" + ("" if named else ", if it changes anything")
            return Claim(at, claim, ClaimStatus.REFUSED if named else ClaimStatus.NOT_CHECKED, reason)
        if self.merged:
            reason = "events of different lengths are at one transition"
            return Claim(at, claim, ClaimStatus.REFUSED, reason)
        return self.rests_on_all(at, claim)

    def rests_on_all(self, at: str, claim: str) -> Claim:
        """A claim that holds if the events are all."""
        if self.open:
            return Claim(at, claim, ClaimStatus.CHECKED, f"left open: {'; '.join(self.open)}")
        return Claim(at, claim, ClaimStatus.PROVED, COMPLETE)

    def degenerate(self, listed: Sequence[Record]) -> Claim:
        """That nothing is degenerate throughout an interval, where all events are isolated."""
        if listed and not self.events.open:
            reason = "nothing is, as all events are isolated"
            return Claim("/degenerate", DEGENERATE, ClaimStatus.REFUSED, reason)
        if self.events.open:
            reason = f"left open: {'; '.join(self.events.open)}"
            return Claim("/degenerate", DEGENERATE, ClaimStatus.NOT_CHECKED, reason)
        return Claim("/degenerate", DEGENERATE, ClaimStatus.PROVED, COMPLETE)


def _end(units: int, x: Interval) -> Fraction:
    return Fraction(units, 1 << x.bits)


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


def census_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of a census."""
    yield from _Census(document).claims(progress)


class _Census:
    def __init__(self, document: Document) -> None:
        self.members, fixed = document.members, document.fixed
        self.surface = Surface.of(document.geometry, fixed)
        self.transitions: tuple[Record, ...] = self.members["transitions"]
        self.intervals: tuple[Record, ...] = self.members["intervals"]
        self.lengths: list[Printed] = [row[f"l{fixed}"] for row in self.transitions]

    def claims(self, progress: Progress) -> Iterator[Claim]:
        counts = [part["count"] for part in self.intervals]
        around = [(row["count_before"], row["count_after"]) for row in self.transitions]
        right = around == list(pairwise(counts)) and len(counts) == len(around) + 1
        claim = "counts before and after are those of the intervals"
        yield judged("/intervals", claim, right, "as printed", "they contradict each other")
        if not right:
            return
        numbers = [
            x for row in self.transitions for e in row["events"] for x in event_numbers(self.surface, e)
        ]
        events = Events(self.surface, bits_of([*self.lengths, *numbers]))
        span = self.members["range"]
        cut = Range(events, self.lengths, span["from"], span["to"])
        yield from cut.ordered("/transitions", self.intervals)
        for n in range(len(self.transitions)):
            yield from self._transition(cut, n)
        yield cut.complete("/transitions", "these are all transitions")
        for n, number in enumerate(counts):
            progress(n, len(counts))
            yield cut.counted(n, number, Slice.counted)
        yield cut.degenerate(self.members.get("degenerate", ()))
        if (full := self.members["certificate"].get("full")) is not None:
            yield from _Certificate(cut, full).claims(len(counts))
        progress(1, 1)

    def _transition(self, cut: Range, n: int) -> Iterator[Claim]:
        at, row, length, events = f"/transitions/{n}", self.transitions[n], self.lengths[n], cut.events
        kinds = {event["kind"] for event in row["events"]}
        common = kinds.pop() if len(kinds) == 1 else "several" if kinds else "unclassified"
        if row["kind"] != common:
            yield Claim(f"{at}/kind", "the common kind of the events", ClaimStatus.REFUSED, f"it is {common}")
        found = [events.found[k] for k in cut.at[n] if k < len(events.found)]
        others = len(cut.at[n]) - len(found)
        fits = [
            [
                k
                for k, event in enumerate(found)
                if event.kind == x["kind"] and event.wrong(self.surface, length, x) is None
            ]
            for x in row["events"]
        ]
        chosen = matching(fits)
        for i, (x, k) in enumerate(zip(row["events"], chosen, strict=True)):
            claim = f"a {x['kind']} at this length"
            finding = event_finding(self.surface, length, x, events)
            if k is None and finding[0] is ClaimStatus.PROVED and events.named:
                finding = ClaimStatus.REFUSED, "another is this one"
            yield Claim(f"{at}/events/{i}", claim, *finding)
        left = len(found) - len([k for k in chosen if k is not None])
        if left and row["events"]:
            reason = f"{left} more are at this length"
            yield Claim(f"{at}/events", "these are its events", ClaimStatus.REFUSED, reason)
        elif not row["events"]:
            if len(found) == 1:
                yield Claim(at, "an event, without its pose", ClaimStatus.PROVED, f"it is a {found[0].kind}")
                return
            some = found or others or events.open
            status = ClaimStatus.NOT_CHECKED if some else ClaimStatus.REFUSED
            yield Claim(at, "an event, without its pose", status, f"{len(found)} are found at this length")


class _Certificate:
    """The full certificate of a census: nothing rests on it."""

    def __init__(self, cut: Range, full: Record) -> None:
        self.range, self.events, self.full = cut, cut.events, full
        self.surface = cut.events.surface

    def claims(self, intervals: int) -> Iterator[Claim]:
        yield from self._boxes()
        names = [system["name"] for system in self.full["systems"]]
        for n, system in enumerate(self.full["systems"]):
            yield from self._system(system, f"{_AT}/systems/{n}")
        known = [eliminant.name for eliminant in self.events.eliminants]
        if names[:2] != known or len(names) != len(set(names)):
            status = ClaimStatus.REFUSED if names else ClaimStatus.NOT_CHECKED
            reason = "both systems are needed, each once" if names else "the certificate has no eliminants"
            yield Claim(f"{_AT}/systems", "the systems of all events", status, reason)
        claim, samples = "a length in each interval", self.full["samples"]
        if len(samples) != intervals:
            yield Claim(f"{_AT}/samples", claim, ClaimStatus.REFUSED, f"they are {len(samples)}")
            return
        for n, sample in enumerate(samples):
            last = n == intervals - 1 and self.range.stop is None
            gaps = self.range.gaps(n)
            right = bool(gaps) and gaps[0][0] < sample and (last or sample < gaps[-1][1])
            yield judged(f"{_AT}/samples/{n}", "a length in this interval", right, "between the events")

    def _boxes(self) -> Iterator[Claim]:
        boxes, found, complete = self.full["events"], self.events.found, self.events.named
        sides = [self._sides(box) for box in boxes]
        fits = [
            [k for k, e in enumerate(found) if e.kind == box["kind"] and self._holds(side, e, strictly=True)]
            for box, side in zip(boxes, sides, strict=True)
        ]
        chosen = matching(fits)
        for n, (box, k) in enumerate(zip(boxes, chosen, strict=True)):
            at, claim = f"{_AT}/events/{n}", f"one {box['kind']} in this box"
            (length, reach), *angles = sides[n]
            if reach > length * _WIDEST or any(r > _WIDEST or abs(c) > 180 for c, r in angles):
                reason = "its lengths are not all > 0, its angles not within one turn, or it is wide"
                yield Claim(at, claim, ClaimStatus.REFUSED, reason)
            elif k is None:
                status = ClaimStatus.REFUSED if complete else ClaimStatus.NOT_CHECKED
                yield Claim(
                    at, claim, status, "it holds none that is found anew, or another box holds it too"
                )
            elif len([e for e in found if self._holds(sides[n], e, strictly=False)]) > 1:
                yield Claim(at, claim, ClaimStatus.REFUSED, "it may hold two")
            else:
                yield (
                    self.range.rests_on_all(at, claim)
                    if complete
                    else Claim(at, claim, ClaimStatus.CHECKED, f"left open: {'; '.join(self.events.open)}")
                )
        missing = len(found) - len([k for k in chosen if k is not None])
        yield judged(
            f"{_AT}/events",
            "each event has its box",
            not missing,
            "each is found anew",
            f"{missing} have none",
        )

    def _sides(self, box: Record) -> list[tuple[Fraction, Fraction]]:
        fixed = self.surface.fixed
        names = (f"l{fixed}", "alpha_deg", f"theta{fixed}_deg")
        return [(box[name]["centre"], box[name]["radius"]) for name in names]

    def _holds(self, sides: Sequence[tuple[Fraction, Fraction]], event: Event, *, strictly: bool) -> bool:
        """Whether a box holds an event, or may hold it."""
        values = [event.length(self.surface), *(degrees(x) for x in event.zero[:2])]
        for (centre, radius), x, turn in zip(sides, values, (0, 360, 360), strict=True):
            shift = round((centre - x.middle) / turn) * turn if turn else 0
            low, high = centre - radius - shift, centre + radius - shift
            if not (
                x.inside(low, high) if strictly else x.meets(Interval.of((low + high) / 2, x.bits, radius))
            ):
                return False
        return True

    def _system(self, system: Record, at: str) -> Iterator[Claim]:
        own = next((x for x in self.events.eliminants if x.name == system["name"]), None)
        named = f"the eliminant of {system['name']}"
        if own is None or not any(map(any, own.form)):
            reason = "it is 0, as events are not isolated, or of a system that is not repeated here"
            yield Claim(f"{at}/polynomial", named, ClaimStatus.NOT_CHECKED, reason)
            return
        ring = own.ring
        form = form_of(ring, system["polynomial"])
        right = form is not None and proportional(ring, form, own.form)
        yield judged(f"{at}/polynomial", named, right, "a multiple of the quotient derived here")
        yield simple_claim(ring, system, own.form, "it", at)
        yield isolation_claim(ring, own.finite_parts, system["real_roots"], f"{at}/real_roots")
