"""The eliminant on the unit circle in double precision: guesses of its roots, and proof of those not real.

With z = exp(iθ) = (1 + iu)/(1 − iu) the form Q(u) becomes P(z) = Σ pₘ zᵐ, m = 0 … 24, with p₂₄₋ₘ = conj(pₘ):
real roots u lie on the circle |z| = 1, the others in pairs inside and outside. P is well conditioned there.

A guess decides nothing. What is proved here is how many roots are inside the circle, by discs whose rounding
errors are all bounded (mathematics.md#laguerres-discs); proofs.py proves the real ones. All slices of a
block are done at once, by numpy, which is imported on first use since it takes a tenth of a second.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from flint import arb, ctx, fmpz_mat, fmpz_poly

from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.slices.eliminant import DEGREE_L, DEGREE_U, Eliminant

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Complexes = NDArray[Any]


_UNIT = 2.0**-53
_VALUE_ERROR = 400 * _UNIT
"""Bounds the rounding errors of Horner's rule over the sum of |coefficients|, on the closed disc."""
_COEFFICIENT_ERROR = 40 * _UNIT
"""Bounds the rounding errors of a coefficient over the sum of its absolute terms in L."""
_UP = 1 + 2.0**-40
"""Bounds the roundings of the few operations that follow."""
_LEAST_SUM = 2.0**-400
"""Above it, what underflows is far below the other errors."""
_POLISHINGS = 2


@dataclass(frozen=True)
class Guess:
    """What is known of the roots of one slice.

    Attributes:
        real: guesses of the real roots u, each as (numerator, denominator) of tan(θ/2).
        inside: a proved lower bound of the number of roots inside the circle.
    """

    real: tuple[tuple[float, float], ...]
    inside: int


