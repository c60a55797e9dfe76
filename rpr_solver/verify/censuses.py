"""Censuses: all events of a range are found anew, and from them the numbers of cusps and of aspects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import NamedTuple

from flint import arb, fmpq

from rpr_solver.contract import MOST_CUSPS, Progress
from rpr_solver.verify.claims import Claim, Open, claim_by, demand, open_claim, settled
from rpr_solver.verify.equations import Mechanism
from rpr_solver.verify.events import Event, decided
from rpr_solver.verify.listed import Row, agrees
from rpr_solver.verify.members import POSE_KINDS, RANGE, Document, Leg
from rpr_solver.verify.numbers import POSITIVE, Printed, exact, printed
from rpr_solver.verify.reader import (
    Read,
    Record,
    anything,
    count,
    no_claim,
    nothing_or,
    record,
    refusal,
    rows,
    text,
    word,
)
from rpr_solver.verify.survey import Survey
from rpr_solver.verify.work import Work

_OF_SOLVER = ("method", "lengths_examined", "counts_by", "boxes")
"""What a certificate tells of the solver's way to its answer."""
_WIDTH_DIGITS = 6
"""Of windows that are ignored."""
_UNVERIFIED = ("tolerance", "complete", "open")
"""Members of the census of a tolerance."""


def census_schema(leg: Leg) -> Read:
    """The members of a census."""
    more = {"sensitivity": no_claim(anything), "singular": no_claim(anything)}
    transition = record(
        {
            leg.length: leg.positive,
            "kind": word("several", "unclassified", *POSE_KINDS),
            "count_before": count(0, MOST_CUSPS),
            "count_after": count(0, MOST_CUSPS),
            "events": rows(record(leg.degenerate_point, more), 0, 200),
        },
        {"from": anything, "to": anything},
    )
    interval = record(
        {"from": text(), "to": nothing_or(text()), "count": count(0, MOST_CUSPS)},
        {"aspects": nothing_or(count(0, 1000))},
    )
    return record(
        {
            **leg.on_leg,
            "range": RANGE,
            "transitions": rows(transition, 0, 1000),
            "intervals": rows(interval, 1, 1001),
            "certificate": no_claim(record({}, dict.fromkeys(_OF_SOLVER, anything))),
        },
        {
            "degenerate": leg.degenerate,
            **dict.fromkeys(_UNVERIFIED, anything),
            "ignore_windows": POSITIVE,
            "ignored_windows": rows(ignored_window(), 0, 1001),
        },
    )


def census_claims(document: Document, work: Work, progress: Progress) -> Iterator[Claim]:
    """The claims of a census."""
    yield from Census(document, work).claims(progress)


def is_text_of(text: str | None, end: Fraction | None) -> bool:
    """Whether an end of an interval is that of the range."""
    return (text is None) == (end is None) and (text is None or exact(text, "") == end)


