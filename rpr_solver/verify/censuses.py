"""Censuses: every event, digit by digit, and the number of cusps in every interval between."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import pairwise

from rpr_solver.contract import Progress
from rpr_solver.verify.claims import Claim, ClaimStatus, status_of
from rpr_solver.verify.core.manipulator import Geometry
from rpr_solver.verify.core.printed import Printed
from rpr_solver.verify.core.reader import Record, exact
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import System
from rpr_solver.verify.counts import OPEN, Bounds, changed, count_of, sampled
from rpr_solver.verify.events import GENERIC, event_finding
from rpr_solver.verify.full_censuses import AT, Completeness, completeness
from rpr_solver.verify.surface import Surface

_SAMPLES = 2


def census_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of a census."""
    yield from _Census(document).claims(progress)


class Cuts:
    """Lengths that cut a range into intervals; each stands for all numbers that round to it."""

    def __init__(
        self, geometry: Geometry, lengths: list[Printed], start: Fraction, stop: Fraction | None
    ) -> None:
        self.lengths, self.start, self.stop = lengths, start, stop
        self._size = max(geometry.d1, abs(geometry.a2x))

    def ascending(self, at: str) -> Claim:
        """Whether they ascend within the range; neighbours may be printed alike."""
        text = "the lengths are ascending and within the range"
        ends = [self.start] if self.stop is None else [self.start, self.stop]
        outside = any(
            x.upper < self.start or (self.stop is not None and self.stop < x.lower) for x in self.lengths
        )
        if outside or any(a.value > b.value for a, b in pairwise(self.lengths)):
            return Claim(at, text, ClaimStatus.REFUSED, "they contradict each other")
        if any(x.lower <= end <= x.upper for x in self.lengths for end in ends):
            reason = "up to half a unit of the last digit beside an end of the range"
            return Claim(at, text, ClaimStatus.CHECKED, reason)
        if any(b.lower <= a.upper for a, b in pairwise(self.lengths)):
            reason = "up to half a unit of the last digit where two are printed alike"
            return Claim(at, text, ClaimStatus.CHECKED, reason)
        return Claim(at, text, ClaimStatus.PROVED, "as printed")

    def bounds(self, n: int) -> Bounds | None:
        """The ends of an interval, less what its printed ends may be off; None if nothing is left."""
        low = self.start if n == 0 else max(self.start, self.lengths[n - 1].upper)
        if n < len(self.lengths):
            high = self.lengths[n].lower
        else:
            high = self.stop if self.stop is not None else 2 * low + self._size
        return (low, high) if low < high else None

    def around(self, n: int) -> tuple[Fraction | None, Fraction | None]:
        """Between which numbers slices beside a cut lie in the intervals beside it."""
        low = self.lengths[n - 1].upper if n else self.start
        return low, self.lengths[n + 1].lower if n + 1 < len(self.lengths) else self.stop

    def fit(self, rows: Sequence[Record]) -> bool:
        """Whether printed intervals lie between the cuts, and fill the range."""
        texts = [x.text for x in self.lengths]
        if [row["from"] for row in rows[1:]] != texts or [row["to"] for row in rows[:-1]] != texts:
            return False
        high = rows[-1]["to"]
        last = None if high is None else exact(high, f"/intervals/{len(rows) - 1}/to")
        return (exact(rows[0]["from"], "/intervals/0/from"), last) == (self.start, self.stop)