def guesses(eliminant: Eliminant, lengths: Sequence[Fraction]) -> list[Guess]:
    """Guesses for slices of *scaled* lengths, all at once."""
    import numpy as np

    exponent = length_exponent(lengths)
    if ("circle", exponent) not in eliminant.kept:
        eliminant.kept["circle", exponent] = _matrices(np, eliminant, exponent)
    circle, line = eliminant.kept["circle", exponent]
    relative = np.array([float_of(x, exponent) for x in lengths])
    with np.errstate(all="ignore"):
        u = _roots_on_the_line(np, _at(line, relative))
        p = _at(circle.real, relative), _at(circle.imag, relative)
        sums = _at(abs(circle.real) + abs(circle.imag), relative)  # bounds each |coefficient| and its terms
        z = _polished(np, p[0] + 1j * p[1], (1 + 1j * u) / (1 - 1j * u))
        # those inside first; there are at most twelve, since the others are their mirror images
        order = np.argsort(u.imag <= 0, axis=1, kind="stable")[:, : DEGREE_U // 2]
        first, upper = (np.take_along_axis(x, order, axis=1) for x in (z, u.imag > 0))
        inside = disjoint_discs_inside(np, p, sums, first, upper)
        # tan(θ/2) = sin/(1 + cos) = (1 − cos)/sin, whichever holds no cancellation
        left = z.real < 0
        numerator = np.where(left, 1 - z.real, z.imag)
        denominator = np.where(left, z.imag, 1 + z.real)
    return [
        Guess(tuple(zip(n[real].tolist(), d[real].tolist(), strict=True)), int(proved))
        for n, d, real, proved in zip(numerator, denominator, u.imag == 0, inside, strict=True)
    ]


def length_exponent(lengths: Sequence[Fraction]) -> int:
    """A number such that all L / 2^exponent are below 1."""
    return max(x.numerator.bit_length() - x.denominator.bit_length() for x in lengths) + 1


def float_of(x: Fraction, exponent: int) -> float:
    """x / 2^exponent, rounded to nearest."""
    n, d = x.numerator, x.denominator
    return n / (d << exponent) if exponent > 0 else (n << -exponent) / d


def disjoint_discs_inside(
    np: Any, p: tuple[Doubles, Doubles], sums: Doubles, z: Complexes, chosen: NDArray[Any]
) -> NDArray[Any]:
    """The number of chosen points of each slice, if their discs are disjoint and inside the circle; else 0.

    Args:
        np: numpy.
        p: real and imaginary parts of the coefficients, a row for each slice.
        sums: for each coefficient a bound of the sum of its absolute terms in L.
        z: points, a row for each slice.
        chosen: the points that should be near roots inside the circle.

    The disc of z has the radius 24 |P/P′| and so holds a root. Only sums, products, quotients and square
    roots of real doubles are used, each of which IEEE 754 rounds correctly.
    """
    x, y = z.real, z.imag
    orders = np.arange(DEGREE_U + 1.0)
    value = _horner(np, p, x, y)
    slope = _horner(np, (p[0][:, 1:] * orders[1:], p[1][:, 1:] * orders[1:]), x, y)
    total, weighted = sums.sum(axis=1), (sums * orders).sum(axis=1)
    error = (_VALUE_ERROR + _COEFFICIENT_ERROR) * _UP
    above = (_modulus(np, *value) + error * total[:, None]) * _UP
    below = _modulus(np, *slope) * (2 - _UP) - error * weighted[:, None] * _UP
    radius = DEGREE_U * (above / below) * _UP
    distance = _modulus(np, x, y)
    good = (below > 0) & ((distance + radius) * _UP < 1) & (total[:, None] > _LEAST_SUM)
    gap = _modulus(np, x[:, :, None] - x[:, None, :], y[:, :, None] - y[:, None, :])
    apart = gap * (2 - _UP) > (radius[:, :, None] + radius[:, None, :]) * _UP
    both = chosen[:, :, None] & chosen[:, None, :] & ~np.eye(z.shape[1], dtype=bool)
    proved = (good | ~chosen).all(axis=1) & (apart | ~both).all(axis=(1, 2))
    return np.where(proved, chosen.sum(axis=1), 0)  # type: ignore[no-any-return]


def _modulus(np: Any, x: Doubles, y: Doubles) -> Doubles:
    return np.sqrt(x * x + y * y)  # type: ignore[no-any-return]


def _horner(np: Any, p: tuple[Doubles, Doubles], x: Doubles, y: Doubles) -> tuple[Doubles, Doubles]:
    """The values at x + iy, real and imaginary parts, by real operations alone."""
    real, imaginary = np.zeros_like(x), np.zeros_like(x)
    for a, b in zip(p[0].T[::-1, :, None], p[1].T[::-1, :, None], strict=True):
        real, imaginary = real * x - imaginary * y + a, real * y + imaginary * x + b
    return real, imaginary


def _at(coefficients: Doubles, relative: Doubles) -> Doubles:
    """Polynomials in L, a row of coefficients each, at several L: a row for each L."""
    value = coefficients[None, :, -1] * 1.0
    for k in range(DEGREE_L - 1, -1, -1):
        value = value * relative[:, None] + coefficients[None, :, k]
    return value


def _polished(np: Any, p: Complexes, z: Complexes) -> Complexes:
    for _ in range(_POLISHINGS):
        value, slope = np.zeros_like(z), np.zeros_like(z)
        for c in p.T[::-1, :, None]:
            slope, value = slope * z + value, value * z + c
        step = value / slope
        z = np.where(np.isfinite(step), z - step, z)
    return z


def _roots_on_the_line(np: Any, q: Doubles) -> Complexes:
    """The roots u as eigenvalues of companion matrices; nan where there are none."""
    top = -q[:, -2::-1] / q[:, -1:]
    finite = np.isfinite(top).all(axis=1)
    companions = np.zeros((len(q), DEGREE_U, DEGREE_U))
    companions[:, np.arange(1, DEGREE_U), np.arange(DEGREE_U - 1)] = 1
    companions[finite, 0, :] = top[finite]
    roots = np.full((len(q), DEGREE_U), np.nan + 0j)
    with suppress(np.linalg.LinAlgError):  # then there are no guesses
        roots[finite] = np.linalg.eigvals(companions[finite])
    return roots  # type: ignore[no-any-return]


def _matrices(np: Any, eliminant: Eliminant, exponent: int) -> tuple[Complexes, Doubles]:
    """The coefficients of P and of Q by powers of L / 2^exponent, each right to two units of the last place.

    Rows are powers of z or u, columns powers of L. All are divided by one number, the greatest of them.
    """
    pairs = [(part * eliminant.a, part * eliminant.b) for part in _change_of_basis()]
    pairs.append((eliminant.a, eliminant.b))
    size = max(abs(x).bit_length() for pair in pairs for part in pair for x in part.entries())
    # |A + ωB| |A − ωB| ≥ 1 for each number that is not 0, so a hundred bits of it are right
    radicand = eliminant.slice_map.radicand
    bits = 2 * (size + radicand.bit_length()) + 128
    with ctx.workprec(bits):
        units = [arb(2) ** (exponent * k) for k in range(DEGREE_L + 1)] * (DEGREE_U + 1)
        omega = omega_ball(radicand, bits)
        tables = [
            [(x + omega * y) * unit for x, y, unit in zip(a.entries(), b.entries(), units, strict=True)]
            for a, b in pairs
        ]
        top = max(abs(x.mid()) for table in tables for x in table)
        floats = [[float(x / top) for x in table] for table in tables]
    real, imaginary, line = (np.array(table).reshape(DEGREE_U + 1, DEGREE_L + 1) for table in floats)
    return real + 1j * imaginary, line


@lru_cache(maxsize=1)
def _change_of_basis() -> tuple[fmpz_mat, fmpz_mat]:
    """The matrices from the coefficients of Q to the real and imaginary parts of those of P.

    u = −i (z − 1)/(z + 1), so uᵏ (z + 1)²⁴ is (−i)ᵏ (z − 1)ᵏ (z + 1)²⁴⁻ᵏ.
    """
    columns = [fmpz_poly([-1, 1]) ** k * fmpz_poly([1, 1]) ** (DEGREE_U - k) for k in range(DEGREE_U + 1)]
    sizes = range(DEGREE_U + 1)
    real = [[columns[k][m] * (1, 0, -1, 0)[k % 4] for k in sizes] for m in sizes]
    imaginary = [[columns[k][m] * (0, -1, 0, 1)[k % 4] for k in sizes] for m in sizes]
    return fmpz_mat(real), fmpz_mat(imaginary)
