"""Reports of checks: the verdict, the number of cusps in every interval, the examples."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise

from rpr_solver.contract import Progress
from rpr_solver.verify.censuses import Cuts
from rpr_solver.verify.claims import Claim, ClaimStatus, status_of
from rpr_solver.verify.core.reader import Record, decimal, refusal
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import System
from rpr_solver.verify.counts import OPEN, changed, sampled
from rpr_solver.verify.points import Point, Points
from rpr_solver.verify.slices import sorted_turns
from rpr_solver.verify.within_limits import Limits

_SAMPLES = 2


def check_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of a report of a check."""
    yield from _Report(document).claims(progress)


class _Report:
    """A report as it is printed; its intervals are those of a census without poses."""

    def __init__(self, document: Document) -> None:
        self.members, self.geometry, self.fixed = document.members, document.geometry, document.fixed
        self.requirement: Record = self.members["requirement"]
        self.rows: tuple[Record, ...] = self.members["intervals"]
        span = self.requirement["range"]
        length = decimal(self.members["digits"], 0, zero=False)
        cuts = [length(row["from"], f"/intervals/{n}/from") for n, row in enumerate(self.rows) if n]
        self.cuts = Cuts(self.geometry, cuts, span["from"], span["to"])
        bounds = {
            int(name[1]): (limit.get("min"), limit.get("max"))
            for name, limit in (self.requirement.get("limits") or {}).items()
        }
        for leg, (low, high) in bounds.items():
            if low is not None and high is not None and low >= high:
                raise refusal(f"/requirement/limits/l{leg}", "holds no length")
        self.limits = Limits(bounds)

    def claims(self, progress: Progress) -> Iterator[Claim]:
        fit = list(self._fitting())
        yield from fit
        if any(claim.status is ClaimStatus.REFUSED for claim in fit):
            return
        violations = self.members["violations"]
        total = len(self.rows) + len(violations)
        for n, row in enumerate(self.rows):
            progress(n, total)
            # within limits a slice takes long, and two more are counted beside the ends
            samples = 1 if self.limits.bounded else _SAMPLES
            yield sampled(f"/intervals/{n}/count", row["count"], self.cuts.bounds(n), self._count, samples)
            if n:
                numbers = self.rows[n - 1]["count"], row["count"]
                at, cut = f"/intervals/{n}/from", self.cuts.lengths[n - 1]
                yield changed(at, cut, self.cuts.around(n - 1), numbers, self._count)
        violated = False
        for k, violation in enumerate(violations):
            progress(len(self.rows) + k, total)
            claims = list(self._example(k, violation))
            violated = violated or all(claim.status is ClaimStatus.PROVED for claim in claims)
            yield from claims
        at, claim = "/degenerate", "what is degenerate throughout an interval, or along a curve"
        yield Claim(at, claim, ClaimStatus.NOT_CHECKED, OPEN)
        yield self._passed(violated)
        progress(total, total)

    def _count(self, length: Fraction) -> tuple[int, bool] | None:
        return self.limits.counted(self.geometry, self.fixed, length)

    def _violates(self, number: int) -> bool:
        most, least = (self.requirement[name] for name in ("max_cusps", "min_cusps"))
        return (most is not None and number > most) or (least is not None and number < least)

    def _fitting(self) -> Iterator[Claim]:
        """That the members follow from the intervals, and that these fill the range."""

        def claim(at: str, text: str, right: bool) -> Claim:
            return Claim(at, text, status_of(right), "as printed" if right else "they contradict each other")

        counts = [row["count"] for row in self.rows]
        names = ("from", "to", "count")
        violating = [[row[name] for name in names] for row in self.rows if self._violates(row["count"])]
        listed = [[row[name] for name in names] for row in self.members["violations"]]
        refused = self.requirement["degenerate"] == "refused" and bool(self.members["degenerate"])
        passed = not violating and not refused
        bounded = any(self.requirement[name] is not None for name in ("max_cusps", "min_cusps"))
        yield claim("/requirement", "a bound of the number of cusps", bounded)
        yield claim("/passed", "the verdict follows from the intervals", self.members["passed"] is passed)
        for name, number in (("max_cusps_found", max(counts)), ("min_cusps_found", min(counts))):
            text = f"{name.replace('_', ' ')} in the intervals"
            yield claim(f"/{name}", text, self.members[name] == number)
        yield claim("/violations", "these intervals violate the requirement", listed == violating)
        fits = self.cuts.fit(self.rows) and all(a != b for a, b in pairwise(counts))
        if self.cuts.stop is not None and self.cuts.stop <= self.cuts.start:
            fits = False
        yield claim("/intervals", "the intervals fill the range, with different neighbours", fits)
        yield self.cuts.ascending("/intervals")

    def _passed(self, violated: bool) -> Claim:
        """The verdict: one slice refutes a requirement, all slices of the range meet it."""
        if violated:
            return Claim("/passed", "the requirement is not met", ClaimStatus.PROVED, "as an example shows")
        claim = "the requirement is met" if self.members["passed"] else "the requirement is not met"
        return Claim("/passed", claim, ClaimStatus.CHECKED, f"by some slices in each interval; {OPEN}")

    def _example(self, k: int, violation: Record) -> Iterator[Claim]:
        """The claim that an example is a slice of its interval with this number of cusps within the limits,
        and these cusps."""
        at, example = f"/violations/{k}/example", violation["example"]
        claim, length = (
            "a slice of this interval, with its cusps within the limits",
            example[f"l{self.fixed}"],
        )
        n = next(n for n, row in enumerate(self.rows) if row["from"] == violation["from"])
        bounds, listed = self.cuts.bounds(n), example["cusps"]
        last = n == len(self.rows) - 1 and self.cuts.stop is None
        if bounds is None or not bounds[0] < length or (length >= bounds[1] and not last):
            yield Claim(at, claim, ClaimStatus.REFUSED, "it is outside the interval")
            return
        if len(listed) != violation["count"]:
            yield Claim(at, claim, ClaimStatus.REFUSED, f"{len(listed)} cusps are listed")
            return
        system = System.of(self.geometry, self.fixed, length)
        points, boxes = Points(system), []
        for n, row in enumerate(listed):
            box, (status, reason) = points.cusp(Point.of(row, system))
            if box is None or status is not ClaimStatus.PROVED:
                yield Claim(f"{at}/cusps/{n}", claim, ClaimStatus.REFUSED, reason)
                return
            if self.limits.admit({leg.number: points.length(leg, box) for leg in system.legs}) is not True:
                yield Claim(f"{at}/cusps/{n}", claim, ClaimStatus.REFUSED, "it is not within the limits")
                return
            boxes.append(box)
        thetas = [row[f"theta{self.fixed}_deg"].value for row in listed]
        if any(x.meets(y) for n, x in enumerate(boxes) for y in boxes[:n]) or not sorted_turns(thetas):
            yield Claim(
                at, claim, ClaimStatus.REFUSED, "two listed cusps are one pose, or they are not sorted"
            )
            return
        found = self._count(length)
        if found is not None and found[0] != len(listed):
            yield Claim(at, claim, ClaimStatus.REFUSED, f"the slice has {found[0]}")
            return
        proved = found is not None and found[1]
        reason = "each is proved in a box, with its digits; there are no others"
        if not proved:
            reason = "each is proved in a box, with its digits; that there are no others is not"
        yield Claim(at, claim, ClaimStatus.PROVED if proved else ClaimStatus.CHECKED, reason)