class _Census:
    def __init__(self, document: Document) -> None:
        self.members, self.geometry, self.fixed = document.members, document.geometry, document.fixed
        self.transitions: tuple[Record, ...] = self.members["transitions"]
        self.intervals: tuple[Record, ...] = self.members["intervals"]
        self.lengths: list[Printed] = [row[f"l{self.fixed}"] for row in self.transitions]
        self.start, self.stop = self.members["range"]["from"], self.members["range"]["to"]
        self.cuts = Cuts(self.geometry, self.lengths, self.start, self.stop)

    def claims(self, progress: Progress) -> Iterator[Claim]:
        fit = list(self._fitting())
        yield from fit
        if any(claim.status is ClaimStatus.REFUSED for claim in fit):
            return
        total = len(self.transitions) + len(self.intervals)
        surface = Surface.of(self.geometry, self.fixed)
        for n in range(len(self.transitions)):
            progress(n, total)
            yield from self._transition(surface, n)
        complete = self._completeness(surface)
        yield from () if complete is None else complete.claims
        for n in range(len(self.intervals)):
            progress(len(self.transitions) + n, total)
            yield self._counted(n, complete)
        if "degenerate" in self.members:
            yield self._degenerate(complete)
        claim = "these are all transitions"
        if complete is None:
            reason = "a census with a full certificate is what proves it"
            yield Claim("/transitions", claim, ClaimStatus.NOT_CHECKED, reason)
        else:
            yield complete.claim("/transitions", claim)
        progress(total, total)

    def _fitting(self) -> Iterator[Claim]:
        """Whether transitions and intervals fit together."""

        def claim(text: str, right: bool) -> Claim:
            reason = "as printed" if right else "they contradict each other"
            return Claim("/intervals", text, status_of(right), reason)

        if self.stop is not None and self.stop <= self.start:
            yield Claim("/range", "a range of lengths", ClaimStatus.REFUSED, "it holds no length")
        yield self.cuts.ascending("/transitions")
        counts = [part["count"] for part in self.intervals]
        around = [(row["count_before"], row["count_after"]) for row in self.transitions]
        right = around == list(pairwise(counts)) and len(counts) == len(around) + 1
        yield claim("counts before and after are those of the intervals", right)
        yield claim("the intervals lie between the transitions", self.cuts.fit(self.intervals))

    def _transition(self, surface: Surface, n: int) -> Iterator[Claim]:
        at, row, length = f"/transitions/{n}", self.transitions[n], self.lengths[n]
        events = row["events"]
        kinds = {event["kind"] for event in events}
        common = kinds.pop() if len(kinds) == 1 else "several" if kinds else "unclassified"
        if row["kind"] != common:
            yield Claim(f"{at}/kind", "the common kind of the events", ClaimStatus.REFUSED, f"it is {common}")
        proved = True
        for k, event in enumerate(events):
            status, reason = event_finding(surface, length, event)
            proved = proved and status is ClaimStatus.PROVED
            yield Claim(f"{at}/events/{k}", f"a {event['kind']} at this length", status, reason)
        before, after = row["count_before"], row["count_after"]
        if not events:
            yield changed(f"{at}", length, self.cuts.around(n), (before, after), self._count)
        elif proved and all(event["kind"] in GENERIC for event in events):
            # at each of them two cusps are born, or two die
            right = abs(after - before) <= 2 * len(events) and (after - before) // 2 % 2 == len(events) % 2
            if not right or (after - before) % 2:
                text = f"the number of cusps changes from {before} to {after}"
                yield Claim(at, text, ClaimStatus.REFUSED, "two are born, or die, at each of its poses")

    def _count(self, length: Fraction) -> tuple[int, bool] | None:
        return count_of(System.of(self.geometry, self.fixed, length))

    def _completeness(self, surface: Surface) -> Completeness | None:
        """What the full certificate says, if there is one."""
        full = self.members["certificate"].get("full")
        if full is None:
            return None
        rows = [(x, row["events"]) for x, row in zip(self.lengths, self.transitions, strict=True)]
        return completeness(surface, full, rows, self.start, self.stop)

    def _counted(self, n: int, complete: Completeness | None) -> Claim:
        """The number of cusps in an interval: with a full certificate by one slice, if nothing is open."""
        number, at = self.intervals[n]["count"], f"/intervals/{n}/count"
        if complete is None or complete.open is None:
            return sampled(at, number, self.cuts.bounds(n), self._count, _SAMPLES)
        samples, spans = self.members["certificate"]["full"]["samples"], complete.spans
        low = spans[n - 1][1] if n else self.start
        high = spans[n][0] if n < len(spans) else self.stop
        if len(samples) != len(self.intervals) or not low < samples[n] or (high and not samples[n] < high):
            reason = "it is not, or there is not one for each interval"
            return Claim(f"{AT}/samples/{n}", "a length in this interval", ClaimStatus.REFUSED, reason)
        found, claim = self._count(samples[n]), f"{number} cusps in every slice of this interval"
        if found is None:
            return Claim(at, claim, ClaimStatus.NOT_CHECKED, "the slice of its sample was not counted")
        if found[0] != number:
            return Claim(at, claim, ClaimStatus.REFUSED, f"the slice at {samples[n]} has {found[0]}")
        if not complete.holds:
            return sampled(at, number, self.cuts.bounds(n), self._count, 1)
        if not found[1]:
            return Claim(at, claim, ClaimStatus.CHECKED, "Q has multiple roots in the slice of its sample")
        return complete.claim(at, claim)

    def _degenerate(self, complete: Completeness | None) -> Claim:
        """That nothing is degenerate throughout an interval, where all events are isolated."""
        at, claim = "/degenerate", "what is degenerate throughout an interval, or along a curve"
        if complete is None or not complete.holds:
            return Claim(at, claim, ClaimStatus.NOT_CHECKED, OPEN)
        if self.members["degenerate"]:
            return Claim(at, claim, ClaimStatus.REFUSED, "nothing is, as all events are isolated")
        return complete.claim(at, claim)
