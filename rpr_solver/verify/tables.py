"""Cusp tables: of each slice its cusps, its count, its factors, and its full certificate."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property, partial
from math import gcd, isqrt

from rpr_solver.contract import Progress
from rpr_solver.verify.angles import on_shared_curve
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, finding, judged, matching, worked
from rpr_solver.verify.core.numbers import Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.roots import proves_simple, real_roots
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.surds import ZERO, Poly, Ring, Surd, primitive
from rpr_solver.verify.core.system import Surface, System
from rpr_solver.verify.cusps import UNLIMITED, Cusps, Limits, Located, Point, Slice
from rpr_solver.verify.eliminant import DEGREE, Eliminant
from rpr_solver.verify.landmarks import Event, Unclear, on_axis
from rpr_solver.verify.mirrored import nodes, shape_of

_FEW_BITS = 64
_FACTOR = ("degree", "multiplicity", "origin")


def table_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of all slices of a cusp table."""
    slices = document.members["slices"]
    surface = Surface(document.geometry, document.fixed)
    for n, part in enumerate(slices):
        progress(n, len(slices))
        at = f"/slices/{n}"
        if "error" in part:
            reason = "an error says nothing about cusps"
            yield Claim(at, "the slice has no answer", ClaimStatus.NOT_CHECKED, reason)
        else:
            yield from _Part(surface, part, at).claims()
    progress(len(slices), len(slices))


def count_of_shape(surface: Surface, length: Fraction, limits: Limits = UNLIMITED) -> tuple[int, bool] | None:
    """The number of cusps of a slice where the shape of both triangles tells it; None for others."""
    try:
        shape = shape_of(surface)
        return shape.counted(length, limits) if shape else None
    except (Unclear, ZeroDivisionError):
        return None


def slice_at(surface: Surface, length: Fraction) -> Slice:
    """A slice, with the number of its cusps where the shape of both triangles tells it."""
    told = count_of_shape(surface, length)
    return Slice(surface.at(length), told[0] if told else None)


def sorted_turns(angles: Sequence[Fraction]) -> bool:
    """Whether angles in degrees ascend, where one just above −180 is printed as 180 and comes first."""
    first = next((n for n, x in enumerate(angles) if x != 180), 0)
    turned = [Fraction(-180)] * first + list(angles[first:])
    return turned == sorted(turned)


