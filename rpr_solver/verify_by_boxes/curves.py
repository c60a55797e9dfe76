"""Cusp curves: each is a branch found anew, with its points, its ends, and the one that joins it there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial

from flint import arb

from rpr_solver.boxes import Box
from rpr_solver.contract import MOST_CUSPS, Progress
from rpr_solver.verify_by_boxes.branches import Branch, Branches
from rpr_solver.verify_by_boxes.censuses import degenerate
from rpr_solver.verify_by_boxes.claims import Claim, OpenError, demand, judged
from rpr_solver.verify_by_boxes.equations import Mechanism, Space
from rpr_solver.verify_by_boxes.events import Event
from rpr_solver.verify_by_boxes.listed import Matching, Row, agrees, degrees
from rpr_solver.verify_by_boxes.members import POSE_KINDS, RANGE, Document, Leg
from rpr_solver.verify_by_boxes.numbers import POSITIVE, Printed, ball
from rpr_solver.verify_by_boxes.reader import Read, Record, anything, count, no_claim, nothing_or, record, rows, text, word
from rpr_solver.verify_by_boxes.survey import Survey
from rpr_solver.verify_by_boxes.tables import is_sorted
from rpr_solver.verify_by_boxes.work import Work

SIDES = ("from", "to")
_NAME = text("C[1-9][0-9]{0,5}")


def curves_schema(leg: Leg) -> Read:
    """The members of a document of cusp curves."""
    kinds = (*POSE_KINDS, "several", "unclassified", "undecided", "open")
    end = {"kind": word(*kinds), "joins": nothing_or(_NAME), "events": rows(record(leg.degenerate_point), 0, 200)}
    point = record({leg.length: POSITIVE, "cusp": count(1, MOST_CUSPS), **leg.point})
    curve = record(
        {
            "name": _NAME,
            "from": record({leg.length: leg.start, **end}),
            "to": record({leg.length: nothing_or(leg.start), **end}),
            "points": rows(point),
        }
    )
    more = {"degenerate": leg.degenerate, "certificate": no_claim(anything)}
    return record({**leg.on_leg, "range": RANGE, "curves": rows(curve, 0, 1000)}, more)


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
        yield judged("/curves", "curves have different names, and those that join name each other", self._named)
        yield judged("/range", "the points are in the range", self._inside)
        for n, curve in enumerate(self.curves):
            for k, point in enumerate(curve["points"]):
                claim = f"cusp {point['cusp']} of its slice, with these digits"
                yield judged(f"/curves/{n}/points/{k}", claim, partial(self._point, n, point))
            yield judged(f"/curves/{n}/points", "they are all points of one curve", partial(self._is_one, n))
            for side in SIDES:
                claim = f"an end: {curve[side]['kind']}"
                yield judged(f"/curves/{n}/{side}", claim, partial(self._end, n, side))
        yield judged("/curves", "these are all curves of the range", self._all)
        listed = self.members.get("degenerate", ())
        yield judged("/degenerate", "what is degenerate in all slices", partial(degenerate, self.survey, listed))

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
    def _branches(self) -> Branches:
        """All that are found."""
        return Branches.of(self.survey, self.slices)
