"""Cusp tables: of each slice its factors, its cusps, its count."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property

from rpr_solver.contract import Progress
from rpr_solver.verify.alike import Located, located
from rpr_solver.verify.claims import Claim, ClaimStatus, status_of
from rpr_solver.verify.core.angles import pi
from rpr_solver.verify.core.boxes import Box, Pair
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.manipulator import Geometry
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import System
from rpr_solver.verify.eliminant import DEGREE, Eliminant
from rpr_solver.verify.full import full_claims
from rpr_solver.verify.lines import nearby, separation, special_lines, unlisted
from rpr_solver.verify.points import Point, Points

_FACTOR = ("degree", "multiplicity", "origin")


def table_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of all slices of a cusp table."""
    slices = document.members["slices"]
    for n, part in enumerate(slices):
        progress(n, len(slices))
        yield from slice_claims(document.geometry, document.fixed, part, f"/slices/{n}")
    progress(len(slices), len(slices))


def slice_claims(geometry: Geometry, fixed: int, part: Record, at: str) -> Iterator[Claim]:
    """All claims of a slice object."""
    if "error" in part:
        reason = "an error says nothing about cusps"
        yield Claim(at, "the slice has no answer", ClaimStatus.NOT_CHECKED, reason)
        return
    yield from _Slice(System.of(geometry, fixed, part[f"l{fixed}"]), part, at).claims()


def _is_curve(point: Record) -> bool:
    return bool(point["kind"] == "curve")


def sorted_turns(angles: Sequence[Fraction]) -> bool:
    """Whether angles in degrees ascend, where one just above −180 is printed as 180 and comes first."""
    first = next((n for n, x in enumerate(angles) if x != 180), 0)
    turned = [Fraction(-180)] * first + list(angles[first:])
    return turned == sorted(turned)


