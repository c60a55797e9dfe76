"""Reports of checks: the verdict, the number of cusps in every interval, the examples."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

from rpr_solver.contract import Progress, check_digits, check_leg
from rpr_solver.errors import InputError
from rpr_solver.verify.censuses import Census
from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.degenerate import degenerate_claims
from rpr_solver.verify.manipulator import Geometry, exact
from rpr_solver.verify.points import Point, Points
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.recounts import Recount
from rpr_solver.verify.system import System
from rpr_solver.verify.within_limits import Limits


def check_claims(geometry: Geometry, document: Mapping[str, Any], progress: Progress) -> Iterator[Claim]:
    """The claims of a report of a check.

    Raises:
        InputError: naming a member that cannot be read.
    """
    report = Report.of(geometry, document)
    yield from report.verdict()
    intervals, violations = report.census.intervals, document["violations"]
    total = len(intervals) + len(violations)
    generic = []
    for n in range(len(intervals)):
        progress(n, total)
        claim, simple = report.counted(n)
        generic.append(simple)
        yield claim
        if n:
            yield report.changed(n)
    for k, violation in enumerate(violations):
        progress(len(intervals) + k, total)
        yield report.example(k, violation)
    entries = document["degenerate"]
    yield from degenerate_claims(geometry, report.census.fixed, entries, intervals, generic)
    reason = "no other length was found by two slices in each interval; the elimination was not repeated"
    yield Claim("/intervals", "the number of cusps changes nowhere else", ClaimStatus.CHECKED, reason)
    progress(total, total)


@dataclass(frozen=True)
class Report:
    """A report as it is printed; its intervals are those of a census without poses."""

    census: Census
    limits: Limits
    document: Mapping[str, Any]

    @classmethod
    def of(cls, geometry: Geometry, document: Mapping[str, Any]) -> Report:
        """Reads a report.

        Raises:
            InputError: naming a member that cannot be read.
        """
        requirement = document["requirement"]
        fixed, digits = check_leg(requirement["fixed_leg"]), check_digits(document["digits"])
        rows = document["intervals"]
        if not isinstance(rows, list) or not rows or not all(isinstance(row, Mapping) for row in rows):
            raise InputError.of("intervals", "is not a list of objects")
        cuts = [Printed.of(row["from"], f"/intervals/{n}/from") for n, row in enumerate(rows) if n]
        span = requirement["range"]
        start, stop = (_bound(span[end], f"requirement/range/{end}") for end in ("from", "to"))
        census = Census(geometry, fixed, digits, [{} for _ in cuts], cuts, rows, start or Fraction(0), stop)
        limits = {
            int(name.removeprefix("l")): (
                _bound(bounds.get("min"), f"requirement/limits/{name}/min"),
                _bound(bounds.get("max"), f"requirement/limits/{name}/max"),
            )
            for name, bounds in (requirement.get("limits") or {}).items()
        }
        if set(limits) - set(geometry.free_legs(fixed)):
            raise InputError.of("requirement.limits", "is of a leg that is not free")
        return cls(census, Limits(limits), document)

    @cached_property
    def _violating(self) -> list[Mapping[str, Any]]:
        most, least = (self.document["requirement"][name] for name in ("max_cusps", "min_cusps"))
        return [
            row
            for row in self.census.intervals
            if (most is not None and row["count"] > most) or (least is not None and row["count"] < least)
        ]

    def verdict(self) -> Iterator[Claim]:
        """That the verdict follows from the intervals, and that these fill the range."""
        document, rows = self.document, self.census.intervals
        counts = [row["count"] for row in rows]
        refused = document["requirement"].get("degenerate") == "refused" and bool(document["degenerate"])
        passed = not self._violating and not refused
        yield _claim("/passed", "the verdict follows from the intervals", document["passed"] is passed)
        for name, number in (("max_cusps_found", max(counts)), ("min_cusps_found", min(counts))):
            yield _claim(f"/{name}", f"{name.replace('_', ' ')} in the intervals", document[name] == number)
        listed = [{name: row[name] for name in ("from", "to", "count")} for row in document["violations"]]
        yield _claim(
            "/violations",
            "these intervals violate the requirement",
            listed == [{name: row[name] for name in ("from", "to", "count")} for row in self._violating],
        )
        ends = [(exact(row["from"], "/intervals"), _bound(row["to"], "/intervals")) for row in rows]
        fits = (ends[0][0], ends[-1][1]) == (self.census.start, self.census.stop)
        fits = fits and all(x[1] == y[0] for x, y in pairwise(ends))
        fits = fits and all(a != b for a, b in pairwise(counts))
        yield _claim("/intervals", "the intervals fill the range, with different neighbours", fits)
        yield self.census.ascending()

    def counted(self, n: int) -> tuple[Claim, bool | None]:
        """The number of cusps within the limits in an interval, by slices; whether roots are simple."""
        at, count = f"/intervals/{n}/count", self.census.intervals[n]["count"]
        claim = f"{count} cusps within the limits in every slice of this interval"
        # within limits a slice takes long, and two more are counted beside the ends
        lengths = self.census.lengths_within(n)[1 if self.limits.bounded else 0 :]
        if not lengths:
            reason = "no number of so many digits lies between its ends"
            return Claim(at, claim, ClaimStatus.NOT_CHECKED, reason), None
        return self._recount.throughout(at, claim, count, lengths)

    def changed(self, n: int) -> Claim:
        """That the number of cusps changes between two intervals, by a slice on either side of the cut."""
        at, claim = f"/intervals/{n}/from", "the number of cusps changes here"
        cut, parts = self.census.lengths[n - 1], (self.census.bounds(n - 1), self.census.bounds(n))
        if not cut.is_zero and cut.digits != self.census.digits:
            return Claim(at, claim, ClaimStatus.REFUSED, "it has more or fewer digits")
        sides = 2 * cut.lower - cut.value, 2 * cut.upper - cut.value
        counts = (self.census.intervals[k]["count"] for k in (n - 1, n))
        return self._recount.beside(at, zip(parts, sides, counts, strict=True))

    def example(self, k: int, violation: Mapping[str, Any]) -> Claim:
        """That an example is a slice of its interval with so many cusps within the limits, and these."""
        at, fixed = f"/violations/{k}/example", self.census.fixed
        claim, example = "a slice of this interval, with its cusps within the limits", violation["example"]
        length = exact(example[f"l{fixed}"], f"{at}/l{fixed}")
        low, high = Fraction(str(violation["from"])), _bound(violation["to"], at)
        if not low < length or (high is not None and not length < high):
            return Claim(at, claim, ClaimStatus.REFUSED, "it is outside the interval")
        listed: Sequence[Mapping[str, Any]] = example["cusps"]
        if len(listed) != violation["count"]:
            return Claim(at, claim, ClaimStatus.REFUSED, f"{len(listed)} cusps are listed")
        system = System.of(self.census.geometry, fixed, length)
        points, boxes = Points(system), []
        for n, row in enumerate(listed):
            point = Point.of(row, system, f"{at}/cusps/{n}")
            box, (status, reason) = points.cusp(point)
            if box is None or status is not ClaimStatus.PROVED:
                return Claim(f"{at}/cusps/{n}", claim, ClaimStatus.REFUSED, reason)
            if self.limits.admit({leg.number: points.length(leg, box) for leg in system.legs}) is not True:
                return Claim(f"{at}/cusps/{n}", claim, ClaimStatus.REFUSED, "it is not within the limits")
            if any(x.digits != self.census.digits for x in point.numbers if not x.is_zero):
                return Claim(f"{at}/cusps/{n}", claim, ClaimStatus.REFUSED, "it has more or fewer digits")
            boxes.append(box)
        if any(x.meets(y) for n, x in enumerate(boxes) for y in boxes[:n]):
            return Claim(at, claim, ClaimStatus.REFUSED, "two listed cusps are one pose")
        reason = "each is proved in a box, with its digits; their number is that of the interval"
        return Claim(at, claim, ClaimStatus.PROVED, reason)

    @property
    def _recount(self) -> Recount:
        count = partial(self.limits.counted, self.census.geometry, self.census.fixed)
        untold = "the cusps of its slices were not told from the limits"
        return Recount(count, "counted exactly", (untold, "the slices beside it were not decided"))


def _bound(text: Any, at: str) -> Fraction | None:
    return None if text is None else exact(text, at)


def _claim(at: str, claim: str, right: bool) -> Claim:
    status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
    return Claim(at, claim, status, "as printed" if right else "they contradict each other")