class _Part:
    def __init__(self, surface: Surface, part: Record, at: str) -> None:
        self.surface, self.part, self.at = surface, part, at
        points = enumerate(part["degenerate_points"])
        self.curves = {n: point["equation"] for n, point in points if point["kind"] == "curve"}

    @cached_property
    def slice(self) -> Slice:
        """Its equations."""
        return Slice(self.surface.at(self.part[f"l{self.surface.fixed}"]))

    @property
    def eliminant(self) -> Eliminant:
        """Its lines."""
        return self.slice.eliminant

    @cached_property
    def located(self) -> tuple[list[Located], Cusps]:
        """The listed cusps, and all."""
        return self.slice.located([Point.of(point, self.slice.system) for point in self.part["cusps"]])

    def claims(self) -> Iterator[Claim]:
        count, cusps = self.part["count"], self.part["cusps"]
        for n in range(len(cusps)):
            yield self._worked(
                f"cusps/{n}",
                "a cusp with these digits",
                lambda n=n: self.located[0][n].finding,  # type: ignore[misc]
            )
        fixed = f"theta{self.surface.fixed}_deg"
        right = sorted_turns([point[fixed].value for point in cusps])
        yield judged(f"{self.at}/cusps", "the cusps are sorted by angle", right, "as printed")
        for n in self.curves:
            claim = "a whole curve of degenerate poses"
            yield self._worked(f"degenerate_points/{n}", claim, partial(self._curve, n))
        certificate = self.part.get("certificate")
        if certificate is not None and "audit" not in self.part:
            yield from self._certificate(certificate)
        for n, point in enumerate(self.part["degenerate_points"]):
            if n not in self.curves:
                claim = f"a degenerate pose: {point['kind']}"
                yield self._worked(f"degenerate_points/{n}", claim, partial(self._degenerate, n))
        if count != len(cusps):
            reason = f"{len(cusps)} are listed"
            yield judged(f"{self.at}/count", "the number of cusps", False, "", reason)
        else:
            yield self._worked("count", f"these {count} cusps are all", self._complete)

    def _worked(self, member: str, claim: str, find: Callable[[], Finding]) -> Claim:
        return worked(f"{self.at}/{member}", claim, find)

    def _curve(self, n: int) -> Finding:
        return finding(self.curves[n] in self.eliminant.cut.curves, "J and E vanish identically on it")

    def _degenerate(self, n: int) -> Finding:
        """Whether a listed degenerate pose is at another place in doubt."""
        points = self.part["degenerate_points"]
        if n in self._on_curves:
            if self.slice.area(Point.of(points[n], self.slice.system)) is None:
                return ClaimStatus.REFUSED, "its lengths are wrong"
        elif self._places[n] is None:
            return ClaimStatus.REFUSED, "a cusp is there, or J = E = 0 is excluded"
        if points.count(points[n]) == 1 and exact_poses(self.slice.system, points[n]):
            return (
                ClaimStatus.PROVED,
                "it is degenerate there, exactly; its digits and its kind are right",
            )
        return ClaimStatus.CHECKED, "J = E = 0 is not excluded there; its kind is not repeated"

    @cached_property
    def _on_curves(self) -> list[int]:
        """The listed degenerate poses on a curve of others."""
        curves = self.eliminant.cut.curves
        angles = {0: "alpha = 0 deg", 180: "alpha = 180 deg"}
        points = enumerate(self.part["degenerate_points"])
        return [n for n, x in points if n not in self.curves and angles.get(x["alpha_deg"].value) in curves]

    @cached_property
    def _places(self) -> dict[int, int | None]:
        """The place in doubt of each listed degenerate pose."""
        _, cusps = self.located
        others = {*self.curves, *self._on_curves}
        points = {n: p for n, p in enumerate(self.part["degenerate_points"]) if n not in others}
        areas = [self.slice.area(Point.of(point, self.slice.system)) for point in points.values()]
        chosen = matching(areas, cusps.doubts, lambda area, doubt: area is not None and doubt.meets(area))
        return dict(zip(points, chosen, strict=True))

    def _complete(self) -> Finding:
        """Whether the listed cusps and curves are all."""
        located, cusps = self.located
        number, total = sum(found.box is not None for found in located), len(cusps.boxes) + cusps.missing
        if number < len(located):
            return ClaimStatus.REFUSED, "not every listed cusp is another one"
        if number < total:
            return ClaimStatus.REFUSED, f"there are {total}"
        if unlisted := set(self.eliminant.cut.curves) - set(self.curves.values()):
            return ClaimStatus.REFUSED, f"J and E vanish identically on {min(unlisted)}, which is not listed"
        if len(set(self.curves.values())) < len(self.curves):
            return ClaimStatus.REFUSED, "a curve is listed twice"
        if len([k for k in self._places.values() if k is not None]) < len(cusps.doubts):
            return ClaimStatus.REFUSED, "a pose with J = E = 0 on a special line is not listed"
        known = count_of_shape(self.surface, self.slice.system.length)
        if known is not None:
            special = len(_on_curve(self.slice.system, _FEW_BITS))
            if special != len(self._on_curves):
                return ClaimStatus.REFUSED, f"at {special} poses of the curve both gradients are 0"
            right = number == known[0]
            return finding(right, "the shape of the triangles tells their number", f"there are {known[0]}")
        if self.eliminant.cut.curves:
            return ClaimStatus.CHECKED, "no others but within 1e-6 radians of listed poses and curves"
        if not cusps.complete:
            doubts = len(cusps.doubts) + cusps.close
            reason = f"no others but within 1e-6 radians of {doubts} degenerate or close poses"
            return ClaimStatus.CHECKED, reason
        single = len(self.eliminant.single_roots)
        reason = f"Q has {single} simple real roots, one cusp above each; on special lines are no others"
        return ClaimStatus.PROVED, reason

    def _certificate(self, certificate: Record) -> Iterator[Claim]:
        at = f"{self.at}/certificate"
        if (full := certificate.get("full")) is not None:
            yield from form_claims(f"{at}/full", "Q of this slice", "Q", full, self._form)
            cusps = [[point[name] for name in point] for point in self.part["cusps"]]
            sides = [[{"centre": x.text, "radius": _radius(x)} for x in cusp] for cusp in cusps]
            right = [[dict(side) for side in box.values()] for box in full["boxes"]] == sides
            reason = "each holds the numbers with the digits of its cusp"
            yield judged(f"{at}/full/boxes", "boxes of the cusps", right, reason)
        listed = sorted(tuple(factor[name] for name in _FACTOR) for factor in certificate["factors"])
        claim = "the factors of the resultant of J and E, with multiplicities"
        reason = "all spurious factors divide it exactly, and leave these"
        yield worked(f"{at}/factors", claim, lambda: finding(listed == sorted(self._factors()), reason))
        degree = certificate["eliminant_degree"]
        yield worked(f"{at}/eliminant_degree", "the degree of the eliminant", lambda: self._degree(degree))
        number, by_signs = certificate["real_roots"], "by Descartes' rule of signs"
        yield worked(
            f"{at}/real_roots",
            "real roots",
            lambda: finding(number == self.eliminant.finite_real_roots, by_signs),
        )

    def _form(self) -> Form:
        own = self.eliminant
        return own.ring, own.form or (ZERO,) * (DEGREE + 1), own.parts

    def _degree(self, degree: int) -> Finding:
        right = sum(m * own for m, own in self.eliminant.shape.items())
        return finding(degree == right, f"it is {right}", f"it is {right}")

    def _factors(self) -> list[tuple[int, int, str]]:
        """Those of the resultant, or of that of both quotients if J and E share a curve."""
        system, cusps = self.slice.system, [(n, m, "cusps") for m, n in self.eliminant.shape.items()]
        if not self.eliminant.form:
            return cusps
        here, there = system.fixed, system.legs[0].number
        spurious = [
            (2, 1, f"L{there}=0"),
            (2, 2, f"leg {here} along A{min(here, there)}A{max(here, there)}"),
            (2, 9, "circular"),
        ]
        return [*spurious, *cusps]


