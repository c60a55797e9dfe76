"""Full certificates: the exact polynomial, the prime, the isolating intervals and the boxes of a slice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from math import isqrt
from typing import Any

from rpr_solver.errors import InputError
from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.manipulator import exact
from rpr_solver.verify.modular import proves_simple
from rpr_solver.verify.points import Point
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.roots import real_roots
from rpr_solver.verify.surds import ZERO, Poly, Ring, Surd


def full_claims(
    eliminant: Eliminant, full: Mapping[str, Any], cusps: Sequence[Point], at: str
) -> Iterator[Claim]:
    """The claims of the member ``full`` of a slice's certificate.

    Raises:
        InputError: naming a member that cannot be read.
    """
    form = form_of(eliminant.ring, full["polynomial"], f"{at}/polynomial")
    right = form is not None and proportional(eliminant.ring, form, eliminant.form)
    yield _claim(f"{at}/polynomial", "Q of this slice", right, "a multiple of the quotient derived here")
    place = full["squarefree"]
    if place is not None:
        prime, omega = (int(exact(place[name], f"{at}/squarefree/{name}")) for name in ("prime", "omega"))
        own = own_omega(eliminant.ring, full["polynomial"], omega, prime)
        right = proves_simple(eliminant.ring, eliminant.finite, prime, own)
        yield _claim(f"{at}/squarefree", "a prime proves Q squarefree", right, "computed modulo it")
    yield isolation_claim(eliminant.ring, eliminant.parts, full["real_roots"], f"{at}/real_roots")
    yield _boxes(full["boxes"], cusps, f"{at}/boxes")


def _claim(at: str, claim: str, right: bool, reason: str) -> Claim:
    status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
    return Claim(at, claim, status, reason if right else "it does not hold")


def _radicand(polynomial: Mapping[str, Any]) -> Fraction:
    text = str(polynomial.get("omega", "sqrt(1)"))
    return exact(text.removeprefix("sqrt(").removesuffix(")"), "omega")


def _ratio(ring: Ring, polynomial: Mapping[str, Any]) -> Fraction | None:
    """The document's ω as a multiple of this ring's, None if it is none."""
    if "omega" not in polynomial:
        return Fraction(1)
    square = _radicand(polynomial) / ring.radicand
    k = Fraction(isqrt(square.numerator), isqrt(square.denominator)) if square > 0 else Fraction(0)
    return k if k * k == square else None


def own_omega(ring: Ring, polynomial: Mapping[str, Any], omega: int, prime: int) -> int:
    """The image of this ring's ω, where that of the document's is given.

    Raises:
        InputError: the prime divides the radicand.
    """
    k = _ratio(ring, polynomial) or Fraction(1)
    if k.numerator % prime == 0:
        raise InputError.of("squarefree", "the prime divides the radicand")
    return omega * k.denominator * pow(k.numerator, -1, prime) % prime


def form_of(ring: Ring, polynomial: Mapping[str, Any], at: str) -> list[Surd] | None:
    """The printed polynomial over this ring, None if it has another square root.

    Raises:
        InputError: a coefficient is no number.
    """
    a = [int(exact(x, at)) for x in polynomial["coefficients"]]
    b = [int(exact(x, at)) for x in polynomial.get("omega_coefficients", [0] * len(a))]
    k = _ratio(ring, polynomial)
    if k is None or len(a) != len(b):
        return None
    return [(x * k.denominator, y * k.numerator) for x, y in zip(a, b, strict=True)]


def proportional(ring: Ring, first: Sequence[Surd], second: Sequence[Surd]) -> bool:
    """Whether two forms of one degree are multiples of each other over ℚ(ω), neither being 0 alone."""
    lead = next((k for k, x in enumerate(second) if x != ZERO), None)
    if lead is None or len(first) != len(second):
        return lead is None and all(x == ZERO for x in first)
    if first[lead] == ZERO:
        return False
    pairs = zip(first, second, strict=True)
    return all(ring.times(x, second[lead]) == ring.times(y, first[lead]) for x, y in pairs)


def isolation_claim(
    ring: Ring, parts: Mapping[int, Poly], listed: Sequence[Mapping[str, Any]], at: str
) -> Claim:
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
        low, high = (exact(root[end], f"{at}/{end}") for end in ("lower", "upper"))
        part = parts.get(root["multiplicity"])
        if part is None or low > high or (last is not None and low <= last):
            return _claim(at, claim, False, "")
        signs = [ring.sign(ring.at(part, x)) for x in (low, high)]
        if (low == high and signs[0]) or (low < high and signs[0] * signs[1] >= 0):
            return _claim(at, claim, False, "")
        last = high
    right = len(listed) == sum(len(real_roots(ring, part)) for part in parts.values())
    return _claim(at, claim, right, "each holds a change of sign, and Descartes' rule counts as many")


def _boxes(listed: Sequence[Mapping[str, Any]], cusps: Sequence[Point], at: str) -> Claim:
    """Each box holds its printed cusp to within half a unit, which was proved above."""
    right = len(listed) == len(cusps)
    for box, cusp in zip(listed, cusps, strict=False):
        for (name, side), printed in zip(box.items(), cusp.numbers, strict=False):
            centre = Printed.of(side["centre"], f"{at}/{name}/centre")
            radius = exact(side["radius"], f"{at}/{name}/radius")
            right = right and abs(centre.value - printed.value) + printed.half <= radius
        right = right and len(box) == len(cusp.numbers)
    return _claim(at, "boxes of the cusps", right, "each holds its cusp with all its digits")
