"""Cusp curves: each is a branch found anew, with its points, its ends, and the one that joins it there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial

from rpr_solver.contract import MOST_CUSPS, Progress
from rpr_solver.verify.branches import Branch, Branches
from rpr_solver.verify.censuses import degenerate
from rpr_solver.verify.claims import Claim, Open, claim_by, demand, settled
from rpr_solver.verify.equations import Mechanism, Slice
from rpr_solver.verify.events import Event, all_of, decided
from rpr_solver.verify.listed import Matching, Row, agrees, pose_numbers
from rpr_solver.verify.members import POSE_KINDS, RANGE, Document, Leg
from rpr_solver.verify.numbers import POSITIVE, Printed, ball, is_positive
from rpr_solver.verify.reader import (
    Read,
    Record,
    count,
    nothing_or,
    record,
    rows,
    text,
    word,
)
from rpr_solver.verify.survey import Survey
from rpr_solver.verify.tables import is_sorted
from rpr_solver.verify.work import Work

SIDES = ("from", "to")
_NAME = text("C[1-9][0-9]{0,5}")
_ANEW = "all branches are found anew, from event to event"


def curves_schema(leg: Leg) -> Read:
    """The members of a document of cusp curves."""
    kinds = (*POSE_KINDS, "several", "unclassified", "undecided", "open")
    end = {
        "kind": word(*kinds),
        "joins": nothing_or(_NAME),
        "events": rows(record(leg.degenerate_point), 0, 200),
    }
    point = record({leg.length: POSITIVE, "cusp": count(1, MOST_CUSPS), **leg.point})
    curve = record(
        {
            "name": _NAME,
            "from": record({leg.length: leg.start, **end}),
            "to": record({leg.length: nothing_or(leg.start), **end}),
            "points": rows(point),
        }
    )
    own = {**leg.on_leg, "range": RANGE, "curves": rows(curve, 0, 1000)}
    return record(own, {"degenerate": leg.degenerate})


def curve_claims(document: Document, work: Work, progress: Progress) -> Iterator[Claim]:
    """The claims of a document of cusp curves."""
    progress(0, 1)
    yield from _Curves(document, work).claims()
    progress(1, 1)


class _Curves:
    """Cusp curves as they are printed, and the branches that are found."""

    def __init__(self, document: Document, work: Work) -> None:
        self.members, self.work = document.members, work
        self.mechanism = Mechanism(document.geometry, document.fixed)
        self.length, self.theta = f"l{document.fixed}", f"theta{document.fixed}_deg"
        self.curves: Sequence[Record] = self.members["curves"]
        self.survey = Survey(self.mechanism, Fraction(0), None, (), work)
        self.slices: dict[Fraction, list[tuple[int, Record]]] = {}
        for n, curve in enumerate(self.curves):
            for point in curve["points"]:
                self.slices.setdefault(point[self.length], []).append((n, point))

    def claims(self) -> Iterator[Claim]:
        """All of them."""
        yield claim_by(
            "/curves", "curves have different names, and those that join name each other", self._named
        )
        yield claim_by("/range", "the points are in the range", self._inside)
        for n, curve in enumerate(self.curves):
            for k, point in enumerate(curve["points"]):
                claim = f"cusp {point['cusp']} of its slice, with these digits"
                yield claim_by(f"/curves/{n}/points/{k}", claim, partial(self._point, n, point))
            yield claim_by(
                f"/curves/{n}/points", "they are all points of one curve", partial(self._is_one, n)
            )
            for side in SIDES:
                claim = f"an end: {curve[side]['kind']}"
                yield claim_by(f"/curves/{n}/{side}", claim, partial(self._end, n, side))
        yield claim_by("/curves", "these are all curves of the range", self._all)
        listed = self.members.get("degenerate", ())
        yield claim_by(
            "/degenerate", "what is degenerate in all slices", partial(degenerate, self.survey, listed)
        )

    def _named(self) -> str:
        names = [curve["name"] for curve in self.curves]
        demand(len(set(names)) == len(names), "two have one name")
        for curve in self.curves:
            for side in SIDES:
                joins = curve[side]["joins"]
                demand(joins != curve["name"], f"{joins} joins itself")
                if joins in names:
                    other = self.curves[names.index(joins)][side]
                    demand(other["joins"] == curve["name"], f"{joins} does not join {curve['name']} there")
        return "as printed"

    def _inside(self) -> str:
        start, stop = self.members["range"]["from"], self.members["range"]["to"]
        demand(stop is None or start < stop, "it has no length")
        demand(all(start <= x and (stop is None or x <= stop) for x in self.slices), "one is not")
        for curve in self.curves:
            lengths = [point[self.length] for point in curve["points"]]
            demand(lengths == sorted(set(lengths)), f"those of {curve['name']} do not ascend")
        return "as printed"

    @settled
    def _found(self) -> Branches:
        """All branches that are found."""
        return Branches.of(self.survey, self.slices)

    @settled
    def _of_points(self) -> Mapping[Fraction, Mapping[int, Branch]]:
        """The branches of the points of each length, by the numbers of their curves."""
        found: dict[Fraction, dict[int, Branch]] = {}
        for length, listed in self.slices.items():
            own, zeros = Slice(self.mechanism, length), self._found.slices[length]
            points = [{name: x for name, x in point.items() if isinstance(x, Printed)} for _, point in listed]
            places = Matching.of(
                [Row(x) for x in points], zeros, partial(pose_numbers, own), self.work
            ).places
            pairs = zip(listed, places, strict=True)
            found[length] = {n: self._found.at(length, k) for (n, _), k in pairs if k is not None}
        return found

    @settled
    def _matched(self) -> Sequence[Branch | None]:
        """For each curve the branch that it is, each another: by its first point, or by its ends."""
        matched: list[Branch | None] = []
        for n, curve in enumerate(self.curves):
            first = curve["points"][0][self.length] if curve["points"] else None
            matched.append(None if first is None else self._of_points[first].get(n))
        for n, curve in enumerate(self.curves):
            if not curve["points"]:
                rest = [
                    x for x in self._found.all if x not in matched and not x.cusps.keys() & self.slices.keys()
                ]
                matched[n] = next((x for x in rest if all(self._is_end(curve[s], x, s) for s in SIDES)), None)
        return matched

    def _point(self, n: int, point: Record) -> str:
        length = point[self.length]
        listed = sorted(self.slices[length], key=lambda pair: pair[1]["cusp"])
        demand(
            [x["cusp"] for _, x in listed] == list(range(1, len(listed) + 1)),
            "the numbers are not all of 1, 2, …",
        )
        demand(
            is_sorted([x[self.theta].value for _, x in listed]), "the numbers are not in the order of angles"
        )
        cusps = len(self._found.slices[length])
        demand(len(listed) == cusps, f"there are {cusps} cusps, and {len(listed)} points")
        return demand(n in self._of_points[length], "no cusp has these digits, or it is another point", _ANEW)

    def _is_one(self, n: int) -> str:
        branch = self._matched[n]
        demand(branch is not None, "no branch is this curve, or another curve is it")
        assert branch is not None
        points = {point[self.length] for point in self.curves[n]["points"]}
        demand(all(self._of_points[x].get(n) is branch for x in points), "one is on another branch")
        return demand(points == branch.cusps.keys() & self.slices.keys(), "it passes other slices", _ANEW)

    def _end(self, n: int, side: str) -> str:
        branch, end = self._matched[n], self.curves[n][side]
        demand(branch is not None, "no branch is this curve")
        assert branch is not None
        demand(self._is_end(end, branch, side), "it is at another event, or at none")
        event = branch.begins if side == "from" else branch.ends
        partner = next(
            (x for x in self._found.all if x is not branch and event and event is _at(x, side)), None
        )
        joined = [
            curve["name"] for curve, x in zip(self.curves, self._matched, strict=True) if x is partner and x
        ]
        if partner is None:
            return demand(end["joins"] is None, "no branch joins it there", _ANEW)
        if joined:
            return demand([end["joins"]] == joined, f"{joined[0]} joins it there", _ANEW)
        known = {curve["name"] for curve in self.curves}
        return demand(end["joins"] not in (None, *known), "another curve joins it there", _ANEW)

    def _is_end(self, end: Record, branch: Branch, side: str) -> bool:
        """Whether an end is that of a branch: of this kind, with these digits.

        Raises:
            Open: it is not decided.
        """
        event, listed, length = _at(branch, side), end["events"], end[self.length]
        if event is None:
            is_open = length is None if side == "to" else length is not None and length.is_zero
            return bool(end["kind"] == "open" and is_open and not listed)
        if length is None or len(listed) != 1:
            return False
        if not end["kind"] == listed[0]["kind"] == event.kind:
            return False
        numbers = {name: x for name, x in listed[0].items() if isinstance(x, Printed)}
        row = Row({**numbers, self.length: length})
        same = agrees(event.zero, row, event.numbers, self.work)
        if same is None:
            raise Open("it is open whether an event has these digits")
        return same

    def _all(self) -> str:
        start, stop = self.members["range"]["from"], self.members["range"]["to"]
        meeting = [x for x in self._found.all if _meets(x, start, stop)]
        for branch in meeting:
            demand(branch in self._matched, "a branch is not listed")
        extra = [c["name"] for c, x in zip(self.curves, self._matched, strict=True) if x not in meeting]
        return demand(not extra, f"{', '.join(extra)} is no branch that meets the range", _ANEW)


def _at(branch: Branch, side: str) -> Event | None:
    """The event at which a branch begins or ends."""
    return branch.begins if side == "from" else branch.ends


def _meets(branch: Branch, start: Fraction, stop: Fraction | None) -> bool:
    """Whether a branch has lengths of a range.

    Raises:
        Open: it is not decided.
    """
    return decided(lambda bits: _overlaps(branch, start, stop, bits))


def _overlaps(branch: Branch, start: Fraction, stop: Fraction | None, bits: int) -> bool | None:
    low, high = (
        None if x is None else x.lengths(bits)[x.space.mechanism.fixed] for x in (branch.begins, branch.ends)
    )
    sides = [
        high is None or is_positive(high - ball(start)),
        low is None or stop is None or is_positive(ball(stop) - low),
    ]
    return all_of(iter(sides))