def exact_poses(system: System, point: Record) -> list[Event]:
    """The degenerate poses with the kind and the digits of a printed one that are known exactly.

    Those with α = 0 or 180° are known, and where the shape of both triangles tells them.
    """
    surface, own = system.surface, Point.of(point, system)
    bits = 4 * (own.bits + surface.coefficient_bits)
    cos = {Fraction(0): 1, Fraction(180): -1}.get(point["alpha_deg"].value)
    try:
        known = [*nodes(surface, system.length, bits), *_on_curve(system, bits)]
    except (Unclear, ZeroDivisionError):
        known = []
    poses: list[Event] = [*known, *(on_axis(system, cos, bits) if cos else ())]
    alike = [x for x in poses if x.is_like(surface, point)]
    return [x for x in alike if x.exactly(surface, point, "")[0] is ClaimStatus.PROVED]


def _on_curve(system: System, bits: int) -> list[Event]:
    """The poses with both gradients 0 on the curve that J and E share in all slices."""
    shape = shape_of(system.surface)
    return on_shared_curve(shape, system.length, bits) if shape else []


def _radius(x: Printed) -> str:
    """Half a unit of the last digit as documents print it."""
    mantissa, _, exponent = x.text.partition("e")
    return "0" if x.is_zero else f"5e{int(exponent or 0) - len(mantissa.partition('.')[2]) - 1}"


def _ratio(ring: Ring, polynomial: Record) -> Fraction | None:
    """The document's ω as a multiple of this ring's, None if it is none."""
    if "omega" not in polynomial:
        return Fraction(1)
    square = Fraction(polynomial["omega"], ring.radicand)
    k = Fraction(isqrt(square.numerator), isqrt(square.denominator))
    return k if k * k == square else None


