"""Poses above real roots as floats with bounds of their errors, for all slices of a block at once, by numpy.

A guess of θ gives one of α by Euclid's algorithm on J and E. Newton steps improve both angles, the last in
extended precision where the processor has it. None of this decides anything; proofs.py proves the poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb, ctx

from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.legs import PoseDerivatives, Waves, turns
from rpr_solver.model.slice_map import SliceMap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[Any]
    Flags = NDArray[np.bool_]
    Inverse = tuple[tuple[Floats, Floats], tuple[Floats, Floats]]


_UP = 1 + 2.0**-48
"""Bounds the roundings within a bound, which has at most ten of them in double precision."""


class Bounded:
    """Numbers within ``error`` of ``value``: scalars or numpy arrays of floats.

    Attributes:
        value: floats that each operation rounds to nearest.
        error: bounds, in double precision.
        unit: bounds the relative error of a rounding.
        size: the absolute values, in double precision.
    """

    __slots__ = ("error", "size", "unit", "value")

    def __init__(self, value: Any, error: Any, unit: float) -> None:
        self.value, self.error, self.unit = value, error, unit
        self.size = abs(value.astype(float))

    def __add__(self, other: Bounded) -> Bounded:
        return self._sum(self.value + other.value, other)

    def __sub__(self, other: Bounded) -> Bounded:
        return self._sum(self.value - other.value, other)

    def __neg__(self) -> Bounded:
        return Bounded(-self.value, self.error, self.unit)

    def _sum(self, value: Any, other: Bounded) -> Bounded:
        result = Bounded(value, 0.0, self.unit)
        result.error = (self.error + other.error + self.unit * result.size) * _UP
        return result

    def __mul__(self, other: Bounded) -> Bounded:
        result = Bounded(self.value * other.value, 0.0, self.unit)
        error = self.size * other.error + self.error * (other.size + other.error)
        result.error = (error + self.unit * result.size) * _UP
        return result

    @property
    def least(self) -> Any:
        """A lower bound of the absolute values."""
        return (self.size - self.error) * (2 - _UP)

    @property
    def greatest(self) -> Any:
        """An upper bound of the absolute values."""
        return (self.size + self.error) * _UP


_OMEGA_BITS = 128


class HalfAngles:
    """Angles as ``x``, which is tan(angle/2), or its inverse where this is less."""

    def __init__(self, numerator: Floats, denominator: Floats) -> None:
        self.inverse: Flags = abs(numerator) > abs(denominator)
        self.x: Floats = np.where(self.inverse, denominator / numerator, numerator / denominator)
        self._sign: Floats = np.where(self.inverse, -1.0, 1.0)

    @property
    def turn(self) -> PlaneNumber[Floats]:
        """Cosines and sines."""
        square = self.x * self.x
        return PlaneNumber(self._sign * ((1 - square) / (1 + square)), 2 * self.x / (1 + square))

    def add(self, angle: Floats) -> None:
        """Add small angles."""
        self.x = self.x + self._sign * (angle / 2) * (1 + self.x * self.x)

    def place(self) -> Floats:
        """Numbers from −2 to 2 that ascend with the angle from −180° to 180°, where x is at most 1."""
        return np.where(self.inverse, np.copysign(2.0, self.x) - self.x, self.x)


@dataclass(frozen=True)
class GuessedPoses:
    """Poses (α, θ) of slices, with the scaled L / 2^exponent, and an inverse of the gradients of J and E."""

    length: Floats
    alpha: HalfAngles
    theta: HalfAngles
    inverse: Inverse


@dataclass(frozen=True)
class DoubleMap:
    """A manipulator with one leg fixed, in doubles, its scaled lengths divided by 2^exponent.

    Angles are those of the forms; their half tangents have the unit 1 here, not 1/√ρ.

    Attributes:
        unit: bounds the relative error of a rounding.
        f, g: the waves of the free legs; all of their numbers are at most 1.
        closed: the sides of f, base² − platform².
        singular, coalescence: coefficients of J and E by powers of √ρ t, L and √ρ u.
    """

    exponent: int
    unit: float
    f: Waves
    g: Waves
    closed: Bounded
    singular: Floats
    coalescence: Floats

    @classmethod
    @lru_cache(maxsize=16)
    def of(cls, slice_map: SliceMap, exponent: int) -> DoubleMap:
        """For fixed legs of :func:`map_exponent`."""
        legs = slice_map.f, slice_map.g
        omega = omega_ball(slice_map.radicand, _OMEGA_BITS)

        kind, unit = number_type()

        def bounded(x: arb) -> Bounded:
            high = float(x)
            value = kind(high) + kind(float(x - high))
            return Bounded(value, (2 * unit * abs(value) + float(x.rad())) * _UP, unit)

        with ctx.workprec(_OMEGA_BITS):
            size = arb(2) ** -exponent
            waves = [Waves.of(m * size, a * size) for m, a in (leg.own_points(omega) for leg in legs)]
            f, g = (Waves(*(PlaneNumber(bounded(x.real), bounded(x.imag)) for x in wave)) for wave in waves)
            closed = bounded((slice_map.f.base2 - slice_map.f.platform2) * size * size)
        forms = (
            _doubles(form, slice_map.rho, exponent) for form in (slice_map.singular, slice_map.coalescence)
        )
        return cls(exponent, unit, f, g, closed, *forms)

    def lengths(self, scaled: Sequence[Fraction]) -> Floats:
        """L / 2^exponent of *scaled* L, right to two units."""
        kind = number_type()[0]
        pairs: Floats = np.array([_two_floats(x, self.exponent) for x in scaled], dtype=kind)
        return pairs[:, 0] + pairs[:, 1]

    def guessed(self, lengths: Floats, thetas: Sequence[tuple[float, float]]) -> GuessedPoses:
        """Poses above guesses of θ, each a numerator and a denominator of tan(θ/2), with L / 2^exponent."""
        n, d = np.array(thetas).reshape(-1, 2).T
        short = lengths.astype(float)
        alpha, theta = HalfAngles(*self._alphas(short, n, d)), HalfAngles(n, d)
        inverse = self._step(short, alpha, theta, np.float64)
        self._step(lengths, alpha, theta, number_type()[0])
        return GuessedPoses(lengths, alpha, theta, inverse)

    def _step(self, lengths: Floats, alpha: HalfAngles, theta: HalfAngles, kind: Any) -> Inverse:
        """A Newton step, and the inverse of the gradients of J and E before it."""
        f, g = (
            Waves(*(PlaneNumber(kind(x.real.value), kind(x.imag.value)) for x in waves))
            for waves in (self.f, self.g)
        )
        turned = turns(alpha.turn, theta.turn * lengths)
        at = PoseDerivatives.of(f.turned(*turned), g.turned(*turned))
        whole = at.j_alpha * at.e_theta - at.j_theta * at.e_alpha
        inverse = (at.e_theta / whole, -at.j_theta / whole), (-at.e_alpha / whole, at.j_alpha / whole)
        for angle, (a, b) in zip((alpha, theta), inverse, strict=True):
            angle.add(-(a * at.j + b * at.e))
        return inverse

    def _alphas(self, lengths: Floats, n: Floats, d: Floats) -> tuple[Floats, Floats]:
        """Numerators and denominators of tan(α/2), by Euclid's algorithm on forms in t or in 1/t."""
        size = np.hypot(n, d)
        j, e = (_above(form, lengths, n / size, d / size) for form in (self.singular, self.coalescence))
        straight, (denominator, numerator) = _common_root(j, e), _common_root(j[::-1], e[::-1])
        pairs = [straight, (numerator, denominator)]
        errors = [sum(_value(form, *pair) for form in (j, e)) for pair in pairs]
        first = errors[0] <= errors[1]
        return np.where(first, pairs[0][0], pairs[1][0]), np.where(first, pairs[0][1], pairs[1][1])


