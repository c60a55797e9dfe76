"""Reports of checks: a requirement on the number of cusps, decided from all events, which are found anew."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import groupby, pairwise
from types import MappingProxyType

from rpr_solver.contract import MOST_CUSPS, Progress
from rpr_solver.verify.censuses import End, Run, check_ignored, degenerate, ignored_window, is_text_of
from rpr_solver.verify.claims import Claim, Open, claim_by, demand, open_claim, settled
from rpr_solver.verify.equations import Mechanism
from rpr_solver.verify.events import Limit, decided
from rpr_solver.verify.listed import Matching
from rpr_solver.verify.members import RANGE, Document, Leg
from rpr_solver.verify.numbers import NOT_NEGATIVE, POSITIVE, Printed, printed
from rpr_solver.verify.reader import (
    Read,
    Record,
    anything,
    count,
    nothing_or,
    record,
    refusal,
    rows,
    text,
    truth,
    word,
)
from rpr_solver.verify.survey import Survey, admitted
from rpr_solver.verify.tables import Cusps, is_sorted
from rpr_solver.verify.work import Work

_MARGIN = ("verdict", "tolerance", "reason", "validity", "first_order", "counterexample", "certificate")
_MODES = "mode_change"
_WANTED = {"required": "possible", "excluded": "impossible"}
"""What a requirement says of changes of assembly mode, and the answer that satisfies it."""


def requirement_schema(leg: Leg, more: Mapping[str, Read] = MappingProxyType({})) -> Read:
    """The members of a requirement on numbers of cusps, which may have more."""
    limit = record({"min": nothing_or(NOT_NEGATIVE), "max": nothing_or(NOT_NEGATIVE)})
    return record(
        {
            "fixed_leg": count(leg.fixed, leg.fixed),
            "range": RANGE,
            "max_cusps": nothing_or(count()),
            "min_cusps": nothing_or(count()),
            "degenerate": word("allowed", "refused"),
        },
        {
            "limits": nothing_or(record({}, dict.fromkeys(leg.free, limit))),
            "ignore_windows": POSITIVE,
            **more,
        },
    )


def _mode_change() -> Read:
    """The members of what is said of changes of assembly mode."""
    return record(
        {
            "change": word("possible", "impossible", "undecided"),
            "witness": anything,
            "reason": nothing_or(text()),
            "certificate": anything,
        },
        {"best_clearance": POSITIVE, "clearance_bound": POSITIVE},
    )


def check_schema(leg: Leg) -> Read:
    """The members of a report."""
    interval: dict[str, Read] = {"from": text(), "to": nothing_or(text()), "count": count(0, MOST_CUSPS)}
    example = record({leg.length: POSITIVE, "cusps": rows(record(leg.point), 0, MOST_CUSPS)})
    return record(
        {
            **leg.head,
            "requirement": requirement_schema(leg, {_MODES: word(*_WANTED), "clearance": POSITIVE}),
            "passed": truth,
            "max_cusps_found": count(0, MOST_CUSPS),
            "min_cusps_found": count(0, MOST_CUSPS),
            "intervals": rows(record(interval), 1, 2000),
            "violations": rows(record({**interval, "example": example}), 0, 2000),
            "degenerate": leg.degenerate,
        },
        {
            "margin": record({}, dict.fromkeys(_MARGIN, anything)),
            _MODES: _mode_change(),
            "ignored_windows": rows(ignored_window(), 0, 2000),
        },
    )


def check_claims(document: Document, work: Work, progress: Progress) -> Iterator[Claim]:
    """The claims of a report of a check."""
    yield from _Report(document, work).claims(progress)


def limits_of(requirement: Record) -> Iterator[Limit]:
    """The limits of the free legs."""
    for name, ends in (requirement.get("limits") or {}).items():
        low, high = ends["min"], ends["max"]
        if low is not None and high is not None and low >= high:
            raise refusal(f"/requirement/limits/{name}", "holds no length")
        if low:
            yield Limit(int(name[1:]), low, is_upper=False)
        if high is not None:
            yield Limit(int(name[1:]), high, is_upper=True)


def admits(requirement: Record, number: int) -> bool:
    """Whether a number of cusps is within the bounds of a requirement."""
    least, most = requirement["min_cusps"], requirement["max_cusps"]
    return (least is None or number >= least) and (most is None or number <= most)


class _Report:
    def __init__(self, document: Document, work: Work) -> None:
        self.members, self.work = document.members, work
        self.mechanism, self.requirement = (
            Mechanism(document.geometry, document.fixed),
            self.members["requirement"],
        )
        self.rows: Sequence[Record] = self.members["intervals"]
        self.limits, span = tuple(limits_of(self.requirement)), self.requirement["range"]
        self.survey = Survey(self.mechanism, span["from"], span["to"], self.limits, work)
        length = printed(self.members["digits"], 0, zero=False)
        self.cuts: list[Printed] = [
            length(row["from"], f"/intervals/{n}/from") for n, row in enumerate(self.rows) if n
        ]
        self.counts = [row["count"] for row in self.rows]
        self.narrow: Fraction | None = self.requirement.get("ignore_windows")
        if (self.narrow is None) == ("ignored_windows" in self.members):
            raise refusal("/ignored_windows", "goes with ignore_windows, or is missing")
        if (_MODES in self.requirement) != (_MODES in self.members):
            raise refusal(f"/{_MODES}", f"goes with {_MODES} of the requirement, or is missing")
        windows = [(row["from"], row["to"]) for row in self.members.get("ignored_windows", ())]
        self.windows = list(self._runs())
        self.ignored = {
            n
            for places in self.windows
            if (self.rows[places[0]]["from"], self.rows[places[-1]]["to"]) in windows
            for n in places
        }
        self.violating = [n for places in self.windows for n in places if n not in self.ignored]

    def _runs(self) -> Iterator[list[int]]:
        """The longest stretches of intervals that violate the requirement: its windows."""
        for is_admitted, same in groupby(
            range(len(self.rows)), key=lambda n: admits(self.requirement, self.counts[n])
        ):
            if not is_admitted:
                yield list(same)

    def claims(self, progress: Progress) -> Iterator[Claim]:
        """All of them."""
        violations = self.members["violations"]
        progress(0, 2)
        if _MODES not in self.requirement or self._has_bounds:
            yield claim_by("/requirement", "a bound of the number of cusps", self._bounded)
        yield claim_by("/intervals", "the intervals fit together, and the summary fits them", self._fit)
        yield claim_by(
            "/intervals", "the number of cusps changes between all intervals, and nowhere else", self._cut
        )
        for n, row in enumerate(self.rows):
            claim = f"{row['count']} cusps in all slices of this interval"
            yield claim_by(f"/intervals/{n}/count", claim, partial(self._counted, n))
        progress(1, 2)
        for k, violation in enumerate(violations):
            claim = "a slice of this interval, with its cusps within the limits"
            yield claim_by(f"/violations/{k}/example", claim, partial(self._example, k, violation))
        if self.narrow is not None:
            claim = "these windows are ignored, with their widths"
            yield claim_by("/ignored_windows", claim, partial(self._narrower, self.narrow))
        listed = self.members["degenerate"]
        yield claim_by(
            "/degenerate", "what is degenerate in all slices", partial(degenerate, self.survey, listed)
        )
        if _MODES in self.members:
            claim, reason = "whether the assembly mode can change", "not verified; its path may be, alone"
            yield open_claim(f"/{_MODES}", claim, reason)
        claim = "the requirement is met" if self.members["passed"] else "the requirement is not met"
        yield claim_by("/passed", claim, self._passed)
        if "margin" in self.members:
            yield open_claim("/margin", "about all geometries within a tolerance", "it is not verified")
        progress(2, 2)

    @property
    def _has_bounds(self) -> bool:
        return any(self.requirement[name] is not None for name in ("min_cusps", "max_cusps"))

    def _bounded(self) -> str:
        least, most = self.requirement["min_cusps"], self.requirement["max_cusps"]
        demand(self._has_bounds, "it bounds nothing")
        return demand(least is None or most is None or least <= most, "no number is in it", "as printed")

    def _fit(self) -> str:
        rows, span = self.rows, self.requirement["range"]
        ends = [(row["to"], after["from"]) for row, after in pairwise(rows)]
        demand(all(x == y for x, y in ends), "an interval does not begin where the one before ends")
        demand(is_text_of(rows[0]["from"], span["from"]), "the first interval does not begin with the range")
        demand(is_text_of(rows[-1]["to"], span["to"]), "the last interval does not end with the range")
        counts = [number for n, number in enumerate(self.counts) if n not in self.ignored] or self.counts
        demand(self.members["max_cusps_found"] == max(counts), f"at most {max(counts)} are found")
        demand(self.members["min_cusps_found"] == min(counts), f"at least {min(counts)} are found")
        names = ("from", "to", "count")
        violating = [[rows[n][name] for name in names] for n in self.violating]
        listed = [[row[name] for name in names] for row in self.members["violations"]]
        demand(listed == violating, "these are not the intervals that violate the requirement")
        return "as printed"

    @settled
    def _changes(self) -> list[int]:
        """The groups of events at which the number of cusps within the limits changes."""
        return [n for n, (x, y) in enumerate(pairwise(self.survey.counts)) if x != y]

    def _cut(self) -> str:
        groups, fixed = self.survey.groups, self.mechanism.fixed
        demand(len(self._changes) == len(self.cuts), f"it changes {len(self._changes)} times")
        for cut, n in zip(self.cuts, self._changes, strict=True):
            event = groups[n].events[0]
            wrong = f"it does not change at a length printed as {cut.text}"
            demand(decided(lambda bits, x=event, y=cut: y.rounds(x.lengths(bits)[fixed])), wrong)  # type: ignore[misc]
        return "all events are found anew, in boxes that cover all poses and lengths"

    def _narrower(self, least: Fraction) -> str:
        """Why the ignored windows are those that are narrower."""
        self._cut()
        changes = (self.survey.groups[n].events[0] for n in self._changes)
        ends: list[End] = [self.survey.start, *changes, self.survey.stop]
        runs = [
            Run(
                self.rows[places[0]]["from"],
                self.rows[places[-1]]["to"],
                tuple(self.counts[n] for n in places),
                ends[places[0]],
                ends[places[-1] + 1],
            )
            for places in self.windows
        ]
        return check_ignored(runs, least, self.members["ignored_windows"], self.mechanism.fixed)

    @settled
    def _numbers(self) -> list[int]:
        """The number of cusps in each interval between two changes."""
        return [self.survey.counts[0], *(self.survey.counts[n + 1] for n in self._changes)]

    def _counted(self, n: int) -> str:
        self._cut()
        return demand(
            self._numbers[n] == self.counts[n], f"there are {self._numbers[n]}", "by a slice, and the events"
        )

    def _example(self, k: int, violation: Record) -> str:
        """Why an example is a slice of its interval with these cusps within the limits."""
        self._fit()
        self._cut()
        n, example = self.violating[k], violation["example"]
        length: Fraction = example[f"l{self.mechanism.fixed}"]
        groups = [self.survey.groups[i] for i in self._changes]
        low = groups[n - 1].high if n else self.survey.start
        high = groups[n].low if n < len(groups) else self.survey.stop
        if (n and groups[n - 1].low < length <= low) or (
            n < len(groups) and high and high <= length < groups[n].high
        ):
            raise Open("the length is too near to the end of its interval")
        demand(low < length and (high is None or length < high), "it is outside the interval")
        cusps = Cusps(self.mechanism, length, example["cusps"], self.work)
        angles = [cusp[f"theta{self.mechanism.fixed}_deg"].value for cusp in cusps.listed]
        demand(is_sorted(angles), "they are not sorted by angle")
        demand(len(cusps.listed) == violation["count"], f"{len(cusps.listed)} cusps are listed")
        matching: Matching = cusps.matching
        if cusps.found.open or matching.unsure:
            raise Open("not all cusps of the slice are told apart")
        own = {
            place
            for place, zero in enumerate(cusps.found.zeros)
            if decided(lambda bits, x=zero: admitted(cusps.slice, x.within(bits), self.limits))  # type: ignore[misc]
        }
        demand(
            set(matching.places) == own,
            "these are not the cusps within the limits, or their digits are wrong",
        )
        return "they are found anew, in boxes that cover all poses"

    @property
    def _is_mode_wanted(self) -> bool:
        """Whether what is said of changes of assembly mode is what is required."""
        if _MODES not in self.members:
            return True
        return bool(self.members[_MODES]["change"] == _WANTED[self.requirement[_MODES]])

    def _passed(self) -> str:
        refused = self.requirement["degenerate"] == "refused" and bool(self.members["degenerate"])
        margin = self.members.get("margin")
        keeps = not self.violating and not refused
        fits = keeps and (margin is None or margin.get("verdict") == "proved") and self._is_mode_wanted
        demand(self.members["passed"] is fits, "it does not follow from the intervals")
        if _MODES in self.members and keeps:
            raise Open("what is said of changes of assembly mode is not verified")
        if margin is not None and not self.violating:
            raise Open("what is said of other geometries is not verified")
        self._cut()
        if self.narrow is not None:
            self._narrower(self.narrow)
        for n in range(len(self.rows)):
            self._counted(n)
        degenerate(self.survey, self.members["degenerate"])
        return "as the numbers of all intervals show"
