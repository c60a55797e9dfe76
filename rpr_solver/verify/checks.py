"""Reports of checks: the verdict, the number of cusps in every interval, the examples."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from rpr_solver.contract import Progress
from rpr_solver.verify.censuses import Range
from rpr_solver.verify.claims import Claim, ClaimStatus, judged
from rpr_solver.verify.core.numbers import decimal
from rpr_solver.verify.core.reader import Record, refusal
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Limits, Point, Slice
from rpr_solver.verify.events import Crossings, Events, bits_of
from rpr_solver.verify.tables import sorted_turns


def check_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of a report of a check."""
    yield from _Report(document).claims(progress)


class _Report:
    def __init__(self, document: Document) -> None:
        self.members, self.fixed = document.members, document.fixed
        self.requirement: Record = self.members["requirement"]
        self.rows: tuple[Record, ...] = self.members["intervals"]
        length = decimal(self.members["digits"], 0, zero=False)
        cuts = [length(row["from"], f"/intervals/{n}/from") for n, row in enumerate(self.rows) if n]
        bounds = {
            int(name[1]): (limit.get("min"), limit.get("max"))
            for name, limit in (self.requirement.get("limits") or {}).items()
        }
        for leg, (low, high) in bounds.items():
            if low is not None and high is not None and low >= high:
                raise refusal(f"/requirement/limits/l{leg}", "holds no length")
        self.limits = Limits(bounds)
        margin = self.members.get("margin")
        self.proved_within = None if margin is None else margin["verdict"] == "proved"
        """What the report says of a tolerance, which is not verified; None if it says nothing."""
        span, surface = self.requirement["range"], Surface.of(document.geometry, document.fixed)
        bits = bits_of(cuts)
        events = Events(surface, bits)
        crossings = Crossings(events, self.limits.each, bits)
        self.range = Range(events, cuts, span["from"], span["to"], crossings)

    def claims(self, progress: Progress) -> Iterator[Claim]:
        fit = [*self._fitting(), *self.range.ordered("/intervals", self.rows)]
        yield from fit
        if any(claim.status is ClaimStatus.REFUSED for claim in fit):
            return
        violations = self.members["violations"]
        total = len(self.rows) + len(violations)
        counted = []
        for n, row in enumerate(self.rows):
            progress(n, total)
            counted.append(self.range.counted(n, row["count"], self.limits.counted))
        yield from counted
        for n, group in enumerate(self.range.at):
            claim, at = "the number of cusps changes here", f"/intervals/{n + 1}/from"
            if not group and self.range.open:
                yield self.range.rests_on_all(at, claim)
            else:
                yield judged(
                    at,
                    claim,
                    bool(group),
                    "an event is found there",
                    "there is no event, and no cusp at a limit",
                )
        violated = False
        for k, violation in enumerate(violations):
            progress(len(self.rows) + k, total)
            example = self._example(k, violation)
            violated = violated or example.status is ClaimStatus.PROVED
            yield example
        degenerate = self.range.degenerate(self.members["degenerate"])
        yield degenerate
        claim = "the requirement is met" if self.members["passed"] else "the requirement is not met"
        if violated:
            yield Claim("/passed", claim, ClaimStatus.PROVED, "as an example shows")
        elif self.proved_within is not None:
            reason = "what is said of other geometries is not verified"
            yield Claim("/passed", claim, ClaimStatus.NOT_CHECKED, reason)
        elif all(part.established for part in (*counted, degenerate)):
            yield Claim("/passed", claim, ClaimStatus.PROVED, "as the numbers of all intervals show")
        else:
            yield Claim("/passed", claim, ClaimStatus.CHECKED, "by some slices in each interval")
        progress(total, total)

    def _violates(self, number: int) -> bool:
        most, least = (self.requirement[name] for name in ("max_cusps", "min_cusps"))
        return (most is not None and number > most) or (least is not None and number < least)

    def _fitting(self) -> Iterator[Claim]:
        """That the members follow from the intervals."""

        def claim(at: str, text: str, right: bool) -> Claim:
            return judged(at, text, right, "as printed", "they contradict each other")

        counts = [row["count"] for row in self.rows]
        names = ("from", "to", "count")
        violating = [[row[name] for name in names] for row in self.rows if self._violates(row["count"])]
        listed = [[row[name] for name in names] for row in self.members["violations"]]
        refused = self.requirement["degenerate"] == "refused" and bool(self.members["degenerate"])
        passed = not violating and not refused and self.proved_within in (None, True)
        bounded = any(self.requirement[name] is not None for name in ("max_cusps", "min_cusps"))
        yield claim("/requirement", "a bound of the number of cusps", bounded)
        yield claim("/passed", "the verdict follows from the intervals", self.members["passed"] is passed)
        for name, number in (("max_cusps_found", max(counts)), ("min_cusps_found", min(counts))):
            text = f"{name.replace('_', ' ')} in the intervals"
            yield claim(f"/{name}", text, self.members[name] == number)
        yield claim("/violations", "these intervals violate the requirement", listed == violating)
        different = all(a != b for a, b in pairwise(counts))
        yield claim("/intervals", "neighbouring intervals have different numbers", different)

    def _example(self, k: int, violation: Record) -> Claim:
        """The claim that an example is a slice of its interval with these cusps within the limits."""
        at, example = f"/violations/{k}/example", violation["example"]
        claim, length = (
            "a slice of this interval, with its cusps within the limits",
            example[f"l{self.fixed}"],
        )
        ends = violation["from"], violation["to"]
        n = next(n for n, row in enumerate(self.rows) if (row["from"], row["to"]) == ends)
        cuts, listed = self.range.cuts, example["cusps"]
        low = self.range.start if n == 0 else cuts[n - 1].upper
        high = cuts[n].lower if n < len(cuts) else self.range.stop

        def refused(reason: str) -> Claim:
            return Claim(at, claim, ClaimStatus.REFUSED, reason)

        if not low < length or (high is not None and length >= high):
            return refused("it is outside the interval")
        if len(listed) != violation["count"]:
            return refused(f"{len(listed)} cusps are listed")
        part = Slice(self.range.events.surface.at(length))
        if part.eliminant is None or not (part.eliminant.form or part.eliminant.rest):
            return Claim(at, claim, ClaimStatus.NOT_CHECKED, "the cusps of the slice are not found anew")
        points = [Point.of(row, part.system) for row in listed]
        located, cusps = part.located(points)
        wrong = next((found.finding[1] for found in located if found.box is None), None)
        if wrong is not None or not sorted_turns([point.theta.value for point in points]):
            return refused(wrong or "they are not sorted")
        boxes = [found.box for found in located if found.box is not None]
        if any(self.limits.admit(part, box) is not True for box in boxes):
            return refused("a cusp is not within the limits")
        within = [self.limits.admit(part, box) for box in cusps.boxes]
        if within.count(True) > len(boxes):
            return refused(f"the slice has {within.count(True)}")
        if cusps.complete and None not in within:
            reason = "each is proved in a box, with its digits; there are no others"
            return Claim(at, claim, ClaimStatus.PROVED, reason)
        reason = "each is proved in a box, with its digits; that there are no others is not"
        return Claim(at, claim, ClaimStatus.CHECKED, reason)
