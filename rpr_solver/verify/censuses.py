"""Censuses and reports of checks: transitions, counts and examples against all events, found anew."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache, cached_property, partial
from itertools import pairwise

from rpr_solver.contract import Progress
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, finding, judged, matching, worked
from rpr_solver.verify.core.intervals import degrees
from rpr_solver.verify.core.numbers import HALF_WAY, Printed, bits_of, decimal
from rpr_solver.verify.core.reader import Record, Unread, refusal
from rpr_solver.verify.core.schema import SYSTEMS, Document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Point
from rpr_solver.verify.events import Crossings, Events, event_finding
from rpr_solver.verify.landmarks import Event
from rpr_solver.verify.ranges import (
    DEGENERATE,
    Range,
    Requirement,
    bits_in,
    drawn_within,
    in_interval,
    ordered,
)
from rpr_solver.verify.tables import Form, form_claims, sorted_turns
from rpr_solver.verify.topology import Topology

_AT = "/certificate/full"
_WIDEST = Fraction(1, 1000)


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
        numbers = [x for event in rows for x in Point.of(event, self.surface).numbers]
        bits = max(bits_of([*self.lengths, *numbers]), bits_in(self.span, self.members.get("degenerate", ())))
        return Range(Events(self.surface, bits), self.lengths, *self.span)

    def claims(self, progress: Progress) -> Iterator[Claim]:
        counts = [part["count"] for part in self.intervals]
        around = [(row["count_before"], row["count_after"]) for row in self.transitions]
        right = around == list(pairwise(counts)) and len(counts) == len(around) + 1
        claim = "counts before and after are those of the intervals"
        yield judged("/intervals", claim, right, "as printed", "they contradict each other")
        if not right:
            return
        yield from ordered(
            "/transitions", self.lengths, self.span, self.intervals, lambda n: self.cut.holds(n)
        )
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
        for n, row in enumerate(self.intervals):
            if (number := row.get("aspects")) is not None:
                claim = f"{number} aspects in every slice of this interval"
                yield worked(f"/intervals/{n}/aspects", claim, partial(_aspects, self, n, number))
        progress(1, 1)

    def _counted(self, n: int, number: int) -> Finding:
        return self.cut.counted(n, number)

    def _transition(self, n: int) -> Iterator[Claim]:
        at, row = f"/transitions/{n}", self.transitions[n]
        kinds = {event["kind"] for event in row["events"]}
        common = kinds.pop() if len(kinds) == 1 else "several" if kinds else "unclassified"
        if row["kind"] != common:
            yield judged(f"{at}/kind", "the common kind of the events", False, "", f"it is {common}")
        chosen = cache(lambda: self._matched(n))
        for k, event in enumerate(row["events"]):
            claim = f"a {event['kind']} at this length"
            yield worked(f"{at}/events/{k}", claim, partial(self._event, n, k, chosen))
        if not row["events"]:
            yield worked(at, "an event, without its pose", partial(self._unposed, n))

    def _found(self, n: int) -> list[Event]:
        """The events of known kinds at a transition."""
        events = self.cut.events.found
        return [events[k] for k in self.cut.at[n] if k < len(events)]

    def _matched(self, n: int) -> list[int | None]:
        """Another event at a transition for each that is listed; None for those for which none is left."""
        rows, length = self.transitions[n]["events"], self.lengths[n]
        return matching(rows, self._found(n), lambda row, event: event.is_printed(self.surface, length, row))

    def _event(self, n: int, k: int, matched: Callable[[], Sequence[int | None]]) -> Finding:
        """Whether an event of a transition is one, each another, and the last one if there are no more."""
        rows, length, found = self.transitions[n]["events"], self.lengths[n], self._found(n)
        chosen = matched()
        own = event_finding(self.surface, length, rows[k], self.cut.events)
        if chosen[k] is None and own[0] is ClaimStatus.PROVED:
            if self.cut.events.named:
                return ClaimStatus.REFUSED, "another is this one"
            if any(_alike(row, rows[k]) for row in rows[:k]):
                return ClaimStatus.NOT_CHECKED, "it is printed like another, and may be this one"
        left = len(found) - len([i for i in chosen if i is not None])
        if left and k == len(rows) - 1:
            return ClaimStatus.REFUSED, f"{left} more are at this length"
        if len(self.cut.at[n]) > len(found) and own[0] is ClaimStatus.PROVED and k == len(rows) - 1:
            return ClaimStatus.NOT_CHECKED, "another may be at this length, whose kind is not found"
        return own

    def _unposed(self, n: int) -> Finding:
        found = self._found(n)
        if len(found) == 1:
            return ClaimStatus.PROVED, f"it is a {found[0].kind}"
        some = self.cut.at[n] or self.cut.events.open
        status = ClaimStatus.NOT_CHECKED if some else ClaimStatus.REFUSED
        return status, f"{len(found)} are found at this length"

    def _systems(self, full: Record) -> Iterator[Claim]:
        """The eliminants of a full certificate, on which nothing rests."""
        names = [system["name"] for system in full["systems"]]
        for n, system in enumerate(full["systems"]):
            name = system["name"]
            yield from form_claims(
                f"{_AT}/systems/{n}", f"the eliminant of {name}", "it", system, partial(self._form, name)
            )
        claim = "the systems of all events"
        if not names:
            yield worked(f"{_AT}/systems", claim, self._no_systems)
        elif names[:2] != [*SYSTEMS] or len(names) != len(set(names)):
            yield judged(f"{_AT}/systems", claim, False, "", "both systems are needed, each once")

    def _no_systems(self) -> Finding:
        if self.cut.events.shape is None:
            raise OpenError("the certificate has no eliminants")
        return ClaimStatus.PROVED, "events of this shape are not isolated"

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
        names = (f"l{self.fixed}", "alpha_deg", f"theta{self.fixed}_deg")
        rows = [
            {name: Printed("box", box[name]["centre"], box[name]["radius"]) for name in names}
            for box in boxes
        ]

        @cache
        def held() -> list[list[bool | None]]:
            """By boxes and events whether a box holds an event; None if it only may."""
            return [[self._holds(row, event) for event in self.cut.events.found] for row in rows]

        @cache
        def chosen() -> list[int | None]:
            events = self.cut.events.found

            def is_in(n: int, k: int) -> bool:
                return events[k].kind == boxes[n]["kind"] and held()[n][k] is True

            return matching(range(len(boxes)), range(len(events)), is_in)

        def one(n: int) -> Finding:
            length, *angles = rows[n].values()
            if length.half > length.value * _WIDEST or any(
                x.half > _WIDEST or abs(x.value) > 180 for x in angles
            ):
                reason = "its lengths are not all > 0, its angles not within one turn, or it is wide"
                return ClaimStatus.REFUSED, reason
            events = self.cut.events
            if chosen()[n] is None:
                status = ClaimStatus.REFUSED if events.named else ClaimStatus.NOT_CHECKED
                return status, "it holds none that is found anew, or another box holds it too"
            if len(events.found) - held()[n].count(False) > 1:
                return ClaimStatus.REFUSED, "it may hold two"
            if events.named:
                return self.cut.rests_on_all()
            return ClaimStatus.CHECKED, "there may be events that are not found anew"

        def all_boxed() -> Finding:
            # of special shapes only the events of the range are listed
            events, boxed = self.cut.events, set(chosen())
            needed = [k for k in range(len(events.found)) if not (events.shape and self.cut.is_beyond(k))]
            missing = len([k for k in needed if k not in boxed])
            if not missing and not events.named:
                return ClaimStatus.CHECKED, "there may be events that are not found anew"
            return finding(not missing, "each is found anew", f"{missing} have none")

        for n, box in enumerate(boxes):
            yield worked(f"{_AT}/events/{n}", f"one {box['kind']} in this box", partial(one, n))
        yield worked(f"{_AT}/events", "each event has its box", all_boxed)

    def _holds(self, row: Mapping[str, Printed], event: Event) -> bool | None:
        """Whether a box holds an event; None if it only may."""
        values = [event.length(self.surface), *(degrees(x) for x in event.pose)]
        sides = [row[name].rounds(x, turn) for name, x, turn in zip(row, values, (0, 360, 360), strict=True)]
        return False if False in sides else None if None in sides else True


def _aspects(census: _Census, n: int, number: int) -> Finding:
    """Whether all slices of an interval have so many aspects: by one between each two events
    (mathematics.md#numbers-of-aspects)."""
    gaps = census.cut.gaps(n)
    if census.cut.open or census.cut.events.shape or not gaps:
        raise OpenError("it is not proved that J = 0 is smooth in all slices between events")
    for gap in gaps:
        found = len(set(Topology.of(census.surface.at(drawn_within(gap))).aspects().values()))
        if found != number:
            return ClaimStatus.REFUSED, f"a slice at random has {found}"
    return ClaimStatus.PROVED, "J = 0 is smooth between events; a slice between each two has as many"


def _alike(first: Record, second: Record) -> bool:
    """Whether two events are of one kind, with the same numbers."""
    return [x for x in first.values() if not isinstance(x, Unread)] == [
        x for x in second.values() if not isinstance(x, Unread)
    ]


def check_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of a report of a check."""
    yield from _Report(document).claims(progress)


class _Report:
    def __init__(self, document: Document) -> None:
        self.members, self.fixed = document.members, document.fixed
        self.requirement = Requirement.of(self.members["requirement"])
        self.rows: tuple[Record, ...] = self.members["intervals"]
        length = decimal(self.members["digits"], 0, zero=False)
        cuts = [length(row["from"], f"/intervals/{n}/from") for n, row in enumerate(self.rows) if n]
        for leg, (low, high) in self.requirement.limits.of_legs.items():
            if low is not None and high is not None and low >= high:
                raise refusal(f"/requirement/limits/l{leg}", "holds no length")
        margin = self.members.get("margin")
        self.proved_within = None if margin is None else margin["verdict"] == "proved"
        """What the report says of a tolerance, which is not verified; None if it says nothing."""
        self.cuts, self.geometry = cuts, document.geometry
        self.span = self.requirement.start, self.requirement.stop
        counts = [row["count"] for row in self.rows]
        self.violating = [n for n, count in enumerate(counts) if not self.requirement.admits(count)]

    @cached_property
    def surface(self) -> Surface:
        """The equations."""
        return Surface(self.geometry, self.fixed)

    @cached_property
    def range(self) -> Range:
        """All events, with the crossings of the limits, and the range."""
        bits = max(bits_of(self.cuts), bits_in(self.span, self.members["degenerate"]))
        events = Events(self.surface, bits)
        return Range(events, self.cuts, *self.span, Crossings(events, self.requirement.limits.each, bits))

    def claims(self, progress: Progress) -> Iterator[Claim]:
        fit = [
            *self._fitting(),
            *ordered("/intervals", self.cuts, self.span, self.rows, lambda n: self.range.holds(n)),
        ]
        yield from fit
        if any(claim.status is ClaimStatus.REFUSED for claim in fit):
            return
        violations = self.members["violations"]
        total = len(self.rows) + len(violations)
        counted = []
        for n, row in enumerate(self.rows):
            progress(n, total)
            find = partial(self._counted, n, row["count"])
            counted.append(worked(f"/intervals/{n}/count", in_interval(row["count"]), find))
        yield from counted
        for n in range(len(self.cuts)):
            claim = "the number of cusps changes here"
            yield worked(f"/intervals/{n + 1}/from", claim, partial(self._changes, n))
        violated = False
        for k, (n, violation) in enumerate(zip(self.violating, violations, strict=True)):
            progress(len(self.rows) + k, total)
            claim = "a slice of this interval, with its cusps within the limits"
            example = worked(f"/violations/{k}/example", claim, partial(self._example, n, violation))
            violated = violated or example.status is ClaimStatus.PROVED
            yield example
        listed = self.members["degenerate"]
        degenerate = worked("/degenerate", DEGENERATE, lambda: self.range.degenerate(listed))
        yield degenerate
        claim = "the requirement is met" if self.members["passed"] else "the requirement is not met"
        yield Claim("/passed", claim, *self._passed(violated, (*counted, degenerate)))
        progress(total, total)

    def _counted(self, n: int, number: int) -> Finding:
        return self.range.counted(n, number, self.requirement.limits)

    def _changes(self, n: int) -> Finding:
        group = self.range.at[n]
        if self.range.open and (not group or n in self.range.twice):
            return self.range.rests_on_all()
        if n in self.range.twice:
            return ClaimStatus.REFUSED, "its event is that of the cut before"
        return finding(bool(group), "an event is found there", "there is no event, and no cusp at a limit")

    def _passed(self, violated: bool, parts: Sequence[Claim]) -> Finding:
        """How the verdict stands, by the claims of the intervals."""
        if violated:
            return ClaimStatus.PROVED, "as an example shows"
        if self.proved_within is not None:
            return ClaimStatus.NOT_CHECKED, "what is said of other geometries is not verified"
        if all(part.established for part in parts):
            return ClaimStatus.PROVED, "as the numbers of all intervals show"
        if any(part.status is ClaimStatus.NOT_CHECKED for part in parts):
            return ClaimStatus.NOT_CHECKED, "it rests on what is open"
        return ClaimStatus.CHECKED, "by some slices in each interval"

    def _fitting(self) -> Iterator[Claim]:
        """That the members follow from the intervals."""

        def claim(at: str, text: str, right: bool) -> Claim:
            return judged(at, text, right, "as printed", "they contradict each other")

        counts = [row["count"] for row in self.rows]
        names = ("from", "to", "count")
        violating = [[self.rows[n][name] for name in names] for n in self.violating]
        listed = [[row[name] for name in names] for row in self.members["violations"]]
        refused = self.members["requirement"]["degenerate"] == "refused" and bool(self.members["degenerate"])
        passed = not violating and not refused and self.proved_within in (None, True)
        yield claim("/requirement", "a bound of the number of cusps", self.requirement.is_bounded)
        yield claim("/passed", "the verdict follows from the intervals", self.members["passed"] is passed)
        for name, number in (("max_cusps_found", max(counts)), ("min_cusps_found", min(counts))):
            text = f"{name.replace('_', ' ')} in the intervals"
            yield claim(f"/{name}", text, self.members[name] == number)
        yield claim("/violations", "these intervals violate the requirement", listed == violating)
        different = all(a != b for a, b in pairwise(counts))
        yield claim("/intervals", "neighbouring intervals have different numbers", different)

    def _example(self, n: int, violation: Record) -> Finding:
        """Whether an example is a slice of an interval with these cusps within the limits."""
        example = violation["example"]
        length, listed = example[f"l{self.fixed}"], example["cusps"]
        if not (gaps := self.range.gaps(n)):
            raise OpenError("nothing is left between events at its ends")
        last = n == len(self.cuts) and self.span[1] is None
        if not gaps[0][0] < length or (not last and length >= gaps[-1][1]):
            return ClaimStatus.REFUSED, "it is outside the interval"
        if len(listed) != violation["count"]:
            return ClaimStatus.REFUSED, f"{len(listed)} cusps are listed"
        part = self.range.events.slice_of(length)
        points = [Point.of(row, part.system) for row in listed]
        located, cusps = part.located(points)
        wrong = next((found.finding[1] for found in located if found.box is None), None)
        if wrong is not None or not sorted_turns([point.angles[1].value for point in points]):
            return ClaimStatus.REFUSED, wrong or "they are not sorted"
        boxes = [found.box for found in located if found.box is not None]
        if any(self.requirement.limits.admit(part, box) is not True for box in boxes):
            return ClaimStatus.REFUSED, "a cusp is not within the limits"
        within = [self.requirement.limits.admit(part, box) for box in cusps.boxes]
        if within.count(True) > len(boxes):
            return ClaimStatus.REFUSED, f"the slice has {within.count(True)}"
        sure = all(found.finding[0] is ClaimStatus.PROVED for found in located)
        if sure and cusps.complete and None not in within:
            return ClaimStatus.PROVED, "each is proved in a box, with its digits; there are no others"
        reason = "each is proved in a box, with its digits; that there are no others is not"
        return ClaimStatus.CHECKED, reason if sure else HALF_WAY
