"""Censuses: their transitions against all events, one slice in each interval, and their full certificate.

The events are found anew (events.py). Where they are all, the number of cusps is constant between them
(mathematics.md#completeness-of-the-events), and one slice proves it; where they may not be all, it is open.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cache, cached_property, partial
from itertools import pairwise
from secrets import randbelow

from rpr_solver.contract import Progress
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, finding, judged, matching, worked
from rpr_solver.verify.core.intervals import Interval, degrees
from rpr_solver.verify.core.numbers import Printed, exact
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.schema import SYSTEMS, Document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Slice
from rpr_solver.verify.events import Crossings, Event, Events, bits_of, event_finding, event_numbers
from rpr_solver.verify.tables import Form, form_claims

_DRAWN_BITS, _SPREAD, _DRAWS = 64, 1 << 20, 3
_AT = "/certificate/full"
_WIDEST = Fraction(1, 1000)


def in_interval(number: int) -> str:
    """What an interval claims."""
    return f"{number} cusps in every slice of this interval"


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

    def counted(self, n: int, number: int, count: Count) -> Finding:
        """Whether all slices of an interval have so many cusps: by a slice in each part of it."""
        gaps, doubt = self.gaps(n), [*self.open]
        if not gaps:
            raise OpenError("nothing is left between events at its ends")
        for gap in gaps:
            length, found = self.slice_in(gap, count)
            if found is None:
                raise OpenError("the cusps of a slice in it are not counted")
            if found[0] != number:
                return ClaimStatus.REFUSED, f"the slice at {length} has {found[0]}"
            if not found[1]:
                doubt.append("the number of cusps of a slice in it is not proved")
        if doubt:
            return ClaimStatus.CHECKED, f"a slice at random has as many; left open: {'; '.join(doubt)}"
        return ClaimStatus.PROVED, f"{COMPLETE}; a slice between them has as many"

    def slice_in(self, gap: Span, count: Count = Slice.counted) -> tuple[Fraction, tuple[int, bool] | None]:
        """A length at random, and the number of cusps of its slice; other lengths if it is not proved."""
        for _ in range(_DRAWS):
            length = drawn_within(gap)
            found = count(Slice(self.events.surface.at(length)))
            if found is not None and found[1]:
                break
        return length, found

    def complete(self) -> Finding:
        """Whether the events are all, and each within the range is at a cut."""
        if self.others:
            length = float(self.spans[self.others[0]][0])
            named = self.others[0] < len(self.events.found)
            reason = f"an event at {length:.12g} is missing" + ("" if named else ", if it changes anything")
            return ClaimStatus.REFUSED if named else ClaimStatus.NOT_CHECKED, reason
        if self.merged:
            return ClaimStatus.REFUSED, "events of different lengths are at one transition"
        return self.rests_on_all()

    def rests_on_all(self) -> Finding:
        """How something stands that holds if the events are all."""
        if self.open:
            return ClaimStatus.CHECKED, f"left open: {'; '.join(self.open)}"
        return ClaimStatus.PROVED, COMPLETE

    def degenerate(self, listed: Sequence[Record]) -> Finding:
        """Whether nothing is degenerate throughout an interval, where all events are isolated."""
        if self.events.open:
            raise OpenError(f"left open: {'; '.join(self.events.open)}")
        return finding(not listed, COMPLETE, "nothing is, as all events are isolated")


def ordered(
    at: str, cuts: Sequence[Printed], start: Fraction, stop: Fraction | None, rows: Sequence[Record]
) -> Iterator[Claim]:
    """Whether cuts ascend within a range, and intervals lie between them and fill it."""
    ends = [start] if stop is None else [start, stop]
    claim = "a range of lengths, and cuts that ascend within it"
    right = stop is None or start < stop
    right = right and all(a.value <= b.value for a, b in pairwise(cuts))
    for x in cuts:
        right = right and start <= x.upper and (stop is None or x.lower <= stop)
    if right and any(x.lower <= end <= x.upper for x in cuts for end in ends):
        reason = "up to half a unit of the last digit beside an end of the range"
        yield Claim(at, claim, ClaimStatus.CHECKED, reason)
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
        self.members, self.fixed = document.members, document.fixed
        self.surface = Surface(document.geometry, document.fixed)
        self.transitions: tuple[Record, ...] = self.members["transitions"]
        self.intervals: tuple[Record, ...] = self.members["intervals"]
        self.lengths: list[Printed] = [row[f"l{self.fixed}"] for row in self.transitions]
        self.span = self.members["range"]["from"], self.members["range"]["to"]

    @cached_property
    def cut(self) -> Range:
        """All events, and the range."""
        rows = [event for row in self.transitions for event in row["events"]]
        numbers = [x for event in rows for x in event_numbers(self.surface, event)]
        return Range(Events(self.surface, bits_of([*self.lengths, *numbers])), self.lengths, *self.span)

    def claims(self, progress: Progress) -> Iterator[Claim]:
        counts = [part["count"] for part in self.intervals]
        around = [(row["count_before"], row["count_after"]) for row in self.transitions]
        right = around == list(pairwise(counts)) and len(counts) == len(around) + 1
        claim = "counts before and after are those of the intervals"
        yield judged("/intervals", claim, right, "as printed", "they contradict each other")
        if not right:
            return
        yield from ordered("/transitions", self.lengths, *self.span, self.intervals)
        for n in range(len(self.transitions)):
            yield from self._transition(n)
        yield worked("/transitions", "these are all transitions", lambda: self.cut.complete())
        for n, number in enumerate(counts):
            progress(n, len(counts))
            yield worked(f"/intervals/{n}/count", in_interval(number), partial(self._counted, n, number))
        listed = self.members.get("degenerate", ())
        yield worked("/degenerate", DEGENERATE, lambda: self.cut.degenerate(listed))
        if (full := self.members["certificate"].get("full")) is not None:
            yield from self._systems(full)
            yield from self._boxes(full["events"])
            yield from self._samples(full["samples"])
        progress(1, 1)

    def _counted(self, n: int, number: int) -> Finding:
        return self.cut.counted(n, number, Slice.counted)

    def _transition(self, n: int) -> Iterator[Claim]:
        at, row = f"/transitions/{n}", self.transitions[n]
        kinds = {event["kind"] for event in row["events"]}
        common = kinds.pop() if len(kinds) == 1 else "several" if kinds else "unclassified"
        if row["kind"] != common:
            yield judged(f"{at}/kind", "the common kind of the events", False, "", f"it is {common}")
        for k, event in enumerate(row["events"]):
            claim = f"a {event['kind']} at this length"
            yield worked(f"{at}/events/{k}", claim, partial(self._event, n, k))
        if not row["events"]:
            yield worked(at, "an event, without its pose", partial(self._unposed, n))

    def _found(self, n: int) -> list[Event]:
        """The events of known kinds at a transition."""
        events = self.cut.events.found
        return [events[k] for k in self.cut.at[n] if k < len(events)]

    def _event(self, n: int, k: int) -> Finding:
        """Whether an event of a transition is one, each another, and the last one if there are no more."""
        rows, length, found = self.transitions[n]["events"], self.lengths[n], self._found(n)
        fits = [
            [
                i
                for i, event in enumerate(found)
                if event.kind == x["kind"] and event.wrong(self.surface, length, x) is None
            ]
            for x in rows
        ]
        chosen = matching(fits)
        own = event_finding(self.surface, length, rows[k], self.cut.events)
        if chosen[k] is None and own[0] is ClaimStatus.PROVED and self.cut.events.named:
            return ClaimStatus.REFUSED, "another is this one"
        left = len(found) - len([i for i in chosen if i is not None])
        if left and k == len(rows) - 1:
            return ClaimStatus.REFUSED, f"{left} more are at this length"
        return own

    def _unposed(self, n: int) -> Finding:
        found = self._found(n)
        if len(found) == 1:
            return ClaimStatus.PROVED, f"it is a {found[0].kind}"
        some = self.cut.at[n] or self.cut.events.open
        return (
            ClaimStatus.NOT_CHECKED if some else ClaimStatus.REFUSED,
            f"{len(found)} are found at this length",
        )

    def _systems(self, full: Record) -> Iterator[Claim]:
        """The eliminants of a full certificate, on which nothing rests."""
        names = [system["name"] for system in full["systems"]]
        for n, system in enumerate(full["systems"]):
            name = system["name"]
            yield from form_claims(
                f"{_AT}/systems/{n}", f"the eliminant of {name}", "it", system, partial(self._form, name)
            )

        if names[:2] != [*SYSTEMS] or len(names) != len(set(names)):
            status = ClaimStatus.REFUSED if names else ClaimStatus.NOT_CHECKED
            reason = "both systems are needed, each once" if names else "the certificate has no eliminants"
            yield Claim(f"{_AT}/systems", "the systems of all events", status, reason)

    def _form(self, name: str) -> Form:
        own = next((x for x in self.cut.events.eliminants if x.name == name), None)
        if own is None or not any(map(any, own.form)):
            raise OpenError("it is 0, as events are not isolated, or of a system that is not repeated here")
        return own.ring, own.form, own.finite_parts

    def _samples(self, samples: Sequence[Fraction]) -> Iterator[Claim]:
        intervals = len(self.intervals)
        if len(samples) != intervals:
            yield judged(f"{_AT}/samples", "a length in each interval", False, "", f"they are {len(samples)}")
            return

        def inside(n: int, sample: Fraction) -> Finding:
            last, gaps = n == intervals - 1 and self.span[1] is None, self.cut.gaps(n)
            right = bool(gaps) and gaps[0][0] < sample and (last or sample < gaps[-1][1])
            return finding(right, "between the events")

        for n, sample in enumerate(samples):
            yield worked(f"{_AT}/samples/{n}", "a length in this interval", partial(inside, n, sample))

    def _boxes(self, boxes: Sequence[Record]) -> Iterator[Claim]:
        sides = [self._sides(box) for box in boxes]

        @cache
        def chosen() -> list[int | None]:
            return matching(
                [
                    [
                        k
                        for k, event in enumerate(self.cut.events.found)
                        if event.kind == box["kind"] and self._holds(side, event, strictly=True)
                    ]
                    for box, side in zip(boxes, sides, strict=True)
                ]
            )

        def one(n: int) -> Finding:
            (length, reach), *angles = sides[n]
            if reach > length * _WIDEST or any(r > _WIDEST or abs(c) > 180 for c, r in angles):
                reason = "its lengths are not all > 0, its angles not within one turn, or it is wide"
                return ClaimStatus.REFUSED, reason
            events = self.cut.events
            if chosen()[n] is None:
                status = ClaimStatus.REFUSED if events.named else ClaimStatus.NOT_CHECKED
                return status, "it holds none that is found anew, or another box holds it too"
            if len([e for e in events.found if self._holds(sides[n], e, strictly=False)]) > 1:
                return ClaimStatus.REFUSED, "it may hold two"
            if events.named:
                return self.cut.rests_on_all()
            return ClaimStatus.CHECKED, f"left open: {'; '.join(events.open)}"

        def all_boxed() -> Finding:
            missing = len(self.cut.events.found) - len([k for k in chosen() if k is not None])
            return finding(not missing, "each is found anew", f"{missing} have none")

        for n, box in enumerate(boxes):
            yield worked(f"{_AT}/events/{n}", f"one {box['kind']} in this box", partial(one, n))
        yield worked(f"{_AT}/events", "each event has its box", all_boxed)

    def _sides(self, box: Record) -> list[tuple[Fraction, Fraction]]:
        names = (f"l{self.fixed}", "alpha_deg", f"theta{self.fixed}_deg")
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
