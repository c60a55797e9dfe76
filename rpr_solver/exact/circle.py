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
        columns = arb_mat([list(row) for row in values]).transpose()
        inverse, excess = _inverse(self, degree)
        if not all(x.contains(0) for x in (excess * columns).entries()):
            return None
        return (inverse * columns).transpose().tolist()


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
def _inverse(circle: Circle, degree: int) -> tuple[arb_mat, arb_mat]:
    """From values to the coefficients of u⁰ … uᴰ, and to those of the exponents beyond D."""
    n, parity = circle.count, degree % 2
    # exp(ijφ), j = D mod 2, then in steps of 2 beyond D to all that are different at the points
    powers = [_powers(x, n) for x in _points(circle)]
    rows = [[column[j] for column in powers] for j in range(parity, n + 1, 2)]
    cosines, sines = ([[x.real for x in row] for row in rows], [[x.imag for x in row] for row in rows])
    top = degree // 2 + 1
    # exponents −D, 2 − D, …, D: opposite ones have conjugate coefficients
    below = range(top - 1, -parity, -1)
    real = arb_mat([cosines[k] for k in below] + cosines[:top])
    imaginary = arb_mat([[-x for x in sines[k]] for k in below] + sines[:top])
    turns = arb_mat(_turns(degree)) / n
    sums = [(turns * part).tolist() for part in (real, imaginary)]
    # iᵏ times a sum that is real for even k and imaginary for odd k
    signs = (1, 1, -1, -1)
    inverse = [[x * signs[k % 4] for x in sums[k % 2][k]] for k in range(degree + 1)]
    excess = cosines[top:] + sines[top:]
    return arb_mat(inverse), arb_mat(excess) if excess else arb_mat(0, n)


def _powers(x: T, top: int) -> list[T]:
    """1, x, …; each from two of half its exponent, lest the radii grow with every step."""
    powers = [x**0, x]
    for k in range(2, top + 1):
        powers.append(powers[k // 2] * powers[(k + 1) // 2])
    return powers[: top + 1]


@lru_cache(maxsize=32)
def _turns(degree: int) -> fmpz_mat:
    """Column m has the coefficients of (1 + y)ᵐ (1 − y)ᴰ⁻ᵐ."""
    plus, minus = ([fmpz_poly([1, sign]) ** k for k in range(degree + 1)] for sign in (1, -1))
    columns = [(plus[m] * minus[degree - m]).coeffs() for m in range(degree + 1)]
    return fmpz_mat([[column[k] for column in columns] for k in range(degree + 1)])
