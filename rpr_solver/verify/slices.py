"""One slice of a cusp table: its factors, its cusps, its count."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

from rpr_solver.errors import InputError
from rpr_solver.verify.alike import Located, located
from rpr_solver.verify.angles import pi
from rpr_solver.verify.boxes import Box, Pair
from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.full import full_claims
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.lines import separation, special_lines, unlisted
from rpr_solver.verify.manipulator import Geometry, exact
from rpr_solver.verify.points import Point, Points, read
from rpr_solver.verify.system import System


def slice_claims(
    geometry: Geometry, fixed: int, part: Mapping[str, Any], digits: int, at: str
) -> Iterator[Claim]:
    """All claims of a slice object.

    Raises:
        InputError: naming a member that cannot be read.
    """
    if "error" in part:
        yield Claim(
            at, "the slice has no answer", ClaimStatus.NOT_CHECKED, "an error says nothing about cusps"
        )
        return
    name = f"l{fixed}"
    length = exact(part.get(name), f"{at}/{name}")
    if length <= 0:
        raise InputError.of(f"{at}/{name}", f"is {length}; a leg length must be > 0")
    yield from _Slice(System.of(geometry, fixed, length), part, digits, at).claims()


def _is_curve(point: Mapping[str, Any]) -> bool:
    return point.get("kind") == "curve"


class _Slice:
    def __init__(self, system: System, part: Mapping[str, Any], digits: int, at: str) -> None:
        self.system = system
        self.part = part
        self.digits = digits
        self.at = at
        self.points = Points(system)

    @cached_property
    def _eliminant(self) -> Eliminant | None:
        return Eliminant.if_any(self.system)

    def claims(self) -> Iterator[Claim]:
        cusps = read(self.part.get("cusps"), self.system, f"{self.at}/cusps")
        others = self.part.get("degenerate_points")
        if not isinstance(others, list) or not all(isinstance(x, Mapping) for x in others):
            raise InputError.of(f"{self.at}/degenerate_points", "is not a list of points")
        found_cusps, found_others = located(self.points, cusps, self._eliminant), []
        for n, found in enumerate(found_cusps):
            yield self._claim(f"cusps/{n}", "a cusp with these digits", *found.finding)
        for n, other in enumerate(others):
            if not _is_curve(other):
                where = f"degenerate_points/{n}"
                point = Point.of(other, self.system, f"{self.at}/{where}")
                found = Located(point, *self.points.degenerate(str(other.get("kind")), point))
                found_others.append(found)
                yield self._claim(where, f"a degenerate pose: {other.get('kind')}", *found.finding)
        yield self._form([*cusps, *(found.point for found in found_others)])
        yield from self._counted(found_cusps, found_others)

    def _claim(self, member: str, claim: str, status: ClaimStatus, reason: str) -> Claim:
        return Claim(f"{self.at}/{member}", claim, status, reason)

    def _form(self, points: Sequence[Point]) -> Claim:
        """Digits, ranges and order as documents promise them."""
        claim = f"{self.digits} significant digits, angles in (-180, 180], cusps sorted by angle"
        for point in points:
            if any(not x.is_zero and x.digits != self.digits for x in point.numbers):
                return self._claim("cusps", claim, ClaimStatus.REFUSED, "a number has more or fewer digits")
            if any(not -180 < x.value <= 180 for x in (point.alpha, point.theta)):
                return self._claim("cusps", claim, ClaimStatus.REFUSED, "an angle is outside (-180, 180]")
        thetas = [point.theta.value for point in points[: len(self.part["cusps"])]]
        if thetas != sorted(thetas):
            return self._claim("cusps", claim, ClaimStatus.REFUSED, "the cusps are not sorted")
        return self._claim("cusps", claim, ClaimStatus.PROVED, "as printed")

    def _counted(self, cusps: Sequence[Located], others: Sequence[Located]) -> Iterator[Claim]:
        count = self.part.get("count")
        if count != len(cusps):
            yield self._claim("count", "the number of cusps", ClaimStatus.REFUSED, f"{len(cusps)} are listed")
            return
        boxes = [found.box for found in cusps if found.box]
        if any(x.meets(y) for n, x in enumerate(boxes) for y in boxes[:n]):
            yield self._claim(
                "cusps", "different cusps", ClaimStatus.REFUSED, "two listed cusps are one pose"
            )
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
        if eliminant.form:
            yield from self._certificate(eliminant, [found.point for found in cusps])
        if len(boxes) < len(cusps):
            yield self._claim("count", claim, ClaimStatus.REFUSED, "not every listed cusp is one")
            return
        status, reason = self._complete(eliminant, boxes, others)
        yield self._claim("count", claim, status, reason)

    def _curves(self, eliminant: Eliminant) -> Iterator[Claim]:
        """The listed curves of degenerate poses against the proved ones."""
        others = enumerate(self.part["degenerate_points"])
        listed = {n: x.get("equation") for n, x in others if _is_curve(x)}
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
        if not isinstance(certificate, Mapping):
            return
        if certificate.get("method") == "article":
            claim = "the factors of the article's eliminant, of degree 96"
            reason = "it is not derived by this verifier; the count is proved by another eliminant"
            yield self._claim("certificate", claim, ClaimStatus.NOT_CHECKED, reason)
            return
        if "full" in certificate:
            yield from full_claims(eliminant, certificate["full"], cusps, f"{self.at}/certificate/full")
        claim = "the factors of the resultant of J and E, with multiplicities"
        listed = certificate.get("factors")
        right = sorted(map(str, listed if isinstance(listed, list) else [])) == sorted(
            map(str, self._factors(eliminant))
        )
        reason = "all spurious factors divide it exactly, and leave these" if right else "they are others"
        status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
        yield self._claim("certificate/factors", claim, status, reason)
        numbers = {"eliminant_degree": 24, "real_roots": eliminant.finite_real_roots}
        for name, number in numbers.items():
            right = certificate.get(name) == number
            reason = "counted by Descartes' rule of signs" if name == "real_roots" else "counted"
            yield self._claim(
                f"certificate/{name}",
                name.replace("_", " "),
                ClaimStatus.PROVED if right else ClaimStatus.REFUSED,
                reason if right else f"it is {number}",
            )

    def _factors(self, eliminant: Eliminant) -> list[dict[str, Any]]:
        here, there = self.system.fixed, self.system.first.number
        spurious = [
            (2, 1, f"L{there}=0"),
            (2, 2, f"leg {here} along A{min(here, there)}A{max(here, there)}"),
            (2, 9, "circular"),
        ]
        cusps = [(degree, multiplicity, "cusps") for multiplicity, degree in eliminant.shape.items()]
        names = ("degree", "multiplicity", "origin")
        return [dict(zip(names, row, strict=True)) for row in (*spurious, *cusps)]

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
        holes = [angles[curve] for curve in eliminant.cut.curves]
        for line in lines:
            here = [n for n, box in enumerate(cusps) if _on(box, line)]
            beside = [x.box for x in others if x.box and _on(x.box, line)]
            on_special.update(here)
            boxes = [*(cusps[n] for n in here), *beside]
            doubts += len(boxes)
            pose = unlisted(self.system, line, [*holes, *(box.alpha for box in boxes)], apart)
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
                f"no others but within 1e-6 radians of {doubts} points on special lines",
            )
        return (
            ClaimStatus.PROVED,
            f"Q has {single} simple real roots, one cusp above each; spurious roots have none",
        )


def _on(box: Box, line: Pair) -> bool:
    return all(x.meets(y) for x, y in zip(box.directions.theta, line, strict=True))