class _Slice:
    def __init__(self, system: System, part: Record, at: str) -> None:
        self.system = system
        self.part = part
        self.at = at
        self.points = Points(system)

    @cached_property
    def _eliminant(self) -> Eliminant | None:
        return Eliminant.if_any(self.system)

    def claims(self) -> Iterator[Claim]:
        cusps = [Point.of(point, self.system) for point in self.part["cusps"]]
        others = self.part["degenerate_points"]
        found_cusps, found_others = located(self.points, cusps, self._eliminant), []
        for n, found in enumerate(found_cusps):
            yield self._claim(f"cusps/{n}", "a cusp with these digits", *found.finding)
        for n, other in enumerate(others):
            if not _is_curve(other):
                where = f"degenerate_points/{n}"
                point = Point.of(other, self.system)
                found = Located(point, *self.points.degenerate(other["kind"], point))
                found_others.append(found)
                yield self._claim(where, f"a degenerate pose: {other['kind']}", *found.finding)
        yield self._sorted(cusps)
        yield from self._counted(found_cusps, found_others)

    def _claim(self, member: str, claim: str, status: ClaimStatus, reason: str) -> Claim:
        return Claim(f"{self.at}/{member}", claim, status, reason)

    def _sorted(self, points: Sequence[Point]) -> Claim:
        status = ClaimStatus.REFUSED
        if sorted_turns([point.theta.value for point in points]):
            status = ClaimStatus.PROVED
        return self._claim("cusps", "the cusps are sorted by angle", status, "as printed")

    def _counted(self, cusps: Sequence[Located], others: Sequence[Located]) -> Iterator[Claim]:
        count = self.part["count"]
        if count != len(cusps):
            yield self._claim("count", "the number of cusps", ClaimStatus.REFUSED, f"{len(cusps)} are listed")
            return
        boxes = [found.box for found in cusps if found.box]
        if any(x.meets(y) for n, x in enumerate(boxes) for y in boxes[:n]):
            reason = "two listed cusps are one pose"
            yield self._claim("cusps", "different cusps", ClaimStatus.REFUSED, reason)
            return
        if any(x.box.meets(y.box) for n, x in enumerate(others) for y in others[:n] if x.box and y.box):
            reason = "two listed poses may be one"
            yield self._claim("degenerate_points", "different poses", ClaimStatus.REFUSED, reason)
            return
        claim = f"these {count} cusps are all"
        eliminant = self._eliminant
        if eliminant is None:
            reason = "the spurious factors do not divide the resultant exactly"
            yield self._claim("count", claim, ClaimStatus.REFUSED, reason)
            return
        yield from self._curves(eliminant)
        if not (eliminant.form or eliminant.rest):
            reason = "J and E share a curve in this slice that is none of alpha = 0 and 180 degrees"
            yield self._claim("count", claim, ClaimStatus.NOT_CHECKED, reason)
            return
        yield from self._certificate(eliminant, [found.point for found in cusps])
        if len(boxes) < len(cusps):
            yield self._claim("count", claim, ClaimStatus.REFUSED, "not every listed cusp is one")
            return
        status, reason = self._complete(eliminant, boxes, others)
        yield self._claim("count", claim, status, reason)

    def _curves(self, eliminant: Eliminant) -> Iterator[Claim]:
        """The listed curves of degenerate poses against the proved ones."""
        others = enumerate(self.part["degenerate_points"])
        listed = {n: x["equation"] for n, x in others if _is_curve(x)}
        claim, curves = "a whole curve of degenerate poses", eliminant.cut.curves
        for n, equation in listed.items():
            right = equation in curves
            status = (
                ClaimStatus.PROVED
                if right
                else ClaimStatus.NOT_CHECKED
                if not eliminant.form
                else ClaimStatus.REFUSED
            )
            reason = "J and E vanish identically on it" if right else "it is not among the proved ones"
            yield self._claim(f"degenerate_points/{n}", claim, status, reason)
        for equation in set(curves) - set(listed.values()):
            reason = f"J and E vanish identically on {equation}, which is not listed"
            yield self._claim("degenerate_points", claim, ClaimStatus.REFUSED, reason)

    def _certificate(self, eliminant: Eliminant, cusps: Sequence[Point]) -> Iterator[Claim]:
        certificate = self.part.get("certificate")
        if certificate is None or "audit" in self.part:
            return
        if not eliminant.form:
            reason = "J and E share a curve, and the eliminant of the rest is not repeated"
            yield self._claim("certificate", "the factors of an eliminant", ClaimStatus.NOT_CHECKED, reason)
            return
        if "full" in certificate:
            yield from full_claims(eliminant, certificate["full"], cusps, f"{self.at}/certificate/full")
        claim = "the factors of the resultant of J and E, with multiplicities"
        listed = sorted(tuple(factor[name] for name in _FACTOR) for factor in certificate["factors"])
        right = listed == sorted(self._factors(eliminant))
        reason = "all spurious factors divide it exactly, and leave these" if right else "they are others"
        status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
        yield self._claim("certificate/factors", claim, status, reason)
        right = certificate["eliminant_degree"] == DEGREE
        claim, reason = "the degree of the eliminant", f"it is {DEGREE}"
        yield self._claim("certificate/eliminant_degree", claim, status_of(right), reason)
        number = eliminant.finite_real_roots
        right = certificate["real_roots"] == number
        reason = "counted by Descartes' rule of signs" if right else f"there are {number}"
        status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
        yield self._claim("certificate/real_roots", "real roots", status, reason)

    def _factors(self, eliminant: Eliminant) -> list[tuple[int, int, str]]:
        here, there = self.system.fixed, self.system.first.number
        spurious = [
            (2, 1, f"L{there}=0"),
            (2, 2, f"leg {here} along A{min(here, there)}A{max(here, there)}"),
            (2, 9, "circular"),
        ]
        return [*spurious, *((degree, m, "cusps") for m, degree in eliminant.shape.items())]

    def _complete(
        self, eliminant: Eliminant, cusps: Sequence[Box], others: Sequence[Located]
    ) -> tuple[ClaimStatus, str]:
        """Whether the listed poses are all in which three or more coalesce."""
        apart = separation(eliminant)
        lines = list(special_lines(self.system, eliminant, apart))
        on_special: set[int] = set()
        doubts = 0
        if any(not any(_on(x.box, line) for line in lines) for x in others if x.box):
            return (
                ClaimStatus.REFUSED,
                "a listed degenerate pose is on no line where the resultant has a multiple root",
            )
        bits = lines[0][0].bits if lines else 1
        angles = {"alpha = 0 deg": Interval.of(0, bits), "alpha = 180 deg": pi(bits)}
        holes = [nearby(angles[curve]) for curve in eliminant.cut.curves]
        for line in lines:
            here = [n for n, box in enumerate(cusps) if _on(box, line)]
            beside = [nearby(x.box.alpha) for x in others if x.box and _on(x.box, line)]
            on_special.update(here)
            for box in (cusps[n] for n in here):
                room = self.points.alone(box)
                beside.append(nearby(box.alpha) if room is None else room)
                doubts += room is None
            doubts += sum(1 for x in others if x.box and _on(x.box, line))
            pose = unlisted(self.system, line, [*holes, *beside], apart)
            if pose is not None:
                about = f"alpha = {float(pose) * 57.29578:.6g} degrees"
                return (
                    ClaimStatus.REFUSED,
                    f"a pose with J = E = 0 near {about}, on a special line, is not listed",
                )
        single = len(eliminant.single_roots)
        if single != len(cusps) - len(on_special):
            listed = len(cusps) - len(on_special)
            return (
                ClaimStatus.REFUSED,
                f"{single} simple real roots of Q have one cusp each, and {listed} are listed",
            )
        if eliminant.cut.curves:
            return ClaimStatus.CHECKED, "no others but within 1e-6 radians of listed poses and curves"
        if doubts:
            return (
                ClaimStatus.CHECKED,
                f"no others but within 1e-6 radians of {doubts} degenerate or close poses",
            )
        return (
            ClaimStatus.PROVED,
            f"Q has {single} simple real roots, one cusp above each; spurious roots have none",
        )


def _on(box: Box, line: Pair) -> bool:
    return all(x.meets(y) for x, y in zip(box.directions.theta, line, strict=True))
