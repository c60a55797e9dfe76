"""Full certificates: the exact polynomial, the prime, the isolating intervals and the boxes of a slice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from math import gcd, isqrt

from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.core.modular import proves_simple
from rpr_solver.verify.core.printed import Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.roots import real_roots
from rpr_solver.verify.core.surds import ZERO, Poly, Ring, Surd
from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.points import Point


def full_claims(eliminant: Eliminant, full: Record, cusps: Sequence[Point], at: str) -> Iterator[Claim]:
    """The claims of the member ``full`` of a slice's certificate."""
    form = form_of(eliminant.ring, full["polynomial"])
    right = form is not None and proportional(eliminant.ring, form, eliminant.form)
    yield _claim(f"{at}/polynomial", "Q of this slice", right, "a multiple of the quotient derived here")
    place = full["squarefree"]
    if place is not None:
        right = squarefree(eliminant.ring, full["polynomial"], eliminant.finite, place)
        yield _claim(f"{at}/squarefree", "a prime proves Q squarefree", right, "computed modulo it")
    yield isolation_claim(eliminant.ring, eliminant.parts, full["real_roots"], f"{at}/real_roots")
    yield _boxes(full["boxes"], cusps, f"{at}/boxes")


def _claim(at: str, claim: str, right: bool, reason: str) -> Claim:
    status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
    return Claim(at, claim, status, reason if right else "it does not hold")


def _ratio(ring: Ring, polynomial: Record) -> Fraction | None:
    """The document's ω as a multiple of this ring's, None if it is none."""
    if "omega" not in polynomial:
        return Fraction(1)
    square = Fraction(polynomial["omega"], ring.radicand)
    k = Fraction(isqrt(square.numerator), isqrt(square.denominator))
    return k if k * k == square else None


def own_omega(ring: Ring, polynomial: Record, omega: int, prime: int) -> int | None:
    """The image of this ring's ω, where that of the document's is given; None if that is impossible."""
    k = _ratio(ring, polynomial) or Fraction(1)
    if prime < 2 or gcd(k.numerator, prime) > 1:
        return None
    return omega * k.denominator * pow(k.numerator, -1, prime) % prime


def form_of(ring: Ring, polynomial: Record) -> list[Surd] | None:
    """The printed polynomial over this ring, None if it has another square root."""
    a = polynomial["coefficients"]
    b = polynomial.get("omega_coefficients", (0,) * len(a))
    k = _ratio(ring, polynomial)
    if k is None:
        return None
    return [(x * k.denominator, y * k.numerator) for x, y in zip(a, b, strict=True)]


def squarefree(ring: Ring, polynomial: Record, form: Poly, place: Record) -> bool:
    """Whether the prime of a certificate proves that a form has only simple roots."""
    prime = place["prime"]
    own = own_omega(ring, polynomial, place["omega"], prime) if prime < 1 << 64 else None
    return own is not None and proves_simple(ring, form, prime, own)


def proportional(ring: Ring, first: Sequence[Surd], second: Sequence[Surd]) -> bool:
    """Whether two forms of one degree are multiples of each other over ℚ(ω), neither being 0 alone."""
    lead = next((k for k, x in enumerate(second) if x != ZERO), None)
    if lead is None or len(first) != len(second):
        return lead is None and all(x == ZERO for x in first)
    if first[lead] == ZERO:
        return False
    pairs = zip(first, second, strict=True)
    return all(ring.times(x, second[lead]) == ring.times(y, first[lead]) for x, y in pairs)


def isolation_claim(ring: Ring, parts: Mapping[int, Poly], listed: Sequence[Record], at: str) -> Claim:
    """Disjoint intervals, in each of which a factor of its multiplicity changes its sign, and no more.

    Args:
        ring: of the coefficients.
        parts: multiplicity → the product of the finite factors with it; empty for the polynomial 0.
        listed: the intervals of the document.
        at: where they are.
    """
    claim = f"{len(listed)} isolating intervals, and no other real roots"
    if not parts:
        return _claim(at, claim, not listed, "the polynomial is a constant")
    last: Fraction | None = None
    for root in listed:
        low, high, part = root["lower"], root["upper"], parts.get(root["multiplicity"])
        if part is None or low > high or (last is not None and low <= last):
            return _claim(at, claim, False, "")
        signs = [ring.sign(ring.at(part, x)) for x in (low, high)]
        if (low == high and signs[0]) or (low < high and signs[0] * signs[1] >= 0):
            return _claim(at, claim, False, "")
        last = high
    right = len(listed) == sum(len(real_roots(ring, part)) for part in parts.values())
    return _claim(at, claim, right, "each holds a change of sign, and Descartes' rule counts as many")


def _boxes(listed: Sequence[Record], cusps: Sequence[Point], at: str) -> Claim:
    """Each box is that of all numbers that round to the printed ones, which was proved above."""
    expected = [[{"centre": x.text, "radius": _radius(x)} for x in cusp.numbers] for cusp in cusps]
    right = [[dict(side) for side in box.values()] for box in listed] == expected
    return _claim(at, "boxes of the cusps", right, "each holds the numbers with the digits of its cusp")


def _radius(x: Printed) -> str:
    """Half a unit of the last digit as documents print it."""
    mantissa, _, exponent = x.text.partition("e")
    return "0" if x.is_zero else f"5e{int(exponent or 0) - len(mantissa.partition('.')[2]) - 1}"