def number_type() -> tuple[Any, float]:
    """The longest floats that the processor computes with, and a bound of a rounding."""
    if np.finfo(np.longdouble).nmant == 63:
        return np.longdouble, 2.0**-64
    return np.float64, 2.0**-53


def _two_floats(x: Fraction, exponent: int) -> tuple[float, float]:
    """x / 2^exponent, rounded, and the rest, rounded."""
    high = float_of(x, exponent)
    p, q = high.as_integer_ratio()
    return high, (x.numerator * q - (p * x.denominator << exponent)) / (x.denominator * q << exponent)


def length_exponent(lengths: Sequence[Fraction]) -> int:
    """A number such that all L / 2^exponent are below 1."""
    return max(x.numerator.bit_length() - x.denominator.bit_length() for x in lengths) + 1


def float_of(x: Fraction, exponent: int) -> float:
    """x / 2^exponent, rounded to nearest."""
    n, d = x.numerator, x.denominator
    return n / (d << exponent) if exponent > 0 else (n << -exponent) / d


def map_exponent(slice_map: SliceMap, lengths: Sequence[Fraction]) -> int:
    """A number ≥ 0 such that no side and none of these *scaled* lengths is longer than 2 to its power."""
    squares = [side for leg in (slice_map.f, slice_map.g) for side in (leg.base2, leg.platform2)]
    return max(max(squares).bit_length() // 2 + 1, length_exponent(lengths))


def _doubles(form: BiForm, rho: int, exponent: int) -> Floats:
    """The coefficients, divided by the greatest, by powers of √ρ t, L / 2^exponent and √ρ u."""
    sizes = [part.height_bits() for row in form.coefficients for c in row for part in (c.a, c.b)]
    bits = 2 * (max(sizes) + form.radicand.bit_length()) + _OMEGA_BITS
    with ctx.workprec(bits):
        units = [arb(2) ** (exponent * k) for k in range(len(form.coefficients[0]))]
        orders = range(form.degree_u + 1)
        weights = root_powers(rho, form.degree_t + form.degree_u)
        table = [
            [
                [c.ball(bits)[k] * unit / weights[i + k] for k in orders]
                for c, unit in zip(row, units, strict=True)
            ]
            for i, row in enumerate(form.coefficients)
        ]
        top = max(abs(x.mid()) for row in table for c in row for x in c)
        return np.array([[[float(x / top) for x in c] for c in row] for row in table])


def root_powers(rho: int, top: int) -> list[arb]:
    """The powers of √ρ at the working precision."""
    root = arb(rho).sqrt()
    return [root**k for k in range(top + 1)]


def _above(form: Floats, lengths: Floats, n: Floats, d: Floats) -> list[Floats]:
    """The coefficients of t⁰, t¹, … at some L and (n, d), where n/d = u."""
    _, powers, degree = form.shape
    by_length = lengths[:, None] ** np.arange(powers)
    orders = np.arange(degree)
    by_u = n[:, None] ** orders * d[:, None] ** orders[::-1]
    return list(np.einsum("tlu,cl,cu->tc", form, by_length, by_u, optimize=True))


def _common_root(j: list[Floats], e: list[Floats]) -> tuple[Floats, Floats]:
    """The numerator and the denominator of the last but one remainder's root."""
    longer, shorter = e, j
    while len(shorter) > 2:
        rest = longer
        while len(rest) >= len(shorter):
            factor, shift = rest[-1] / shorter[-1], len(rest) - len(shorter)
            rest = rest[:shift] + [x - factor * y for x, y in zip(rest[shift:-1], shorter[:-1], strict=True)]
        greatest = np.max(np.abs(rest), axis=0)
        longer, shorter = shorter, [x / greatest for x in rest]
    return -shorter[0], shorter[1]


def _value(form: list[Floats], n: Floats, d: Floats) -> Floats:
    """The absolute value of a form at n/d, against the sum of its coefficients."""
    size = np.hypot(n, d)
    n, d = n / size, d / size
    value, power = form[-1], d
    for c in form[-2::-1]:
        value, power = value * n + c * power, power * d
    return abs(value) / sum(abs(x) for x in form)
