"""Censuses: every event, digit by digit, and the number of cusps in every interval between."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import pairwise
from random import Random
from typing import Any

from rpr_solver.contract import Progress, check_digits, check_leg
from rpr_solver.errors import InputError
from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.completeness import Completeness, completeness
from rpr_solver.verify.counts import cusps_counted, simplest_between
from rpr_solver.verify.degenerate import degenerate_claims
from rpr_solver.verify.events import event_finding
from rpr_solver.verify.full_censuses import AT
from rpr_solver.verify.manipulator import Geometry, exact
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.recounts import Recount, no_room
from rpr_solver.verify.surface import Surface


def census_claims(geometry: Geometry, document: Mapping[str, Any], progress: Progress) -> Iterator[Claim]:
    """The claims of a census.

    Raises:
        InputError: naming a member that cannot be read.
    """
    census = Census.of(geometry, document)
    yield from census.consistent()
    total = len(census.transitions) + len(census.intervals)
    surface = Surface.of(geometry, census.fixed)
    for n, transition in enumerate(census.transitions):
        progress(n, total)
        yield from _transition(surface, census, n, transition)
    complete = _completeness(surface, census, document)
    yield from () if complete is None else complete.claims
    generic: list[bool | None] = []
    for n in range(len(census.intervals)):
        progress(len(census.transitions) + n, total)
        claim, simple = _counted(census, n, document, complete)
        generic.append(simple)
        yield claim
    entries = document.get("degenerate")
    if entries is not None and complete is not None and complete.holds:
        yield complete.degenerate(entries)
    elif entries is not None:
        yield from degenerate_claims(geometry, census.fixed, entries, census.intervals, generic)
    yield census.complete() if complete is None else complete.transitions()
    yield from census.aspects()
    progress(total, total)


def _completeness(surface: Surface, census: Census, document: Mapping[str, Any]) -> Completeness | None:
    """What the full certificate of a census says, if it has one."""
    full = document.get("certificate", {}).get("full")
    if full is None:
        return None
    rows = [(length, row["events"]) for length, row in zip(census.lengths, census.transitions, strict=True)]
    return completeness(surface, full, rows, census.start, census.stop)


def _counted(
    census: Census, n: int, document: Mapping[str, Any], complete: Completeness | None
) -> tuple[Claim, bool | None]:
    """The number of cusps in an interval: with a full certificate by one slice, if nothing is open."""
    lengths = census.lengths_within(n)
    if complete is not None and complete.open is not None:
        at, samples = f"{AT}/samples/{n}", document["certificate"]["full"]["samples"]
        sample = exact(samples[n] if n < len(samples) else None, at)
        spans = complete.spans
        low = spans[n - 1][1] if n else census.start
        high = spans[n][0] if n < len(spans) else census.stop
        if not low < sample or (high is not None and not sample < high):
            return Claim(at, "a length in this interval", ClaimStatus.REFUSED, "it is not"), None
        lengths = (sample,) if complete.holds or not lengths else (sample, lengths[1])
    return census.counted(n, lengths)


@dataclass(frozen=True)
class Census:
    """A census as it is printed."""

    geometry: Geometry
    fixed: int
    digits: int
    transitions: list[Mapping[str, Any]]
    lengths: list[Printed]
    intervals: list[Mapping[str, Any]]
    start: Fraction
    stop: Fraction | None

    @classmethod
    def of(cls, geometry: Geometry, document: Mapping[str, Any]) -> Census:
        """Reads a census.

        Raises:
            InputError: naming a member that cannot be read.
        """
        fixed, digits = check_leg(document.get("fixed_leg", 1)), check_digits(document.get("digits", 15))
        for name in ("transitions", "intervals"):
            rows = document.get(name)
            if not isinstance(rows, list) or not all(isinstance(row, Mapping) for row in rows):
                raise InputError.of(name, "is not a list of objects")
        transitions: list[Mapping[str, Any]] = document["transitions"]
        lengths = [
            Printed.of(row.get(f"l{fixed}"), f"/transitions/{n}/l{fixed}")
            for n, row in enumerate(transitions)
        ]
        span = document["range"]
        start = exact(span["from"], "/range/from")
        stop = None if span["to"] is None else exact(span["to"], "/range/to")
        return cls(geometry, fixed, digits, transitions, lengths, document["intervals"], start, stop)

    def consistent(self) -> Iterator[Claim]:
        """Whether transitions and intervals fit together."""

        def claim(at: str, text: str, right: bool) -> Claim:
            status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
            return Claim(at, text, status, "as printed" if right else "they contradict each other")

        yield self.ascending()
        counts = [part.get("count") for part in self.intervals]
        around = [(row.get("count_before"), row.get("count_after")) for row in self.transitions]
        yield claim(
            "/intervals",
            "counts before and after are those of the intervals",
            around == list(pairwise(counts)) and len(counts) == len(around) + 1,
        )
        texts = [x.text for x in self.lengths]
        ends = [(part.get("from"), part.get("to")) for part in self.intervals]
        inner = list(zip([None, *texts], [*texts, None], strict=True))
        fits = len(ends) == len(inner) and all(
            (n == 0 or end[0] == mine[0]) and (n == len(texts) or end[1] == mine[1])
            for n, (end, mine) in enumerate(zip(ends, inner, strict=False))
        )
        if fits:
            outer = exact(ends[0][0], "/intervals/0/from"), ends[-1][1]
            last = None if outer[1] is None else exact(outer[1], "/intervals")
            fits = (outer[0], last) == (self.start, self.stop)
        yield claim("/intervals", "the intervals lie between the transitions", fits)

    def ascending(self) -> Claim:
        """Whether the transitions ascend within the range; neighbours may be printed alike."""
        at, text = "/transitions", "the transitions are ascending and within the range"
        ends = [self.start] if self.stop is None else [self.start, self.stop]
        outside = any(
            x.upper < self.start or (self.stop is not None and self.stop < x.lower) for x in self.lengths
        )
        if outside or any(a.value > b.value for a, b in pairwise(self.lengths)):
            return Claim(at, text, ClaimStatus.REFUSED, "they contradict each other")
        if any(x.lower <= end <= x.upper for x in self.lengths for end in ends):
            reason = "up to half a unit of the last digit beside an end of the range"
            return Claim(at, text, ClaimStatus.CHECKED, reason)
        return Claim(at, text, ClaimStatus.PROVED, "as printed")

    def bounds(self, n: int) -> tuple[Fraction, Fraction] | None:
        """The ends of an interval, less what its printed ends may be off; None if nothing is left."""
        low = self.start if n == 0 else self.lengths[n - 1].upper
        if n < len(self.lengths):
            high = self.lengths[n].lower
        else:
            high = (
                self.stop
                if self.stop is not None
                else 2 * low + max(self.geometry.d1, abs(self.geometry.a2x))
            )
        return (low, high) if low < high else None

    def lengths_within(self, n: int) -> tuple[Fraction, ...]:
        """Two lengths in an interval: a short one, and one at random; none if there is no room."""
        bounds = self.bounds(n)
        if bounds is None:
            return ()
        low, high = bounds
        middle = low + (high - low) * Fraction(Random(n).randint(1, 999), 1000)
        spread = (high - low) / 1000
        return simplest_between(low, high), simplest_between(middle - spread / 2, middle + spread / 2)

    def counted(self, n: int, lengths: Sequence[Fraction]) -> tuple[Claim, bool | None]:
        """The number of cusps in an interval, by exact counts at some lengths.

        Also whether all roots of the eliminants there are simple; None if nothing is known.
        """
        at, count = f"/intervals/{n}/count", self.intervals[n].get("count")
        claim = f"{count} cusps in every slice of this interval"
        if not lengths:
            reason = "no number of so many digits lies between the transitions"
            return Claim(at, claim, ClaimStatus.NOT_CHECKED, reason), None
        return self.recount.throughout(at, claim, count, lengths)

    @property
    def recount(self) -> Recount:
        """By Descartes' rule of signs."""
        vanishes = "the resultant vanishes identically"
        count = partial(cusps_counted, self.geometry, self.fixed)
        return Recount(count, "by Descartes' rule of signs", (vanishes, vanishes))

    def complete(self) -> Claim:
        """That these are all transitions, without a full certificate."""
        reason = "no other length was found by two slices in each interval; the elimination was not repeated"
        return Claim("/transitions", "these are all transitions", ClaimStatus.CHECKED, reason)

    def aspects(self) -> Iterator[Claim]:
        """What is not verified."""
        if any("aspects" in part for part in self.intervals):
            reason = "aspects are not counted by this verifier"
            yield Claim("/intervals", "the numbers of aspects", ClaimStatus.NOT_CHECKED, reason)


