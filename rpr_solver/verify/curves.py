"""Cusp curves: each point a cusp of its slice, none missing or twice, each end a transition."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.contract import MOST_CUSPS, Progress
from rpr_solver.verify.alike import doubtful_of, located
from rpr_solver.verify.chains import SIDES, Chains, Place
from rpr_solver.verify.claims import Claim, ClaimStatus, status_of
from rpr_solver.verify.core.boxes import Box
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.printed import Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import System
from rpr_solver.verify.counts import OPEN, count_of
from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.events import Finding, event_finding
from rpr_solver.verify.links import Pose
from rpr_solver.verify.points import Point, Points
from rpr_solver.verify.slices import sorted_turns
from rpr_solver.verify.surface import Surface

_LENGTH_ONLY = ("unclassified", "undecided", "several")


def curve_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of a document of cusp curves."""
    yield from _Curves(document).claims(progress)


@dataclass(frozen=True)
class _Listed:
    """A point of a curve: the numbers of the curve and of the point in it."""

    curve: int
    place: int
    point: Record

    @property
    def at(self) -> str:
        return f"/curves/{self.curve}/points/{self.place}"


class _Curves:
    def __init__(self, document: Document) -> None:
        self.geometry, self.fixed, self.members = document.geometry, document.fixed, document.members
        self.curves: tuple[Record, ...] = self.members["curves"]
        self.name = f"l{self.fixed}"
        self.ends: list[tuple[Printed, Printed | None]] = [
            (curve["from"][self.name], curve["to"][self.name]) for curve in self.curves
        ]
        self.slices: dict[Fraction, list[_Listed]] = {}
        for n, curve in enumerate(self.curves):
            for k, point in enumerate(curve["points"]):
                self.slices.setdefault(point[self.name], []).append(_Listed(n, k, point))

    def claims(self, progress: Progress) -> Iterator[Claim]:
        surface = Surface.of(self.geometry, self.fixed)
        chains = Chains(surface, self.members) if "certificate" in self.members else None
        total = len(self.curves) + len(self.slices) + (chains.count if chains else 0)
        yield from self._named()
        known: dict[tuple[str, ...], Finding] = {}
        for n, curve in enumerate(self.curves):
            progress(n, total)
            for side in SIDES:
                yield from self._end(surface, known, f"/curves/{n}/{side}", curve[side])
            yield self._ordered(n, curve)
        bits = chains.bits if chains else {}
        poses: dict[Place, Pose] = {}
        for n, (length, listed) in enumerate(sorted(self.slices.items(), key=lambda item: item[0])):
            progress(len(self.curves) + n, total)
            yield from self._slice(surface, length, listed, bits, poses)
        if chains:
            done = len(self.curves) + len(self.slices)
            yield from chains.claims(poses, lambda n: progress(done + n, total))
        else:
            reason = "only a full certificate has the tubes that join them"
            yield Claim("/curves", "the points of a curve are joined by it", ClaimStatus.NOT_CHECKED, reason)
        reason = "only at the lengths of points all cusps are there; a census of the range proves the ends"
        yield Claim("/curves", "these are all curves of the range", ClaimStatus.NOT_CHECKED, reason)
        if "degenerate" in self.members:
            at, claim = "/degenerate", "what is degenerate throughout an interval, or along a curve"
            yield Claim(at, claim, ClaimStatus.NOT_CHECKED, OPEN)
        progress(1, 1)

    def _named(self) -> Iterator[Claim]:
        """Names are different, each curve is in the range, and joined ends name each other."""
        by_name = {curve["name"]: curve for curve in self.curves}
        wrong = "" if len(by_name) == len(self.curves) else "two curves have one name"
        outside = []
        for curve in self.curves:
            for side in SIDES:
                end, joins = curve[side], curve[side]["joins"]
                other = by_name.get(joins)
                if joins == curve["name"] or (joins is not None and end["kind"] in ("open", "undecided")):
                    wrong = f"{curve['name']} joins {joins}"
                elif joins is not None and other is None:
                    outside.append(joins)
                elif other is not None:
                    backward = other[side]
                    alike = (backward["joins"], backward[self.name]) == (curve["name"], end[self.name])
                    if not alike or not _same(backward["events"], end["events"]):
                        wrong = f"{curve['name']} joins {joins}, which does not join it there"
        claim = "curves have different names, and those that join name each other"
        yield Claim("/curves", claim, status_of(not wrong), wrong or "as printed")
        if outside:
            reason = f"{', '.join(dict.fromkeys(outside))} is not in the document"
            yield Claim("/curves", "the curves that join others", ClaimStatus.NOT_CHECKED, reason)
        start, stop = self.members["range"]["from"], self.members["range"]["to"]
        right = stop is None or start < stop
        for low, high in self.ends:
            right = right and (stop is None or low.lower <= stop) and (high is None or start <= high.upper)
        right = right and all(start <= x and (stop is None or x <= stop) for x in self.slices)
        reason = "as printed" if right else "a curve or a point is beyond it"
        yield Claim("/range", "the curves meet the range, and points are in it", status_of(right), reason)
        bare = [curve["name"] for curve in self.curves if not curve["points"]]
        if bare:
            reason = f"no point is given of {', '.join(bare[:3])}{', …' if len(bare) > 3 else ''}"
            yield Claim("/curves", "curves without points are there", ClaimStatus.NOT_CHECKED, reason)

    def _end(
        self, surface: Surface, known: dict[tuple[str, ...], Finding], at: str, end: Record
    ) -> Iterator[Claim]:
        kind, length, events = end["kind"], end[self.name], end["events"]
        if kind == "open":
            is_end = length is None if at.endswith("/to") else length is not None and length.is_zero
            right = is_end and not events
            reason = (
                "the end of all lengths" if right else "an open end is at 0 or has no length, and no pose"
            )
            yield Claim(at, "an end: open", status_of(right), reason)
            return
        if length is None or length.is_zero or (not events and kind not in _LENGTH_ONLY):
            reason = "it has no length, or no pose"
            yield Claim(at, f"an end: {kind}", ClaimStatus.REFUSED, reason)
            return
        if not events:
            yield Claim(at, f"an end: {kind}", ClaimStatus.NOT_CHECKED, "no pose is given there")
        for k, event in enumerate(events):
            key = (length.text, *(getattr(x, "text", x) for x in event.values()))
            if key not in known:
                known[key] = event_finding(surface, length, event)
            status, reason = known[key]
            yield Claim(f"{at}/events/{k}", f"a {event['kind']} at this length", status, reason)
        kinds = {event["kind"] for event in events}
        if events and kind != "undecided" and kind != ("several" if len(kinds) > 1 else next(iter(kinds))):
            reason = "the pose is of another kind"
            yield Claim(f"{at}/kind", "the kind of the pose", ClaimStatus.REFUSED, reason)
        if kind == "undecided" or len(events) > 1:
            reason = "it is not said which pose is the end of the curve"
            yield Claim(at, f"an end: {kind}", ClaimStatus.NOT_CHECKED, reason)

    def _passes(self, n: int, length: Fraction) -> bool | None:
        """Whether a length lies between the ends of a curve; None if their digits leave that open."""
        start, stop = self.ends[n]
        sides = start.below(length), stop is None or stop.above(length)
        return False if False in sides else None if None in sides else True

    def _ordered(self, n: int, curve: Record) -> Claim:
        at, claim = f"/curves/{n}/points", "the points ascend between the ends"
        start, stop = self.ends[n]
        lengths = [point[self.name] for point in curve["points"]]
        inside = [self._passes(n, x) for x in lengths]
        apart = stop is None or start.lower < stop.upper
        if False in inside or not apart or lengths != sorted(set(lengths)):
            reason = "a point lies beyond an end, or they are not ascending"
            return Claim(at, claim, ClaimStatus.REFUSED, reason)
        if None in inside or not (lengths or stop is None or start.upper < stop.lower):
            reason = "up to half a unit of the last digit of an end"
            return Claim(at, claim, ClaimStatus.CHECKED, reason)
        return Claim(at, claim, ClaimStatus.PROVED, "as printed")

    def _slice(
        self,
        surface: Surface,
        length: Fraction,
        listed: list[_Listed],
        bits: Mapping[Place, int],
        poses: dict[Place, Pose],
    ) -> Iterator[Claim]:
        """All points of one length: different cusps, numbered as in the table, and as many as there are.

        The boxes of the points are put into ``poses``, as fine as ``bits`` says.
        """
        if len(listed) > MOST_CUSPS:
            claim, reason = "different curves are different cusps", f"no slice has more than {MOST_CUSPS}"
            yield Claim(listed[0].at, claim, ClaimStatus.REFUSED, reason)
            return
        system = System.of(self.geometry, self.fixed, length)
        boxes, order = [], []
        places = [(self.curves[item.curve]["name"], length) for item in listed]
        found = _located(system, listed, max(bits.get(place, 0) for place in places))
        for item, place, (point, box, (status, reason)) in zip(listed, places, found, strict=True):
            if box:
                scaled = Interval.of(length * surface.unit, box.alpha.bits)
                poses[place] = Pose(box.alpha, box.theta, scaled)
            boxes.append(box)
            order.append((point.theta.value, item.point["cusp"]))
            yield Claim(item.at, "a cusp with these digits", status, reason)
        where = ", ".join(item.at for item in listed[:2])
        at = listed[0].at
        if _doubled([box for box in boxes if box]):
            reason = "two curves have one and the same cusp in this slice"
            yield Claim(at, "different curves are different cusps", ClaimStatus.REFUSED, reason)
            return
        ranked = sorted(range(len(order)), key=order.__getitem__)  # any order where angles are printed alike
        numbers = [ranked.index(n) + 1 for n in range(len(order))]
        passes = [self._passes(n, length) for n in range(len(self.curves))]
        there = {item.curve for item in listed}
        claim = "every curve of this length has a point"
        if any(known is not None and known != (n in there) for n, known in enumerate(passes)):
            reason = "a curve that passes this length has no point there, or one that does not pass has one"
            yield Claim(at, claim, ClaimStatus.REFUSED, reason)
            return
        if None in passes:
            reason = "up to half a unit of the last digit of an end"
            yield Claim(at, claim, ClaimStatus.CHECKED, reason)
        cusps = [item.point["cusp"] for item in listed]
        by_number = [value for _, (value, _) in sorted(zip(cusps, order, strict=True))]
        if sorted(cusps) != sorted(numbers) or not sorted_turns(by_number):
            reason = f"they are {numbers}, at {where}, …"
            yield Claim(at, "the numbers of the cusps", ClaimStatus.REFUSED, reason)
        claim = f"the {len(listed)} curves of {self.name} = {length} have all cusps of the slice"
        yield Claim(at, claim, *_all(system, len(listed)))