def form_of(ring: Ring, polynomial: Record) -> list[Surd] | None:
    """The printed polynomial over this ring, None if it has another square root."""
    a = polynomial["coefficients"]
    b = polynomial.get("omega_coefficients", (0,) * len(a))
    k = _ratio(ring, polynomial)
    if k is None:
        return None
    return [(x * k.denominator, y * k.numerator) for x, y in zip(a, b, strict=True)]


Form = tuple[Ring, Sequence[Surd], Mapping[int, Poly]]
"""A form with its leading zeros, over a ring; multiplicity → the product of its finite factors with it."""


def form_claims(at: str, claim: str, name: str, members: Record, find: Callable[[], Form]) -> Iterator[Claim]:
    """What a full certificate says of a form: its coefficients, simple roots, and isolating intervals."""

    def polynomial() -> Finding:
        ring, own, _ = find()
        form = form_of(ring, members["polynomial"])
        right = form is not None and proportional(ring, form, own)
        return finding(right, "a multiple of the quotient derived here")

    def simple() -> Finding:
        ring, own, parts = find()
        whole = own[-1] != ZERO
        if place is None:  # that primes do not prove it is no proof of the contrary
            right = not whole or max(parts, default=1) > 1
        else:
            right = whole and squarefree(ring, members["polynomial"], primitive(own), place)
        return finding(right, "computed anew")

    def isolated() -> Finding:
        ring, _, parts = find()
        return isolation(ring, parts, roots)

    place, roots = members["squarefree"], members["real_roots"]
    yield worked(f"{at}/polynomial", claim, polynomial)
    text = f"a prime proves {name} squarefree" if place else f"{name} has a multiple root, or one at infinity"
    yield worked(f"{at}/squarefree", text, simple)
    text = f"{len(roots)} isolating intervals, and no other real roots"
    yield worked(f"{at}/real_roots", text, isolated)


def squarefree(ring: Ring, polynomial: Record, form: Poly, place: Record) -> bool:
    """Whether the prime of a certificate proves that a form has only simple roots."""
    prime, k = place["prime"], _ratio(ring, polynomial) or Fraction(1)
    if not 2 < prime < 1 << 64 or gcd(k.numerator, prime) > 1:
        return False
    own = place["omega"] * k.denominator * pow(k.numerator, -1, prime) % prime
    return proves_simple(ring, form, prime, own)


def proportional(ring: Ring, first: Sequence[Surd], second: Sequence[Surd]) -> bool:
    """Whether two forms of one degree are multiples of each other over ℚ(ω), neither being 0 alone."""
    lead = next((k for k, x in enumerate(second) if x != ZERO), None)
    if lead is None or len(first) != len(second):
        return lead is None and all(x == ZERO for x in first)
    if first[lead] == ZERO:
        return False
    pairs = zip(first, second, strict=True)
    return all(ring.times(x, second[lead]) == ring.times(y, first[lead]) for x, y in pairs)


def isolation(ring: Ring, parts: Mapping[int, Poly], listed: Sequence[Record]) -> Finding:
    """Whether intervals are disjoint, in each a factor of its multiplicity changes its sign, and no more.

    Args:
        ring: of the coefficients.
        parts: multiplicity → the product of the finite factors with it; empty for the polynomial 0.
        listed: the intervals of the document.
    """
    if not parts:
        return finding(not listed, "the polynomial is a constant")
    last: Fraction | None = None
    for root in listed:
        low, high, part = root["lower"], root["upper"], parts.get(root["multiplicity"])
        if part is None or low > high or (last is not None and low <= last):
            return finding(False, "")
        signs = [ring.sign(ring.at(part, x)) for x in (low, high)]
        if (low == high and signs[0]) or (low < high and signs[0] * signs[1] >= 0):
            return finding(False, "")
        last = high
    right = len(listed) == sum(len(real_roots(ring, part)) for part in parts.values())
    return finding(right, "each holds a change of sign, and Descartes' rule counts as many")
