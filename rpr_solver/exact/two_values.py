"""A polynomial over ℤ[ω] from its values at ±2ᵏ, where its coefficients are digits (Kronecker; Harvey 2009).

The value of Res_t of two forms over known factors is one remainder sequence in balls. Two of them take less
time than the coefficients from many values, unless these have thousands of bits. Digits are coefficients
only if those are proved to be short enough (:func:`resultant_bits`, mathematics.md#integers-from-balls).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import comb
from typing import NamedTuple

from flint import arb, ctx, fmpz, fmpz_poly

from rpr_solver.exact.elimination import no_quotient, recovered
from rpr_solver.exact.quadratic import QuadraticPoly

_BOUND_BITS = 64
_LOST = 2
"""How many times k the bits are that a remainder sequence usually loses at 2ᵏ."""
_BYTE = 8


class Size(NamedTuple):
    """What a bound of a resultant needs of a form.

    Attributes:
        degree: in t.
        square: the sum of the squared coefficients of √ρ t and √ρ u, for either sign of ω, or more.
    """

    degree: int
    square: fmpz


def resultant_bits(
    first: Size, second: Size, known: Sequence[QuadraticPoly], divisor: int, degree: int, rho: int
) -> int:
    """Bits of all coefficients of Res_t of two forms, over the product of known factors and a divisor.

    The Mahler measure M is multiplicative. By Hadamard |Res_t| ≤ ‖first‖ⁿ ‖second‖ᵐ at each v on the unit
    circle, with 2-norms in t. The means of their squares on it are the squared 2-norms of the forms, so that
    by Jensen M(Res_t) ≤ ‖first‖ⁿ ‖second‖ᵐ with these. A coefficient of vᵏ is at most M times a binomial.
    All this is used with v = √ρ u and √ρ t, in terms of which forms in half tangents are best conditioned.

    Args:
        first, second: the forms.
        known: factors of the resultant.
        divisor: an integer > 0.
        degree: that of the quotient.
        rho: ρ.
    """
    with ctx.workprec(_BOUND_BITS):
        # the powers of √ρ are those of Res_t in terms of t, and of a coefficient in terms of u
        measure = arb(rho) ** (first.degree * second.degree + degree)
        measure *= arb(first.square) ** second.degree * arb(second.square) ** first.degree
        measure = measure.sqrt() * comb(degree, degree // 2) / divisor
        for factor in known:
            measure /= _least_measure(factor, rho)
        mantissa, exponent = measure.upper().man_exp()
    return max(mantissa.bit_length() + int(exponent), 1)


def _least_measure(p: QuadraticPoly, rho: int) -> arb:
    """A lower bound of M in terms of √ρ u, for either sign of ω: a coefficient over its binomial."""
    degree, least = p.degree, arb(0)
    for k in range(degree + 1):
        a, b = p.a[k], p.b[k]
        size = abs(arb(a))
        if b:
            # of a + ωb and a − ωb neither is less than |a² − ω²b²| over a bound of both
            size = abs(arb(a * a - p.radicand * b * b)) / (size + abs(arb(b)) * arb(p.radicand).sqrt())
        least = max(least, (size / comb(degree, k) / arb(rho).sqrt() ** k).lower())
    return least


def from_two_values(
    radicand: int, degree: int, bits: int, value: Callable[[int], Callable[[arb], arb]]
) -> QuadraticPoly:
    """The polynomial of this degree over ℤ[ω] with coefficients of at most so many bits.

    Args:
        radicand: ω².
        degree: at least that of the polynomial.
        bits: those of A + ω B for either sign of ω.
        value: takes ±2ᵏ, then ω as a ball: that of the value, at the working precision.

    Raises:
        SolverError: there is no such polynomial.
    """
    size = (bits + 1) // _BYTE + 1
    x = 1 << size * _BYTE // 2
    above, below = value(x), value(-x)

    def parts(omega: arb) -> list[arb]:
        first, second = above(omega), below(omega)
        return [(first + second) / 2, (first - second) / (2 * x)]

    a, b = recovered(radicand, parts, size * _BYTE // 2 * (degree + 2 + _LOST))
    return QuadraticPoly(_polynomial(a, size, degree), _polynomial(b, size, degree), radicand)


def _polynomial(parts: Sequence[fmpz], size: int, degree: int) -> fmpz_poly:
    """From the numbers whose digits are the coefficients of even and of odd powers."""
    coefficients = [0] * (degree + 1)
    for k, part in enumerate(parts):
        if part:
            coefficients[k::2] = _digits(int(part), size, len(coefficients[k::2]))
    return fmpz_poly(coefficients)


def _digits(number: int, size: int, count: int) -> list[int]:
    """The digits, of at most half their unit in absolute value, of so many bytes each, the lowest first."""
    half = 1 << size * _BYTE - 1
    halves = int.from_bytes((b"\0" * (size - 1) + b"\x80") * count, "little")
    try:
        data = (number + halves).to_bytes(size * count, "little")
    except OverflowError:
        raise no_quotient() from None
    return [int.from_bytes(data[i : i + size], "little") - half for i in range(0, len(data), size)]