class Census:
    """A census as it is printed, and what is found of its range."""

    def __init__(self, document: Document, work: Work) -> None:
        self.members, self.work = document.members, work
        self.mechanism = Mechanism(document.geometry, document.fixed)
        self.length = f"l{document.fixed}"
        self.transitions: Sequence[Record] = self.members["transitions"]
        self.intervals: Sequence[Record] = self.members["intervals"]
        span = self.members["range"]
        self.survey = Survey(self.mechanism, span["from"], span["to"], (), work)
        self.listed = [(n, event) for n, row in enumerate(self.transitions) for event in row["events"]]

    def claims(self, progress: Progress) -> Iterator[Claim]:
        """All of them; those of its parts only if these fit together."""
        progress(0, 3)
        yield claim_by("/intervals", "counts and ends of the intervals fit the transitions", self._fit)
        yield claim_by("/transitions", "these are all transitions", self._complete)
        for n, row in enumerate(self.transitions):
            yield claim_by(
                f"/transitions/{n}/{self.length}", "the length of a transition", partial(self._placed, n)
            )
            yield claim_by(f"/transitions/{n}/kind", "the common kind of the events", partial(self._kind, n))
            for k, event in enumerate(row["events"]):
                claim = f"a {event['kind']} with these digits"
                yield claim_by(f"/transitions/{n}/events/{k}", claim, partial(self._event, n, k))
        progress(1, 3)
        for n, row in enumerate(self.intervals):
            claim = f"{row['count']} cusps in all slices of this interval"
            yield claim_by(f"/intervals/{n}/count", claim, partial(self._counted, n))
        progress(2, 3)
        for n, row in enumerate(self.intervals):
            if row.get("aspects") is not None:
                claim = f"{row['aspects']} aspects in all slices of this interval"
                yield claim_by(f"/intervals/{n}/aspects", claim, partial(self._aspects, n))
        claim = "what is degenerate in all slices"
        yield claim_by(
            "/degenerate", claim, partial(degenerate, self.survey, self.members.get("degenerate", ()))
        )
        if ("ignore_windows" in self.members) != ("ignored_windows" in self.members):
            raise refusal("/ignored_windows", "goes with ignore_windows, or is missing")
        if "ignore_windows" in self.members:
            yield claim_by("/ignored_windows", "these windows are ignored, with their widths", self._ignored)
        for name in _UNVERIFIED:
            if name in self.members:
                yield open_claim(f"/{name}", "about all geometries within a tolerance", "it is not verified")
        progress(3, 3)

    def _fit(self) -> str:
        rows, span = self.intervals, self.members["range"]
        cuts = [row[self.length].text for row in self.transitions]
        demand([row["from"] for row in rows[1:]] == cuts, "the intervals do not begin at the transitions")
        demand([row["to"] for row in rows[:-1]] == cuts, "the intervals do not end at the transitions")
        demand(is_text_of(rows[0]["from"], span["from"]), "the first interval does not begin with the range")
        demand(is_text_of(rows[-1]["to"], span["to"]), "the last interval does not end with the range")
        around = [(row["count_before"], row["count_after"]) for row in self.transitions]
        counts = [row["count"] for row in rows]
        wrong = "counts before and after transitions are not those of the intervals"
        demand(around == list(pairwise(counts)), wrong)
        return "as printed"

    @settled
    def _events(self) -> Sequence[tuple[int, Event]]:
        """All events with the numbers of their groups."""
        return [(n, event) for n, group in enumerate(self.survey.groups) for event in group.events]

    @settled
    def _places(self) -> Sequence[int | None]:
        """For each listed event the place of a found one, each another."""
        places: list[int | None] = []
        for n, row in self.listed:
            numbers = {name: x for name, x in row.items() if isinstance(x, Printed)}
            own = Row({**numbers, self.length: self.transitions[n][self.length]})
            places.append(self._place(own, row["kind"], places))
        return places

    def _place(self, row: Row, kind: str, taken: Sequence[int | None]) -> int | None:
        for k, (_, event) in enumerate(self._events):
            if k in taken or event.kind != kind:
                continue
            same = agrees(event.zero, row, event.numbers, self.work)
            if same is None:
                raise Open("it is open whether an event has these digits")
            if same:
                return k
        return None

    def _complete(self) -> str:
        found = len(self._events)
        demand(
            found == len(self.listed), f"{len(self.listed)} events are listed, and {found} are in the range"
        )
        groups = [group for group, _ in self._events]
        own = [(n, groups[k]) for (n, _), k in zip(self.listed, self._places, strict=True) if k is not None]
        demand(len(own) == found, "not every listed event is another one of the range")
        demand(
            all(n == group for n, group in own), "not all events of one length are one transition, in order"
        )
        return "all events are found anew, in boxes that cover all poses and lengths"

    def _placed(self, n: int) -> str:
        self._complete()
        if not self.transitions[n]["events"]:
            raise Open("no event is listed")
        return "that of its events, which have one length"

    def _kind(self, n: int) -> str:
        row = self.transitions[n]
        kinds = {event["kind"] for event in row["events"]}
        common = kinds.pop() if len(kinds) == 1 else "several" if kinds else "unclassified"
        return demand(row["kind"] == common, f"it is {common}", "as printed")

    def _event(self, n: int, k: int) -> str:
        place = next(i for i, (m, _) in enumerate(self.listed) if m == n) + k
        demand(self._places[place] is not None, "no event has these digits, or it is listed before")
        return "there is exactly one in a box, and all of its numbers round to the printed ones"

    def _counted(self, n: int) -> str:
        counts = self.survey.counts
        demand(len(counts) == len(self.intervals), f"there are {len(counts)} intervals")
        return demand(
            counts[n] == self.intervals[n]["count"], f"there are {counts[n]}", "by a slice, and the events"
        )

    def _ignored(self) -> str:
        self._complete()
        self._fit()
        groups = self.survey.groups
        demand(len(groups) == len(self.transitions), "there are other transitions")
        ends: list[End] = [self.survey.start, *(group.events[0] for group in groups), self.survey.stop]
        runs = [
            Run(row["from"], row["to"], (row["count"],), low, high)
            for row, low, high in zip(self.intervals, ends, ends[1:], strict=False)
        ]
        least, listed = self.members["ignore_windows"], self.members["ignored_windows"]
        return check_ignored(runs, least, listed, self.mechanism.fixed)

    def _aspects(self, n: int) -> str:
        demand(len(self.survey.gaps) == len(self.intervals), f"there are {len(self.survey.gaps)} intervals")
        found = self.survey.aspects(n)
        return demand(found == self.intervals[n]["aspects"], f"there are {found}", "by one slice")


