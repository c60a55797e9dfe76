"""What doubles prove of many slices at once: how many roots are not real, and a pose above each other one.

With z = exp(iθ) = (1 + iu)/(1 − iu) the form Q(u) becomes P(z) = Σ pₘ zᵐ, m = 0 … 24, with p₂₄₋ₘ = conj(pₘ):
real roots u lie on the circle |z| = 1, the others in pairs inside and outside. P is well conditioned there.
A guess decides nothing. What is proved is how many roots are inside the circle, by discs whose rounding
errors are all bounded (mathematics.md#laguerres-discs).

With bounds of every rounding error (poses.py), Krawczyk's test shows that a box round the guess of a pose
holds just one with J = E = 0, and that it is not spurious (mathematics.md#poses-by-floats). What is not
proved here is left to the reference, with its whole slice.

All slices of a block are done at once, by numpy.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from flint import arb, ctx, fmpz_mat, fmpz_poly

from rpr_solver.boxes.krawczyk import contracts
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.legs import PoseDerivatives, singularity_and_coalescence, turns
from rpr_solver.slices.eliminant import DEGREE_L, DEGREE_U, Eliminant
from rpr_solver.slices.fast.poses import (
    Bounded,
    DoubleMap,
    GuessedPoses,
    HalfAngles,
    float_of,
    length_exponent,
    map_exponent,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.slices.fast.poses import Flags, Floats

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
"""Newton steps on the circle, from eigenvalues that are right to a few digits less than doubles have."""
_CIRCLE_ERROR = 8
"""Units that bound the rounding errors of a cosine and a sine by half tangents."""
_WIDEST = 2.0**-24
"""The greatest radius of a box."""
_STEEPEST = 2.0**200
"""Bounds the inverse of the gradients, lest it make something of what underflows."""
_SAFE = 1 + 2.0**-20
"""Bounds the roundings of the few operations that follow, and what is of second order in a radius."""
_DUST = 2.0**-600
"""Far above what underflows, and far below all else."""
_TO_DOUBLE = 2.0**-53


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
    exponent = length_exponent(lengths)
    if ("circle", exponent) not in eliminant.kept:
        eliminant.kept["circle", exponent] = _matrices(eliminant, exponent)
    circle, line = eliminant.kept["circle", exponent]
    relative = np.array([float_of(x, exponent) for x in lengths])
    with np.errstate(all="ignore"):
        u = _roots_on_the_line(_at(line, relative))
        p = _at(circle.real, relative), _at(circle.imag, relative)
        sums = _at(abs(circle.real) + abs(circle.imag), relative)  # bounds each |coefficient| and its terms
        z = _polished(p[0] + 1j * p[1], (1 + 1j * u) / (1 - 1j * u))
        # those inside first; there are at most twelve, since the others are their mirror images
        order = np.argsort(u.imag <= 0, axis=1, kind="stable")[:, : DEGREE_U // 2]
        first, upper = (np.take_along_axis(x, order, axis=1) for x in (z, u.imag > 0))
        inside = disjoint_discs_inside(p, sums, first, upper)
        # tan(θ/2) = sin/(1 + cos) = (1 − cos)/sin, whichever holds no cancellation
        left = z.real < 0
        numerator = np.where(left, 1 - z.real, z.imag)
        denominator = np.where(left, z.imag, 1 + z.real)
    return [
        Guess(tuple(zip(n[real].tolist(), d[real].tolist(), strict=True)), int(proved))
        for n, d, real, proved in zip(numerator, denominator, u.imag == 0, inside, strict=True)
    ]


def disjoint_discs_inside(
    p: tuple[Doubles, Doubles], sums: Doubles, z: Complexes, chosen: NDArray[Any]
) -> NDArray[Any]:
    """The number of chosen points of each slice, if their discs are disjoint and inside the circle; else 0.

    Args:
        p: real and imaginary parts of the coefficients, a row for each slice.
        sums: for each coefficient a bound of the sum of its absolute terms in L.
        z: points, a row for each slice.
        chosen: the points that should be near roots inside the circle.

    The disc of z has the radius 24 |P/P′| and so holds a root. Only sums, products, quotients and square
    roots of real doubles are used, each of which IEEE 754 rounds correctly.
    """
    x, y = z.real, z.imag
    orders = np.arange(DEGREE_U + 1.0)
    value = _horner(p, x, y)
    slope = _horner((p[0][:, 1:] * orders[1:], p[1][:, 1:] * orders[1:]), x, y)
    total, weighted = sums.sum(axis=1), (sums * orders).sum(axis=1)
    error = (_VALUE_ERROR + _COEFFICIENT_ERROR) * _UP
    above = (_modulus(*value) + error * total[:, None]) * _UP
    below = _modulus(*slope) * (2 - _UP) - error * weighted[:, None] * _UP
    radius = DEGREE_U * (above / below) * _UP
    distance = _modulus(x, y)
    good = (below > 0) & ((distance + radius) * _UP < 1) & (total[:, None] > _LEAST_SUM)
    gap = _modulus(x[:, :, None] - x[:, None, :], y[:, :, None] - y[:, None, :])
    apart = gap * (2 - _UP) > (radius[:, :, None] + radius[:, None, :]) * _UP
    both = chosen[:, :, None] & chosen[:, None, :] & ~np.eye(z.shape[1], dtype=bool)
    proved = (good | ~chosen).all(axis=1) & (apart | ~both).all(axis=(1, 2))
    return np.where(proved, chosen.sum(axis=1), 0)


def _modulus(x: Doubles, y: Doubles) -> Doubles:
    return np.sqrt(x * x + y * y)


def _horner(p: tuple[Doubles, Doubles], x: Doubles, y: Doubles) -> tuple[Doubles, Doubles]:
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


def _polished(p: Complexes, z: Complexes) -> Complexes:
    for _ in range(_POLISHINGS):
        value, slope = np.zeros_like(z), np.zeros_like(z)
        for c in p.T[::-1, :, None]:
            slope, value = slope * z + value, value * z + c
        step = value / slope
        z = np.where(np.isfinite(step), z - step, z)
    return z


def _roots_on_the_line(q: Doubles) -> Complexes:
    """The roots u as eigenvalues of companion matrices; nan where there are none."""
    top = -q[:, -2::-1] / q[:, -1:]
    finite = np.isfinite(top).all(axis=1)
    companions = np.zeros((len(q), DEGREE_U, DEGREE_U))
    companions[:, np.arange(1, DEGREE_U), np.arange(DEGREE_U - 1)] = 1
    companions[finite, 0, :] = top[finite]
    roots = np.full((len(q), DEGREE_U), np.nan + 0j)
    with suppress(np.linalg.LinAlgError):  # then there are no guesses
        roots[finite] = np.linalg.eigvals(companions[finite])
    return roots


def real_eigenvalues(q: Sequence[float]) -> list[float]:
    """Guesses of the real roots of Q with these coefficients, ascending."""
    companion = np.eye(DEGREE_U, k=-1)
    companion[0] = [-x / q[-1] for x in q[-2::-1]] if q[-1] else np.nan
    try:
        roots = np.linalg.eigvals(companion)
    except np.linalg.LinAlgError:
        return []
    return sorted(roots.real[roots.imag == 0].tolist())


def _matrices(eliminant: Eliminant, exponent: int) -> tuple[Complexes, Doubles]:
    """The coefficients of P and of Q by powers of L / 2^exponent, each right to two units of the last place.

    They are those of Q as a polynomial in √ρ u. Rows are powers of z or u, columns powers of L. All are
    divided by one number, the greatest of them.
    """
    radicand, rho = eliminant.slice_map.radicand, eliminant.slice_map.rho
    parts = [*_change_of_basis(), None]
    # with (√ρ)²⁴ times each number, even and odd powers of √ρ stand apart
    pairs = [
        (_times(part, eliminant.a, rho, odd), _times(part, eliminant.b, rho, odd))
        for part in parts
        for odd in ((False, True) if rho > 1 else (False,))
    ]
    size = max(abs(x).bit_length() for pair in pairs for part in pair for x in part.entries())
    # |A + ωB + √ρ (C + ωD)| times its conjugates, two factors for ρ = 1, is at least 1 for each number that
    # is not 0, so a hundred bits of it are right
    conjugates = 2 if rho == 1 else 4
    bits = conjugates * (size + radicand.bit_length() + rho.bit_length() + conjugates) + 128
    with ctx.workprec(bits):
        tables = _in_balls(pairs, exponent, omega_ball(radicand, bits), rho)
        top = max(abs(x.mid()) for table in tables for x in table)
        floats = [[0.0 if x.contains(0) else float(x / top) for x in table] for table in tables]
    real, imaginary, line = (np.array(table).reshape(DEGREE_U + 1, DEGREE_L + 1) for table in floats)
    return real + 1j * imaginary, line


def _in_balls(
    pairs: Sequence[tuple[fmpz_mat, fmpz_mat]], exponent: int, omega: arb, rho: int
) -> list[list[arb]]:
    """A + ωB of each pair, in the unit 2^exponent of L; with ρ > 1 every other pair is to be times √ρ."""
    units = [arb(2) ** (exponent * k) for k in range(DEGREE_L + 1)] * (DEGREE_U + 1)
    tables = [
        [(x + omega * y) * unit for x, y, unit in zip(a.entries(), b.entries(), units, strict=True)]
        for a, b in pairs
    ]
    if rho == 1:
        return tables
    root = arb(rho).sqrt()
    return [
        [x + root * y for x, y in zip(even, odd, strict=True)]
        for even, odd in zip(tables[::2], tables[1::2], strict=True)
    ]


def _times(part: fmpz_mat | None, coefficients: fmpz_mat, rho: int, odd: bool) -> fmpz_mat:
    """A change of basis of a polynomial in √ρ u, times (√ρ)²⁴, or √ρ²⁴ over √ρ for odd powers."""
    if rho > 1:
        rows = [
            [x * rho ** ((DEGREE_U - k - odd) // 2) if k % 2 == odd else 0 for x in row]
            for k, row in enumerate(coefficients.tolist())
        ]
        coefficients = fmpz_mat(rows)
    return coefficients if part is None else part * coefficients


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


class NearPose(NamedTuple):
    """A proved cusp: a box that holds it and no other pose.

    Attributes:
        t, t_inverse, t_reach: tan(α/2), or its inverse, and the radius of the box.
        u, u_inverse, u_reach: the same of θ.
    """

    t: float
    t_inverse: bool
    t_reach: float
    u: float
    u_inverse: bool
    u_reach: float


def proved_boxes(
    eliminant: Eliminant, lengths: Sequence[Fraction], thetas: Sequence[Sequence[tuple[float, float]]]
) -> list[list[NearPose] | None]:
    """For each slice the proved cusps near guesses of θ, in ascending order; None if one is not proved.

    Args:
        eliminant: of the manipulator and its fixed leg.
        lengths: the *scaled* lengths of the slices.
        thetas: for each slice numerators and denominators of tan(θ/2).
    """
    double_map = DoubleMap.of(eliminant.slice_map, map_exponent(eliminant.slice_map, lengths))
    sizes = [len(x) for x in thetas]
    if not any(sizes):
        return [[] for _ in sizes]
    index = np.repeat(np.arange(len(sizes)), sizes)
    with np.errstate(all="ignore"):
        guessed = double_map.guessed(double_map.lengths(lengths)[index], [pair for x in thetas for pair in x])
        alpha, theta = guessed.alpha, guessed.theta
        radii, good = _krawczyk(double_map, guessed)
        (alpha_reach, alpha_good), (theta_reach, theta_good) = map(_reach, (alpha, theta), radii)
        good &= alpha_good & theta_good & _is_proper(double_map, guessed, radii[1])
        place = theta.place()
        order = np.lexsort((place, index))
        good = good[order] & _are_apart(index[order], place[order], theta_reach[order])
    columns = alpha.x, alpha.inverse, alpha_reach, theta.x, theta.inverse, theta_reach
    sorted_columns = [x.astype(bool if x.dtype == bool else float)[order].tolist() for x in columns]
    poses, flags = list(map(NearPose, *sorted_columns)), good.tolist()
    ends = list(accumulate(sizes, initial=0))
    return [poses[i:k] if all(flags[i:k]) else None for i, k in pairwise(ends)]


def _bounded_pose(
    unit: float, guessed: GuessedPoses, radii: tuple[Any, Any]
) -> tuple[tuple[PlaneNumber[Bounded], ...], Bounded]:
    """By what waves turn, with L as a factor, and L; both angles are within some radii of the guess."""
    size = abs(guessed.length.astype(float))
    length = Bounded(guessed.length, 2 * unit * size, unit)

    def bounded(at: PlaneNumber[Floats], radius: Any) -> PlaneNumber[Bounded]:
        reach = radius + _CIRCLE_ERROR * unit
        return PlaneNumber(Bounded(at.real, reach, unit), Bounded(at.imag, reach, unit))

    turn, direction = bounded(guessed.alpha.turn, radii[0]), bounded(guessed.theta.turn, radii[1])
    return turns(turn, direction * length), length


def _krawczyk(double_map: DoubleMap, guessed: GuessedPoses) -> tuple[tuple[Floats, Floats], Flags]:
    """Radii of boxes, and whether there is just one zero of J and E in each, by Krawczyk."""
    f, g, unit = double_map.f, double_map.g, double_map.unit
    zero = np.zeros(len(guessed.length))
    at, _ = _bounded_pose(unit, guessed, (zero, zero))
    j, e = singularity_and_coalescence(f.turned(*at), g.turned(*at))
    steps = [(abs(a) * j.greatest + abs(b) * e.greatest) * _SAFE + _DUST for a, b in guessed.inverse]
    radii = 2 * steps[0], 2 * steps[1]
    at, _ = _bounded_pose(unit, guessed, radii)
    d = PoseDerivatives.of(f.turned(*at), g.turned(*at))
    columns = (d.j_alpha, d.e_alpha), (d.j_theta, d.e_theta)
    proved = (radii[0] < _WIDEST) & (radii[1] < _WIDEST)
    slopes = []
    for row, (a, b) in enumerate(guessed.inverse):
        # 1 − Y F′, where Y is the inverse and F is (J, E)
        slopes.append([_distance(a, x, b, y, float(row == k)) * _SAFE for k, (x, y) in enumerate(columns)])
        proved &= abs(a) + abs(b) < _STEEPEST
    proved &= contracts([step * _SAFE for step in steps], slopes, radii)
    return radii, proved


def _distance(a: Floats, x: Bounded, b: Floats, y: Bounded, target: float) -> Floats:
    """A bound of |a x + b y − target|."""
    first, second = a * x.value, b * y.value
    own = 4 * x.unit * (abs(first) + abs(second) + target)
    distance: Floats = (abs(first + second - target) + (abs(a) * x.error + abs(b) * y.error) + own) * _SAFE
    return distance


def _is_proper(double_map: DoubleMap, guessed: GuessedPoses, radius: Floats) -> Flags:
    """Whether w and q are not 0 within a radius of θ: the pose is not spurious."""
    (_, tip, _), length = _bounded_pose(double_map.unit, guessed, (radius, radius))
    base = double_map.f.base * tip
    closed = length * length + double_map.closed - (base.real + base.real)
    proper: Flags = (base.imag.least > _DUST) & (closed.least > _DUST)
    return proper


def _reach(angle: HalfAngles, radius: Floats) -> tuple[Floats, Flags]:
    """How far the rounded x can be from that of an angle within a small radius, and whether x is usual."""
    size = abs(angle.x.astype(float))
    reach = (radius / 2 * (1 + size * size) + _TO_DOUBLE * size) * _SAFE
    return reach, (size > 2 * reach) & (size < 1 + 2.0**-26)


def _are_apart(index: Floats, place: Floats, reach: Floats) -> Flags:
    """Whether each θ of the same slice is greater than the one before, by proof; they are sorted."""
    apart = np.ones(len(index), dtype=bool)
    gap = place[1:] - place[:-1] - (reach[1:] + reach[:-1])
    apart[1:] = (index[1:] != index[:-1]) | (gap > 2.0**-48)
    return apart
