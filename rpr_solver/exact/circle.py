"""Forms in u = tan φ from their values at equidistant φ, in balls.

A form of degree D in (cos φ, sin φ) is a trigonometric polynomial with the exponents −D, 2 − D, …, D of
exp(iφ), so its values at D + 1 or more equidistant φ of a half circle give it without loss: no other points
are better conditioned. The angles are (1 + πk)/N. Their tangents are transcendental (Lindemann), so no form
with algebraic coefficients vanishes at any of them, unless it is zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

from flint import acb, arb, arb_mat, fmpz_mat, fmpz_poly

T = TypeVar("T", arb, acb)


@dataclass(frozen=True)
class Circle:
    """The N points, at the precision ``bits``, which should be the working precision."""

    count: int
    bits: int

    def monomials(self, degree: int) -> arb_mat:
        """Row k has cosᴰ⁻ᵏ sinᵏ at every point, so that coefficients of uᵏ times this are values."""
        return _monomials(self, degree)

    def coefficients(self, values: Sequence[Sequence[arb]], degree: int) -> list[list[arb]] | None:
        """The coefficients of u⁰ … uᴰ of the forms of degree D < N with these values, a row for each form.

        None if a row cannot be the values of such a form; for that, N must exceed D + 1.
        """
        before, after, turns = _transform(self, degree)
        used: list[list[acb]] = []
        for row in values:
            exponents = acb.dft([x * y for x, y in zip(row, before, strict=True)])
            if not all(x.contains(0) for x in exponents[degree + 1 :]):
                return None
            used.append([x * y for x, y in zip(exponents, after, strict=False)])
        # iᵏ times a sum over the exponents that is real for even k and imaginary for odd k
        real, imaginary = (
            (arb_mat(part) * turns).tolist()
            for part in ([[x.real for x in row] for row in used], [[x.imag for x in row] for row in used])
        )
        parts, signs = (real, imaginary), (1, -1, -1, 1)
        return [[parts[k % 2][i][k] * signs[k % 4] for k in range(degree + 1)] for i in range(len(values))]


@lru_cache(maxsize=4)
def _points(circle: Circle) -> list[acb]:
    """exp(iφ)."""
    n = circle.count
    first, turn = ((acb(0, angle) / n).exp() for angle in (arb(1), arb.pi()))
    return [first * power for power in _powers(turn, n - 1)]


@lru_cache(maxsize=8)
def _monomials(circle: Circle, degree: int) -> arb_mat:
    columns = [(_powers(x.real, degree), _powers(x.imag, degree)) for x in _points(circle)]
    return arb_mat([[c[degree - k] * s[k] for c, s in columns] for k in range(degree + 1)])


@lru_cache(maxsize=4)
def _transform(circle: Circle, degree: int) -> tuple[list[acb], list[acb], arb_mat]:
    """Factors before and after a discrete Fourier transform, and from exponents to powers of u.

    The coefficient of exp(i(2m − D)φ) is the mean of the values times exp(−i(2m − D)φ).
    """
    n = circle.count
    turn, back = (acb(0, arb.pi() * degree) / n).exp(), (acb(0, -2) / n).exp()
    first = (acb(0, degree) / n).exp() / n
    after = [first * power for power in _powers(back, degree)]
    return _powers(turn, n - 1), after, arb_mat(_turns(degree))


def _powers(x: T, top: int) -> list[T]:
    """1, x, …; each from two of half its exponent, lest the radii grow with every step."""
    powers = [x**0, x]
    for k in range(2, top + 1):
        powers.append(powers[k // 2] * powers[(k + 1) // 2])
    return powers[: top + 1]


@lru_cache(maxsize=32)
def _turns(degree: int) -> fmpz_mat:
    """Row m has the coefficients of (1 + y)ᵐ (1 − y)ᴰ⁻ᵐ; with y = iu they are those of exp(i(2m − D)φ)."""
    plus, minus = ([fmpz_poly([1, sign]) ** k for k in range(degree + 1)] for sign in (1, -1))
    return fmpz_mat([(plus[m] * minus[degree - m]).coeffs() for m in range(degree + 1)])