End = Fraction | Event | None
"""An end of a window: exact, an event, or open."""


class Run(NamedTuple):
    """Neighbouring intervals that are one window: its ends as printed and as found, and its numbers."""

    start: str
    stop: str | None
    counts: tuple[int, ...]
    low: End
    high: End


def ignored_window() -> Read:
    """The members of a window that is ignored."""
    width = printed(_WIDTH_DIGITS, 0, zero=False)
    counts = rows(count(0, MOST_CUSPS), 1, 2000)
    return record({"from": text(), "to": text(), "width": width, "counts": counts})


def check_ignored(runs: Sequence[Run], least: Fraction, listed: Sequence[Record], fixed: int) -> str:
    """Why the windows of a list are those that are narrower than a width.

    Raises:
        Refused: they are not.
        Open: it is not decided.
    """
    narrow = [run for run in runs if run.high is not None and is_narrower(run, least, fixed)]
    own = [(run.start, run.stop, run.counts) for run in narrow]
    given = [(row["from"], row["to"], tuple(row["counts"])) for row in listed]
    demand(given == own, f"{len(own)} windows are narrower, and these are not they")
    for run, row in zip(narrow, listed, strict=True):
        same = decided(lambda bits, x=run, y=row["width"]: y.rounds(width_of(x, fixed, bits)))  # type: ignore[misc]
        demand(same, f"the window from {run.start} has another width")
    return "by their ends, which are found anew"


def is_narrower(run: Run, least: Fraction, fixed: int) -> bool:
    """Whether a window is narrower than a width.

    Raises:
        Open: it is as wide, or nearly so.
    """

    def compared(bits: int) -> bool | None:
        excess = width_of(run, fixed, bits) - arb(fmpq(least.numerator, least.denominator))
        return True if excess < 0 else False if excess > 0 else None

    if isinstance(run.low, Fraction) and isinstance(run.high, Fraction):
        return run.high - run.low < least
    return bool(decided(compared))


def width_of(run: Run, fixed: int, bits: int) -> arb:
    """The width of a window that has an upper end; the working precision is that of the caller."""

    def ball(end: End) -> arb:
        assert end is not None
        if isinstance(end, Fraction):
            return arb(fmpq(end.numerator, end.denominator))
        return end.lengths(bits)[fixed]

    return ball(run.high) - ball(run.low)


def degenerate(survey: Survey, listed: Sequence[Record]) -> str:
    """Why a list of what is degenerate in all slices of a range is right.

    Raises:
        Refused: it is not.
        Open: it is not decided.
    """
    if survey.mechanism.geometry.is_similar_pair:
        raise Open("degenerate poses of similar triangles are not verified")
    survey.counts  # noqa: B018 - all poses with J = E = 0 of a slice are cusps, and events are isolated
    return demand(
        not listed, "all poses with J = E = 0 are cusps but for those of the events", "there is nothing"
    )