def _transition(surface: Surface, census: Census, n: int, row: Mapping[str, Any]) -> Iterator[Claim]:
    at, printed = f"/transitions/{n}", census.lengths[n]
    events = row.get("events")
    if not isinstance(events, list) or not all(isinstance(event, Mapping) for event in events):
        raise InputError.of(f"{at}/events", "is not a list of events")
    kinds = {event.get("kind") for event in events}
    kind = row.get("kind")
    common = kinds.pop() if len(kinds) == 1 else "several" if kinds else "unclassified"
    if kind != common:
        yield Claim(f"{at}/kind", "the common kind of the events", ClaimStatus.REFUSED, f"it is {common}")
    if not printed.is_zero and printed.digits != census.digits:
        yield Claim(at, "the digits of the length", ClaimStatus.REFUSED, "it has more or fewer digits")
    for k, event in enumerate(events):
        status, reason = event_finding(surface, census.digits, printed, event, f"{at}/events/{k}")
        yield Claim(f"{at}/events/{k}", f"a {event.get('kind')} at this length", status, reason)
    if not events:
        yield _bracketed(census, n, row)


def _bracketed(census: Census, n: int, row: Mapping[str, Any]) -> Claim:
    """A transition without a pose, by the counts on both sides of its last digit."""
    at, length = f"/transitions/{n}", census.lengths[n]
    parts = (census.bounds(n), census.bounds(n + 1))
    if None in parts:
        return no_room(at)
    sides = 2 * length.lower - length.value, 2 * length.upper - length.value
    counts = (row.get(member) for member in ("count_before", "count_after"))
    return census.recount.beside(at, zip(parts, sides, counts, strict=True))
