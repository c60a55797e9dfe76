"""Cusp curves: each point a cusp of its slice, none missing or twice, each end a transition."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from rpr_solver.contract import Progress, check_digits, check_leg
from rpr_solver.errors import InputError
from rpr_solver.verify.alike import doubtful_of, located
from rpr_solver.verify.boxes import Box
from rpr_solver.verify.chains import SIDES, Chains, Place
from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.counts import count_of
from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.events import Finding, event_finding
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.links import Pose
from rpr_solver.verify.manipulator import Geometry, exact
from rpr_solver.verify.points import Point, Points
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.surface import Surface
from rpr_solver.verify.system import System

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
        self.geometry, self.document = geometry, document
        self.is_full = "full" in document.get("certificate", {})
        self.fixed = check_leg(document.get("fixed_leg", 1))
        self.digits = check_digits(document.get("digits", 15))
        self.curves: list[Mapping[str, Any]] = document["curves"]
        self.name = f"l{self.fixed}"
        if not isinstance(self.curves, list) or not all(isinstance(x, Mapping) for x in self.curves):
            raise InputError.of("curves", "is not a list of curves")
        self.ends = [self._printed_ends(n, curve) for n, curve in enumerate(self.curves)]
        self.slices: dict[Fraction, list[_Listed]] = {}
        for n, curve in enumerate(self.curves):
            for k, point in enumerate(curve["points"]):
                listed = _Listed(n, k, point.get("cusp"), point)
                length = exact(point.get(self.name), f"{listed.at}/{self.name}")
                self.slices.setdefault(length, []).append(listed)

    def claims(self, progress: Progress) -> Iterator[Claim]:
        surface = Surface.of(self.geometry, self.fixed)
        chains = Chains(surface, self.document) if self.is_full else None
        total = len(self.curves) + len(self.slices) + (chains.count if chains else 0)
        yield self._named()
        known: dict[str, Finding] = {}
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
        progress(1, 1)

    def _named(self) -> Claim:
        """Names are different, and joined ends name each other and share their length."""
        claim = "curves have different names, and those that join name each other"
        by_name = {curve.get("name"): curve for curve in self.curves}
        right = len(by_name) == len(self.curves)
        reason = "as printed" if right else "two curves have one name"
        for curve in self.curves:
            for side in SIDES:
                end = curve[side]
                other = by_name.get(end.get("joins"))
                if other is None:  # of another part of the range, perhaps
                    continue
                backward = [x for x in (other[s] for s in SIDES) if x.get("joins") == curve.get("name")]
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
            elif Printed.of(length, f"{at}/{self.name}").digits != self.digits:
                status, reason = ClaimStatus.REFUSED, "the length has more or fewer digits"
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

    def _printed_ends(self, n: int, curve: Mapping[str, Any]) -> tuple[Printed, Printed | None]:
        start, stop = (curve[side].get(self.name) for side in SIDES)
        at = f"/curves/{n}"
        return Printed.of(start, f"{at}/from/{self.name}"), (
            None if stop is None else Printed.of(stop, f"{at}/to/{self.name}")
        )

    def _passes(self, n: int, length: Fraction) -> bool | None:
        """Whether a length lies between the ends of a curve; None if their digits leave that open."""
        start, stop = self.ends[n]
        sides = start.below(length), stop is None or stop.above(length)
        return False if False in sides else None if None in sides else True

    def _ordered(self, n: int, curve: Mapping[str, Any]) -> Claim:
        at, claim = f"/curves/{n}/points", "the points ascend between the ends"
        start, stop = self.ends[n]
        lengths = [exact(point[self.name], self.name) for point in curve["points"]]
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
        system = System.of(self.geometry, self.fixed, length)
        boxes, order = [], []
        places = [(str(self.curves[item.curve].get("name")), length) for item in listed]
        found = _located(system, listed, max(bits.get(place, 0) for place in places))
        for item, place, (point, box, (status, reason)) in zip(listed, places, found, strict=True):
            if box:
                scaled = Interval.of(length * surface.unit, box.alpha.bits)
                poses[place] = Pose(box.alpha, box.theta, scaled)
            if any(not x.is_zero and x.digits != self.digits for x in point.numbers):
                status, reason = ClaimStatus.REFUSED, "a number has more or fewer digits"
            boxes.append(box)
            order.append((point.theta.value, item.cusp if isinstance(item.cusp, int) else 0))
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
        if [item.cusp for item in listed] != numbers:
            reason = f"they are {numbers}, at {where}, …"
            yield Claim(at, "the numbers of the cusps", ClaimStatus.REFUSED, reason)
        claim = f"the {len(listed)} curves of {self.name} = {length} have all cusps of the slice"
        yield Claim(at, claim, *_all(system, len(listed)))


def _located(system: System, listed: list[_Listed], bits: int) -> list[tuple[Point, Box | None, Finding]]:
    """Each point with its box; those that are printed alike have theirs in the order of their numbers."""
    points = Points(system)
    ranked = sorted(listed, key=lambda item: item.cusp if isinstance(item.cusp, int) else 0)
    printed = [Point.of(item.point, system, item.at) for item in ranked]
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
