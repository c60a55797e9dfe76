"""Cusp curves: each point a cusp of its slice, none missing or twice, each end a transition."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from rpr_solver.contract import Progress, check_digits, check_leg
from rpr_solver.errors import InputError
from rpr_solver.verify.boxes import Box
from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.counts import count_of
from rpr_solver.verify.events import Finding, event_finding
from rpr_solver.verify.manipulator import Geometry, exact
from rpr_solver.verify.points import Point, Points
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.surface import Surface
from rpr_solver.verify.system import System

_ENDS = ("from", "to")
_LENGTH_ONLY = ("open", "unclassified", "undecided", "several")


def curve_claims(geometry: Geometry, document: Mapping[str, Any], progress: Progress) -> Iterator[Claim]:
    """The claims of a document of cusp curves.

    Raises:
        InputError: naming a member that cannot be read.
    """
    yield from _Curves(geometry, document).claims(progress)


@dataclass(frozen=True)
class _Listed:
    """A point of a curve: the numbers of the curve and of the point in it, and the number of the cusp."""

    curve: int
    place: int
    cusp: Any
    point: Mapping[str, Any]

    @property
    def at(self) -> str:
        return f"/curves/{self.curve}/points/{self.place}"


class _Curves:
    def __init__(self, geometry: Geometry, document: Mapping[str, Any]) -> None:
        self.geometry = geometry
        self.fixed = check_leg(document.get("fixed_leg", 1))
        self.digits = check_digits(document.get("digits", 15))
        self.curves: list[Mapping[str, Any]] = document["curves"]
        self.name = f"l{self.fixed}"
        if not isinstance(self.curves, list) or not all(isinstance(x, Mapping) for x in self.curves):
            raise InputError.of("curves", "is not a list of curves")
        self.slices: dict[Fraction, list[_Listed]] = {}
        for n, curve in enumerate(self.curves):
            for k, point in enumerate(curve["points"]):
                listed = _Listed(n, k, point.get("cusp"), point)
                length = exact(point.get(self.name), f"{listed.at}/{self.name}")
                self.slices.setdefault(length, []).append(listed)

    def claims(self, progress: Progress) -> Iterator[Claim]:
        surface = Surface.of(self.geometry, self.fixed)
        yield self._named()
        known: dict[str, Finding] = {}
        for n, curve in enumerate(self.curves):
            progress(n, len(self.curves) + len(self.slices))
            for side in _ENDS:
                yield from self._end(surface, known, f"/curves/{n}/{side}", curve[side])
            yield self._ordered(n, curve)
        for n, (length, listed) in enumerate(sorted(self.slices.items(), key=lambda item: item[0])):
            progress(len(self.curves) + n, len(self.curves) + len(self.slices))
            yield from self._slice(length, listed)
        reason = "continuation between the points is not followed by this verifier"
        yield Claim("/curves", "the points of a curve are joined by it", ClaimStatus.NOT_CHECKED, reason)
        progress(1, 1)

    def _named(self) -> Claim:
        """Names are different, and joined ends name each other and share their length."""
        claim = "curves have different names, and those that join name each other"
        by_name = {curve.get("name"): curve for curve in self.curves}
        right = len(by_name) == len(self.curves)
        reason = "as printed" if right else "two curves have one name"
        for curve in self.curves:
            for side in _ENDS:
                end = curve[side]
                other = by_name.get(end.get("joins"))
                if other is None:  # of another part of the range, perhaps
                    continue
                backward = [x for x in (other[s] for s in _ENDS) if x.get("joins") == curve.get("name")]
                if all(x.get(self.name) != end.get(self.name) for x in backward):
                    right, reason = (
                        False,
                        f"{curve.get('name')} joins {end.get('joins')}, which does not join it",
                    )
        return Claim("/curves", claim, ClaimStatus.PROVED if right else ClaimStatus.REFUSED, reason)

    def _end(
        self, surface: Surface, known: dict[str, Finding], at: str, end: Mapping[str, Any]
    ) -> Iterator[Claim]:
        kind, length, events = end.get("kind"), end.get(self.name), end["events"]
        if not events:
            status = ClaimStatus.NOT_CHECKED
            reason = "no pose is given there"
            if kind == "open":
                right = length in ("0", None)
                status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
                reason = "the end of all lengths" if right else "an open end is at 0 or has no length"
            elif kind not in _LENGTH_ONLY:
                status, reason = ClaimStatus.REFUSED, f"a {kind} without a pose"
            yield Claim(at, f"an end: {kind}", status, reason)
            return
        printed = Printed.of(length, f"{at}/{self.name}")
        for k, event in enumerate(events):
            key = f"{length} {sorted(event.items())}"
            if key not in known:
                known[key] = event_finding(surface, self.digits, printed, event, f"{at}/events/{k}")
            status, reason = known[key]
            yield Claim(f"{at}/events/{k}", f"a {event.get('kind')} at this length", status, reason)
        kinds = {event.get("kind") for event in events}
        if kind not in kinds and kind not in _LENGTH_ONLY:
            yield Claim(
                f"{at}/kind", "the kind of the pose", ClaimStatus.REFUSED, "the pose is of another kind"
            )

    def _span(self, curve: Mapping[str, Any]) -> tuple[Fraction, Fraction | None]:
        start, stop = (curve[side].get(self.name) for side in _ENDS)
        return exact(start, self.name), None if stop is None else exact(stop, self.name)

    def _ordered(self, n: int, curve: Mapping[str, Any]) -> Claim:
        start, stop = self._span(curve)
        lengths = [exact(point[self.name], self.name) for point in curve["points"]]
        inside = all(start < x and (stop is None or x < stop) for x in lengths)
        right = inside and lengths == sorted(set(lengths)) and (stop is None or start < stop)
        status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
        reason = "as printed" if right else "a point lies beyond an end, or they are not ascending"
        return Claim(f"/curves/{n}/points", "the points ascend between the ends", status, reason)

    def _slice(self, length: Fraction, listed: list[_Listed]) -> Iterator[Claim]:
        """All points of one length: different cusps, numbered as in the table, and as many as there are."""
        system = System.of(self.geometry, self.fixed, length)
        points, boxes = Points(system), []
        order = []
        for item in listed:
            point = Point.of(item.point, system, item.at)
            box, (status, reason) = points.cusp(point)
            if any(not x.is_zero and x.digits != self.digits for x in point.numbers):
                status, reason = ClaimStatus.REFUSED, "a number has more or fewer digits"
            boxes.append(box)
            order.append((point.theta.value, point.alpha.value))
            yield Claim(item.at, "a cusp with these digits", status, reason)
        where = ", ".join(item.at for item in listed[:2])
        at = listed[0].at
        if _doubled([box for box in boxes if box]):
            reason = "two curves have one and the same cusp in this slice"
            yield Claim(at, "different curves are different cusps", ClaimStatus.REFUSED, reason)
            return
        numbers = [sorted(order).index(key) + 1 for key in order]
        alive = {n for n, curve in enumerate(self.curves) if self._holds(curve, length)}
        there = {item.curve for item in listed}
        if alive != there:
            reason = "a curve that passes this length has no point there, or one that does not pass has one"
            yield Claim(at, "every curve of this length has a point", ClaimStatus.REFUSED, reason)
            return
        if [item.cusp for item in listed] != numbers:
            reason = f"they are {numbers}, at {where}, …"
            yield Claim(at, "the numbers of the cusps", ClaimStatus.REFUSED, reason)
        claim = f"the {len(listed)} curves of {self.name} = {length} have all cusps of the slice"
        yield Claim(at, claim, *_all(system, len(listed)))

    def _holds(self, curve: Mapping[str, Any], length: Fraction) -> bool:
        start, stop = self._span(curve)
        return start < length and (stop is None or length < stop)


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
