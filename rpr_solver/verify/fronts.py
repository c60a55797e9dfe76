"""J and the squared free legs of a slice as sums of waves, with proved bounds; points of J = 0.

Angles are integers in units of 2^−BITS radians, and each number that is computed from them is within ERROR
of a right one: cosines and sines are off by fewer than 2^10 units, coefficients by fewer than 2^13, and there
are at most 25 waves of orders up to 3. All derivatives are bounded by the amplitudes of the waves
(mathematics.md#regions-of-the-joint-plane).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import hypot, isqrt

from rpr_solver.verify.arcs import waves_of
from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.intervals import Interval, cos_sin, pi
from rpr_solver.verify.core.krawczyk import Box
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.surds import Ring
from rpr_solver.verify.core.system import System, Trig

BITS = 192
ERROR = 1 << 40
"""A bound of the errors of all numbers that are computed from angles, with much to spare."""
ONE, FRAME, _COEFFICIENT_ERROR = 1 << BITS, 20, 1 << 8
_POINT_ERROR, _NEWTON_STEPS, _FARTHEST = 1 << (BITS - 116), 6, 60 << BITS
TURN = pi(BITS).scaled(2).lower
"""A full turn, but for fewer than 8 units."""

Jet = tuple[int, int, int, int, int, int]
"""A value, the derivatives in α and θ (or r and e), and those of second order: αα, αθ, θθ."""
Vector = tuple[int, int]


def product(a: int, b: int) -> int:
    """An upper bound of the product of two numbers ≥ 0."""
    return (a * b >> BITS) + 1


@dataclass(frozen=True)
class Wave:
    """Σ a cos(p α + q θ) + b sin(p α + q θ), divided by 2^``shift``.

    Attributes:
        norms: bounds of all derivatives of orders 0 to 3 in directions of length 1.
    """

    terms: tuple[tuple[int, int, int, int], ...]
    shift: int
    norms: tuple[int, int, int, int]

    @classmethod
    def of(cls, p: Trig, ring: Ring) -> Wave:
        """The waves of a trigonometric polynomial, the largest of size 1.

        Raises:
            OpenError: they are not known well enough.
        """
        waves = waves_of((p,), ring.radicand, Interval.of(1, BITS))
        parts = [x for pair in waves.values() for x in pair]
        shift = max(max(abs(x.lower), abs(x.upper)).bit_length() for x in parts) - BITS
        halves: dict[tuple[int, int], list[int]] = {}
        for (k, m), (real, imaginary) in waves.items():
            for x in (real, imaginary):
                if x.upper - x.lower > _COEFFICIENT_ERROR << max(shift, 0):
                    raise OpenError("the waves of the equations are too long for intervals")
            sign = 1 if (k, m) >= (0, 0) else -1
            own = halves.setdefault((sign * k, sign * m), [0, 0])
            # c e^(ix) + c̄ e^(−ix) = 2 Re c cos x − 2 Im c sin x
            own[0] += _shifted(real.lower, shift)
            own[1] -= sign * _shifted(imaginary.lower, shift)
        terms = tuple((k, m, a, b) for (k, m), (a, b) in sorted(halves.items()))
        return cls(terms, shift, _norms(terms))

    def jet(self, phases: Mapping[Vector, Vector]) -> Jet:
        """Its value and derivatives, given cosines and sines."""
        value = slope_a = slope_t = bend_aa = bend_at = bend_tt = 0
        for p, q, a, b in self.terms:
            cos, sin = phases[p, q]
            even, odd = a * cos + b * sin, b * cos - a * sin
            value += even
            slope_a += p * odd
            slope_t += q * odd
            bend_aa -= p * p * even
            bend_at -= p * q * even
            bend_tt -= q * q * even
        return (
            value >> BITS,
            slope_a >> BITS,
            slope_t >> BITS,
            bend_aa >> BITS,
            bend_at >> BITS,
            bend_tt >> BITS,
        )

    def value(self, phases: Mapping[Vector, Vector]) -> int:
        """Its value alone."""
        return sum(a * phases[p, q][0] + b * phases[p, q][1] for p, q, a, b in self.terms) >> BITS


def _shifted(x: int, shift: int) -> int:
    return x >> shift if shift >= 0 else x << -shift


def _norms(terms: tuple[tuple[int, int, int, int], ...]) -> tuple[int, int, int, int]:
    """Σ |c| |k|ⁿ for n = 0 to 3, rounded up."""
    result = [ERROR] * 4
    for p, q, a, b in terms:
        size, length = isqrt(a * a + b * b) + 1, isqrt((p * p + q * q) << 32) + 1
        for n in range(4):
            result[n] += (size * length**n >> (16 * n)) + 1
    return result[0], result[1], result[2], result[3]


@dataclass(frozen=True)
class Point:
    """A point of J = 0 within ``error`` of two angles, and its image within ``blur``."""

    alpha: int
    theta: int
    error: int
    image: Vector
    blur: int

    def turned(self, turns: Vector) -> Point:
        """The same, its angles by full turns greater."""
        alpha, theta = self.alpha + turns[0] * TURN, self.theta + turns[1] * TURN
        return Point(alpha, theta, self.error + (1 << 10), self.image, self.blur)


@dataclass(frozen=True)
class Front:
    """J and the squared free legs of a slice, each divided by a power of 2, and all cusps.

    Attributes:
        cusps: the angles of each, and their error.
    """

    singular: Wave
    legs: tuple[Wave, Wave]
    cusps: tuple[tuple[int, int, int], ...]

    @classmethod
    def of(cls, system: System, cusps: Sequence[Box]) -> Front:
        """The functions of a slice, and all of its cusps."""
        first, second = (Wave.of(leg.squared, system.ring) for leg in system.legs)
        return cls(Wave.of(system.singular, system.ring), (first, second), tuple(map(_angles, cusps)))

    @cached_property
    def _keys(self) -> list[Vector]:
        return sorted({(p, q) for wave in (self.singular, *self.legs) for p, q, _, _ in wave.terms})

    def phases(self, alpha: int, theta: int) -> dict[Vector, Vector]:
        """Cosines and sines of p α + q θ for all waves.

        Raises:
            OpenError: an angle is beyond many turns.
        """
        if max(abs(alpha), abs(theta)) > _FARTHEST:
            raise OpenError("a component of the singular curve makes too many turns")
        spend(60, BITS)
        powers = [_powers(x, 1 + max(abs(key[n]) for key in self._keys)) for n, x in ((0, alpha), (1, theta))]
        result = {}
        for p, q in self._keys:
            (c, s), (d, t) = powers[0][p], powers[1][abs(q)]
            if q < 0:
                t = -t
            result[p, q] = (c * d - s * t) >> BITS, (s * d + c * t) >> BITS
        return result

    def point(self, alpha: int, theta: int, normal: Vector) -> Point | None:
        """The point of J = 0 near a pose, in the direction of a normal, in units of 2^−20; None if none."""
        x, y = normal
        for _ in range(_NEWTON_STEPS):
            jet = self.singular.jet(self.phases(alpha, theta))
            slope = (jet[1] * x + jet[2] * y) >> FRAME
            if slope <= 0:
                return None
            step = -(jet[0] << BITS) // slope
            if abs(step) > ONE >> 1:
                return None
            alpha, theta = alpha + (step * x >> FRAME), theta + (step * y >> FRAME)
            if abs(step) < _POINT_ERROR >> 4:
                break
        error = max(_POINT_ERROR, 8 * (ERROR << BITS) // slope)
        for sign in (-1, 1):
            there = alpha + sign * (error * x >> FRAME), theta + sign * (error * y >> FRAME)
            if sign * self.singular.value(self.phases(*there)) <= ERROR:
                return None
        here = self.phases(alpha, theta)
        image = self.legs[0].value(here), self.legs[1].value(here)
        blur = ERROR + max(product(leg.norms[1], 2 * error) for leg in self.legs)
        return Point(alpha, theta, 2 * error, image, blur)

    def near(self, alpha: int, theta: int) -> Point | None:
        """The point of J = 0 near a pose, along the gradient; None if none is proved."""
        _, a, t, *_ = self.singular.jet(self.phases(alpha, theta))
        size = hypot(a, t) * (1 + 2**-18)
        if not size:
            return None
        return self.point(alpha, theta, (int((1 << FRAME) * (a / size)), int((1 << FRAME) * (t / size))))


def _angles(box: Box) -> tuple[int, int, int]:
    """The middle of a box, and a bound of how far it reaches; all within a few turns."""
    alpha, theta = (int(x.middle * ONE) for x in (box.alpha, box.theta))
    return alpha, theta, int(max(box.alpha.radius, box.theta.radius) * ONE) + (1 << 10)


def _powers(angle: int, number: int) -> list[Vector]:
    """Cosine and sine of the first multiples of an angle."""
    cos, sin = (x.lower for x in cos_sin(Interval(angle, angle, BITS)))
    result = [(ONE, 0)]
    while len(result) < number:
        c, s = result[-1]
        result.append(((c * cos - s * sin) >> BITS, (s * cos + c * sin) >> BITS))
    return result
