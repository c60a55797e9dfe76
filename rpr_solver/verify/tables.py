"""Cusp tables: of each slice its cusps, its count, its factors, and its full certificate."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
from fractions import Fraction
from math import gcd, isqrt

from rpr_solver.contract import Progress
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, judged, matching
from rpr_solver.verify.core.numbers import Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.roots import proves_simple, real_roots, simple_and_apart
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.surds import ONE, ZERO, Poly, Ring, Surd, primitive
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Cusps, Point, Slice
from rpr_solver.verify.eliminant import DEGREE, Eliminant

_FACTOR = ("degree", "multiplicity", "origin")


def table_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of all slices of a cusp table."""
    slices = document.members["slices"]
    surface = Surface.of(document.geometry, document.fixed)
    for n, part in enumerate(slices):
        progress(n, len(slices))
        at = f"/slices/{n}"
        if "error" in part:
            reason = "an error says nothing about cusps"
            yield Claim(at, "the slice has no answer", ClaimStatus.NOT_CHECKED, reason)
        else:
            yield from _Part(Slice(surface.at(part[f"l{document.fixed}"])), part, at).claims()
    progress(len(slices), len(slices))


def sorted_turns(angles: Sequence[Fraction]) -> bool:
    """Whether angles in degrees ascend, where one just above −180 is printed as 180 and comes first."""
    first = next((n for n, x in enumerate(angles) if x != 180), 0)
    turned = [Fraction(-180)] * first + list(angles[first:])
    return turned == sorted(turned)


class _Part:
    def __init__(self, solved: Slice, part: Record, at: str) -> None:
        self.slice, self.part, self.at = solved, part, at

    def claims(self) -> Iterator[Claim]:
        count, eliminant = self.part["count"], self.slice.eliminant
        claim = f"these {count} cusps are all"
        if eliminant is None or not (eliminant.form or eliminant.rest):
            reason = "J and E share a curve in this slice that is none of alpha = 0 and 180 degrees"
            yield self._claim("count", claim, ClaimStatus.NOT_CHECKED, reason)
            return
        printed = [Point.of(point, self.slice.system) for point in self.part["cusps"]]
        located, cusps = self.slice.located(printed)
        for n, found in enumerate(located):
            yield self._claim(f"cusps/{n}", "a cusp with these digits", *found.finding)
        right = sorted_turns([point.theta.value for point in printed])
        yield judged(f"{self.at}/cusps", "the cusps are sorted by angle", right, "as printed")
        yield from self._curves(eliminant)
        certificate = self.part.get("certificate")
        if certificate is not None and "audit" not in self.part:
            yield from self._certificate(eliminant, certificate, printed)
        doubtful = yield from self._degenerate(cusps)
        number = sum(found.box is not None for found in located)
        if count != len(printed):
            reason = f"{len(printed)} are listed"
            yield self._claim("count", "the number of cusps", ClaimStatus.REFUSED, reason)
        elif number < count:
            yield self._claim("count", claim, ClaimStatus.REFUSED, "not every listed cusp is another one")
        else:
            status, reason = self._complete(eliminant, cusps, number, doubtful)
            yield self._claim("count", claim, status, reason)

    def _claim(self, member: str, claim: str, status: ClaimStatus, reason: str) -> Claim:
        return Claim(f"{self.at}/{member}", claim, status, reason)

    def _degenerate(self, cusps: Cusps) -> Generator[Claim, None, bool]:
        """Each listed degenerate pose is at another place in doubt; returns whether one in doubt is left."""
        points = [
            (n, point) for n, point in enumerate(self.part["degenerate_points"]) if point["kind"] != "curve"
        ]
        areas = [self.slice.area(Point.of(point, self.slice.system)) for _, point in points]
        fits = [
            [k for k, doubt in enumerate(cusps.doubts) if area is not None and doubt.meets(area)]
            for area in areas
        ]
        chosen = matching(fits)
        for (n, point), k in zip(points, chosen, strict=True):
            status, reason = ClaimStatus.CHECKED, "J = E = 0 is not excluded there; its kind is not repeated"
            if k is None:
                status, reason = ClaimStatus.REFUSED, "a cusp is there, or J = E = 0 is excluded"
            yield self._claim(f"degenerate_points/{n}", f"a degenerate pose: {point['kind']}", status, reason)
        return len([k for k in chosen if k is not None]) < len(cusps.doubts)

    def _complete(self, eliminant: Eliminant, cusps: Cusps, number: int, doubtful: bool) -> Finding:
        """Whether the listed cusps are all."""
        total = len(cusps.boxes) + cusps.missing
        if number < total:
            return ClaimStatus.REFUSED, f"there are {total}"
        if doubtful:
            return ClaimStatus.REFUSED, "a pose with J = E = 0 on a special line is not listed"
        if eliminant.cut.curves:
            return ClaimStatus.CHECKED, "no others but within 1e-6 radians of listed poses and curves"
        if not cusps.complete:
            doubts = len(cusps.doubts) + cusps.close
            reason = f"no others but within 1e-6 radians of {doubts} degenerate or close poses"
            return ClaimStatus.CHECKED, reason
        single = len(eliminant.single_roots)
        reason = f"Q has {single} simple real roots, one cusp above each; on special lines are no others"
        return ClaimStatus.PROVED, reason

    def _curves(self, eliminant: Eliminant) -> Iterator[Claim]:
        """The listed curves of degenerate poses against the proved ones."""
        others = enumerate(self.part["degenerate_points"])
        listed = {n: x["equation"] for n, x in others if x["kind"] == "curve"}
        claim, curves = "a whole curve of degenerate poses", eliminant.cut.curves
        for n, equation in listed.items():
            reason = "J and E vanish identically on it"
            yield judged(f"{self.at}/degenerate_points/{n}", claim, equation in curves, reason)
        for equation in set(curves) - set(listed.values()):
            reason = f"J and E vanish identically on {equation}, which is not listed"
            yield self._claim("degenerate_points", claim, ClaimStatus.REFUSED, reason)

    def _certificate(
        self, eliminant: Eliminant, certificate: Record, cusps: Sequence[Point]
    ) -> Iterator[Claim]:
        if not eliminant.form:
            reason = "J and E share a curve, and the eliminant of the rest is not repeated"
            yield self._claim("certificate", "the factors of an eliminant", ClaimStatus.NOT_CHECKED, reason)
            return
        at, ring = f"{self.at}/certificate", eliminant.ring
        if "full" in certificate:
            full = certificate["full"]
            form = form_of(ring, full["polynomial"])
            right = form is not None and proportional(ring, form, eliminant.form)
            reason = "a multiple of the quotient derived here"
            yield judged(f"{at}/full/polynomial", "Q of this slice", right, reason)
            yield simple_claim(ring, full, eliminant.form, "Q", f"{at}/full")
            yield isolation_claim(ring, eliminant.parts, full["real_roots"], f"{at}/full/real_roots")
            sides = [[{"centre": x.text, "radius": _radius(x)} for x in cusp.numbers] for cusp in cusps]
            right = [[dict(side) for side in box.values()] for box in full["boxes"]] == sides
            reason = "each holds the numbers with the digits of its cusp"
            yield judged(f"{at}/full/boxes", "boxes of the cusps", right, reason)
        listed = sorted(tuple(factor[name] for name in _FACTOR) for factor in certificate["factors"])
        claim = "the factors of the resultant of J and E, with multiplicities"
        reason = "all spurious factors divide it exactly, and leave these"
        yield judged(f"{at}/factors", claim, listed == sorted(self._factors(eliminant)), reason)
        right = certificate["eliminant_degree"] == DEGREE
        yield judged(f"{at}/eliminant_degree", "the degree of the eliminant", right, f"it is {DEGREE}")
        right, reason = (
            certificate["real_roots"] == eliminant.finite_real_roots,
            "by Descartes' rule of signs",
        )
        yield judged(f"{at}/real_roots", "real roots", right, reason)

    def _factors(self, eliminant: Eliminant) -> list[tuple[int, int, str]]:
        system = self.slice.system
        here, there = system.fixed, system.legs[0].number
        spurious = [
            (2, 1, f"L{there}=0"),
            (2, 2, f"leg {here} along A{min(here, there)}A{max(here, there)}"),
            (2, 9, "circular"),
        ]
        return [*spurious, *((degree, m, "cusps") for m, degree in eliminant.shape.items())]


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