def _same(first: Sequence[Record], second: Sequence[Record]) -> bool:
    return [dict(event) for event in first] == [dict(event) for event in second]


def _located(system: System, listed: list[_Listed], bits: int) -> list[tuple[Point, Box | None, Finding]]:
    """Each point with its box; those that are printed alike have theirs in the order of their numbers."""
    points = Points(system)
    ranked = sorted(listed, key=lambda item: item.point["cusp"])
    printed = [Point.of(item.point, system) for item in ranked]
    found = located(points, printed, bits=bits)
    if doubtful_of(found):
        found = located(points, printed, Eliminant.if_any(system), bits)
    by_place = {id(item): (x.point, x.box, x.finding) for item, x in zip(ranked, found, strict=True)}
    return [by_place[id(item)] for item in listed]


def _doubled(boxes: list[Box]) -> bool:
    return any(x.meets(y) for n, x in enumerate(boxes) for y in boxes[:n])


def _all(system: System, count: int) -> Finding:
    found = count_of(system)
    if found is None:
        return ClaimStatus.NOT_CHECKED, "the resultant vanishes identically"
    number, proved = found
    if number != count:
        return ClaimStatus.REFUSED, f"the slice has {number}"
    if proved:
        return ClaimStatus.PROVED, f"Q has {number} simple real roots, one cusp above each"
    return (
        ClaimStatus.CHECKED,
        "Q has multiple roots in this slice, and the cusps above them were searched for",
    )
