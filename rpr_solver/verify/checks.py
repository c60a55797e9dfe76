"""Reports of checks: the verdict, the number of cusps in every interval, the examples."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property, partial
from itertools import pairwise

from rpr_solver.contract import Progress
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, finding, judged, worked
from rpr_solver.verify.core.numbers import decimal
from rpr_solver.verify.core.reader import Record, refusal
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Limits, Point
from rpr_solver.verify.events import Crossings, Events
from rpr_solver.verify.landmarks import bits_of
from rpr_solver.verify.ranges import DEGENERATE, Range, in_interval, ordered
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
        self.cuts, self.geometry = cuts, document.geometry
        self.span = self.requirement["range"]["from"], self.requirement["range"]["to"]

    @cached_property
    def surface(self) -> Surface:
        """The equations."""
        return Surface(self.geometry, self.fixed)

    @cached_property
    def range(self) -> Range:
        """All events, with the crossings of the limits, and the range."""
        bits = bits_of(self.cuts)
        events = Events(self.surface, bits)
        return Range(events, self.cuts, *self.span, Crossings(events, self.limits.each, bits))

    def claims(self, progress: Progress) -> Iterator[Claim]:
        fit = [*self._fitting(), *ordered("/intervals", self.cuts, *self.span, self.rows)]
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
        for k, violation in enumerate(violations):
            progress(len(self.rows) + k, total)
            claim = "a slice of this interval, with its cusps within the limits"
            example = worked(f"/violations/{k}/example", claim, partial(self._example, violation))
            violated = violated or example.status is ClaimStatus.PROVED
            yield example
        listed = self.members["degenerate"]
        degenerate = worked("/degenerate", DEGENERATE, lambda: self.range.degenerate(listed))
        yield degenerate
        claim = "the requirement is met" if self.members["passed"] else "the requirement is not met"
        yield Claim("/passed", claim, *self._passed(violated, (*counted, degenerate)))
        progress(total, total)

    def _counted(self, n: int, number: int) -> Finding:
        return self.range.counted(n, number, self.limits)

    def _changes(self, n: int) -> Finding:
        group = self.range.at[n]
        if not group and self.range.open:
            return self.range.rests_on_all()
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

    def _example(self, violation: Record) -> Finding:
        """Whether an example is a slice of its interval with these cusps within the limits."""
        example, ends = violation["example"], (violation["from"], violation["to"])
        length, listed = example[f"l{self.fixed}"], example["cusps"]
        n = next(n for n, row in enumerate(self.rows) if (row["from"], row["to"]) == ends)
        low = self.span[0] if n == 0 else self.cuts[n - 1].upper
        high = self.cuts[n].lower if n < len(self.cuts) else self.span[1]
        if not low < length or (high is not None and length >= high):
            return ClaimStatus.REFUSED, "it is outside the interval"
        if len(listed) != violation["count"]:
            return ClaimStatus.REFUSED, f"{len(listed)} cusps are listed"
        part = self.range.events.slice_of(length)
        if part.known != 0 and (part.eliminant is None or not (part.eliminant.form or part.eliminant.rest)):
            raise OpenError("the cusps of the slice are not found anew")
        points = [Point.of(row, part.system) for row in listed]
        located, cusps = part.located(points)
        wrong = next((found.finding[1] for found in located if found.box is None), None)
        if wrong is not None or not sorted_turns([point.theta.value for point in points]):
            return ClaimStatus.REFUSED, wrong or "they are not sorted"
        boxes = [found.box for found in located if found.box is not None]
        if any(self.limits.admit(part, box) is not True for box in boxes):
            return ClaimStatus.REFUSED, "a cusp is not within the limits"
        within = [self.limits.admit(part, box) for box in cusps.boxes]
        if within.count(True) > len(boxes):
            return ClaimStatus.REFUSED, f"the slice has {within.count(True)}"
        if cusps.complete and None not in within:
            return ClaimStatus.PROVED, "each is proved in a box, with its digits; there are no others"
        return (
            ClaimStatus.CHECKED,
            "each is proved in a box, with its digits; that there are no others is not",
        )