def simple(name: str, place: Record | None) -> str:
    """What a prime, or null in its place, claims of a polynomial."""
    return f"a prime proves {name} squarefree" if place else f"{name} has a multiple root, or one at infinity"


def simple_claim(ring: Ring, members: Record, form: Sequence[Surd], name: str, at: str) -> Claim:
    """That the prime of a certificate proves that a form has only simple roots, or that it has others."""
    finite, place = primitive(form), members["squarefree"]
    if place is None:
        right = len(finite) < len(form) or not simple_and_apart(ring, finite, (ONE,))
    else:
        right = squarefree(ring, members["polynomial"], finite, place)
    return judged(f"{at}/squarefree", simple(name, place), right, "computed anew")


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


def isolation(listed: Sequence[Record]) -> str:
    """What a list of intervals claims."""
    return f"{len(listed)} isolating intervals, and no other real roots"


def isolation_claim(ring: Ring, parts: Mapping[int, Poly], listed: Sequence[Record], at: str) -> Claim:
    """Disjoint intervals, in each of which a factor of its multiplicity changes its sign, and no more.

    Args:
        ring: of the coefficients.
        parts: multiplicity → the product of the finite factors with it; empty for the polynomial 0.
        listed: the intervals of the document.
        at: where they are.
    """
    claim = isolation(listed)
    if not parts:
        return judged(at, claim, not listed, "the polynomial is a constant")
    last: Fraction | None = None
    for root in listed:
        low, high, part = root["lower"], root["upper"], parts.get(root["multiplicity"])
        if part is None or low > high or (last is not None and low <= last):
            return judged(at, claim, False, "")
        signs = [ring.sign(ring.at(part, x)) for x in (low, high)]
        if (low == high and signs[0]) or (low < high and signs[0] * signs[1] >= 0):
            return judged(at, claim, False, "")
        last = high
    right = len(listed) == sum(len(real_roots(ring, part)) for part in parts.values())
    return judged(at, claim, right, "each holds a change of sign, and Descartes' rule counts as many")
