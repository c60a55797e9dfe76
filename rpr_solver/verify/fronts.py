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

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.clearance import waves_of
from rpr_solver.verify.core.intervals import Interval, cos_sin, pi
from rpr_solver.verify.core.krawczyk import Box
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.surds import Ring
from rpr_solver.verify.core.system import System, Trig

BITS = 384
ERROR = 1 << 40
"""A bound of the errors of all numbers that are computed from angles, with much to spare."""
ONE, FRAME, ORDER, _COEFFICIENT_ERROR = 1 << BITS, 20, 5, 1 << 8
_POINT_ERROR, _NEWTON_STEPS, _FARTHEST = 1 << 76, 9, 60 << BITS
_ARGUMENT, _COMBINED, _SPARE = 3, 12, 40
TURN = pi(BITS).scaled(2).lower
"""A full turn, but for fewer than 8 units."""

Jet = tuple[int, int, int, int, int, int]
"""A value, the derivatives in α and θ (or r and e), and those of second order: αα, αθ, θθ."""
Vector = tuple[int, int]


def product(a: int, b: int) -> int:
    """An upper bound of the product of two numbers ≥ 0."""
    return (a * b >> BITS) + 1


def fifth_power(a: int) -> int:
    """The fifth power of a number ≥ 0, about."""
    return product(product(product(a, a), product(a, a)), a)


@dataclass(frozen=True)
class Series:
    """A function of s in [−1, 1]: a polynomial, and a bound of what is left."""

    terms: tuple[int, ...]
    rest: int

    @property
    def change(self) -> int:
        """A bound of how far it is from its first term."""
        return sum(map(abs, self.terms[1:])) + self.rest


@dataclass(frozen=True)
class Graph:
    """A curve e = Σ eₖ sᵏ, r = ``reach`` s, in a frame, and cosines and sines of all waves along it.

    Attributes:
        rows: by p and q the polynomials of cosine and sine.
        rest: bounds what these leave, if p² + q² = 1.
    """

    frame: Vector
    places: tuple[int, ...]
    rows: Mapping[Vector, tuple[list[int], list[int]]]
    rest: int


@dataclass(frozen=True)
class Wave:
    """Σ a cos(p α + q θ) + b sin(p α + q θ), divided by 2^``shift``.

    Attributes:
        norms: bounds of all derivatives of orders 0 to ORDER + 2 in directions of length 1.
    """

    terms: tuple[tuple[int, int, int, int], ...]
    shift: int
    norms: tuple[int, ...]

    @classmethod
    def of(cls, p: Trig, ring: Ring, shift: int | None = None) -> Wave:
        """The waves of a trigonometric polynomial, the largest of size 1, or divided by 2^``shift``.

        Raises:
            OpenError: they are not known well enough.
        """
        waves = waves_of((p,), ring.radicand, Interval.of(1, BITS))
        parts = [x for pair in waves.values() for x in pair]
        if shift is None:
            shift = max(max(abs(x.lower), abs(x.upper)).bit_length() for x in parts) - BITS
        halves: dict[tuple[int, int], list[int]] = {}
        for (k, m), (real, imaginary) in waves.items():
            for x in (real, imaginary):
                if _shifted(x.upper - x.lower, shift) >= _COEFFICIENT_ERROR:
                    raise OpenError("the waves of the equations are too long for intervals")
            sign = 1 if (k, m) >= (0, 0) else -1
            own = halves.setdefault((sign * k, sign * m), [0, 0])
            # c e^(ix) + c̄ e^(−ix) = 2 Re c cos x − 2 Im c sin x
            own[0] += _shifted(real.lower, shift)
            own[1] -= sign * _shifted(imaginary.lower, shift)
        terms = tuple((k, m, a, b) for (k, m), (a, b) in sorted(halves.items()))
        return cls(terms, shift, norms_of(terms))

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

    def along(self, graph: Graph) -> Series:
        """Its values along a curve."""
        terms = [(graph.rows[p, q], a, b) for p, q, a, b in self.terms]
        values = (sum(a * cos[k] + b * sin[k] for (cos, sin), a, b in terms) for k in range(ORDER + 1))
        return Series(tuple(x >> BITS for x in values), product(self.norms[ORDER + 1], graph.rest) + ERROR)

    def slope(self, graph: Graph, direction: Vector) -> Series:
        """Along a curve the values of its derivative in a direction, in units of 2^−20."""
        x, y = direction
        terms = [(graph.rows[p, q], p * x + q * y, a, b) for p, q, a, b in self.terms]
        values = (
            sum(m * (b * cos[k] - a * sin[k]) for (cos, sin), m, a, b in terms) for k in range(ORDER + 1)
        )
        rest = product(self.norms[ORDER + 2], graph.rest) + ERROR
        return Series(tuple(x >> (BITS + FRAME) for x in values), rest)


def _shifted(x: int, shift: int) -> int:
    return x >> shift if shift >= 0 else x << -shift


def norms_of(terms: tuple[tuple[int, int, int, int], ...]) -> tuple[int, ...]:
    """Σ |c| |k|ⁿ for n = 0 to ORDER + 2, rounded up."""
    result = [ERROR] * (ORDER + 3)
    for p, q, a, b in terms:
        size, length = isqrt(a * a + b * b) + 1, isqrt((p * p + q * q) << 32) + 1
        for n in range(ORDER + 3):
            result[n] += (size * length**n >> (16 * n)) + 1
    return tuple(result)


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
        powers = [
            powers_of(x, 1 + max(abs(key[n]) for key in self._keys)) for n, x in ((0, alpha), (1, theta))
        ]
        result = {}
        for p, q in self._keys:
            (c, s), (d, t) = powers[0][p], powers[1][abs(q)]
            if q < 0:
                t = -t
            result[p, q] = (c * d - s * t) >> BITS, (s * d + c * t) >> BITS
        return result

    def graph(self, phases: Mapping[Vector, Vector], frame: Vector, reach: int, slope: int) -> Graph | None:
        """About the curve J = 0 near a point of it, given the slope of J across; None if it bends too much.

        Each term of J along the curve is made 0 by the one of the same order of e; cosines and sines of a
        phase φ have c′ = −φ′ s and s′ = φ′ c.
        """
        (x, y), places = frame, [0]
        turns = {(p, q): ((p * x + q * y) * reach >> FRAME, q * x - p * y) for p, q in self._keys}
        rows = {key: ([phases[key][0]], [phases[key][1]], [0]) for key in self._keys}
        for k in range(1, ORDER + 1):
            for key, (cos, sin, phase) in rows.items():
                phase.append(turns[key][0] if k == 1 else 0)
                cos.append((-sum(j * phase[j] * sin[k - j] for j in range(1, k + 1)) >> BITS) // k)
                sin.append((sum(j * phase[j] * cos[k - j] for j in range(1, k + 1)) >> BITS) // k)
            known = sum(a * rows[p, q][0][k] + b * rows[p, q][1][k] for p, q, a, b in self.singular.terms)
            places.append(-known // slope)
            for key, (cos, sin, phase) in rows.items():
                change = turns[key][1] * places[k] >> FRAME
                phase[k] += change
                cos[k] -= change * sin[0] >> BITS
                sin[k] += change * cos[0] >> BITS
        rest = _rest([0, reach + abs(places[1]), *map(abs, places[2:])])
        return (
            None if rest is None else Graph(frame, tuple(places), {k: v[:2] for k, v in rows.items()}, rest)
        )

    def point(self, alpha: int, theta: int, normal: Vector, size: int = 0) -> Point | None:
        """The point of J = 0 near a pose, in the direction of a normal, in units of 2^−20; None if none.

        It ends a piece of this size, and is known as well as that needs.
        """
        (x, y), least = normal, max(_POINT_ERROR, fifth_power(size) >> _SPARE)
        for _ in range(_NEWTON_STEPS):
            here = self.phases(alpha, theta)
            jet = self.singular.jet(here)
            slope = (jet[1] * x + jet[2] * y) >> FRAME
            if slope <= 0:
                return None
            step = -(jet[0] << BITS) // slope
            if abs(step) > ONE >> 1:
                return None
            if abs(step) < least >> 4:
                break
            alpha, theta = alpha + (step * x >> FRAME), theta + (step * y >> FRAME)
        error = max(least, 8 * (ERROR << BITS) // slope)
        # J has both signs within the error, by its slope and its second derivatives
        bend = product(self.singular.norms[2], product(error, error))
        if (slope * error >> BITS) - bend <= abs(jet[0]) + 4 * ERROR:
            return None
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


@dataclass(frozen=True)
class Patch:
    """A disc of poses about ``middle``, of radius ``reach``; no two points of J = 0 in it have one image."""

    middle: Vector
    reach: int

    @classmethod
    def about(cls, front: Front, middle: Vector, reach: int) -> Patch | None:
        """The disc, if it is proved to be one.

        X is a combination of both legs, D a derivative along its level curves, on which J is the derivative
        of another one, but for a factor. Either J or its derivative is monotonic along them. From a square
        round the disc, turned to the slope of X, they do not lead out of one that is longer by a half.
        """
        here = front.phases(*middle)
        spend(160, BITS)
        jets = [leg.jet(here) for leg in front.legs]
        k = max((1, 2), key=lambda k: sum(abs(jet[k]) for jet in jets))
        shift = max(max(abs(jet[k]).bit_length() for jet in jets) - _COMBINED, 0)
        factors = [jet[k] >> shift for jet in jets]
        x = [sum(n * jet[i] for n, jet in zip(factors, jets, strict=True)) for i in range(6)]
        third = sum(abs(n) * leg.norms[3] for n, leg in zip(factors, front.legs, strict=True))
        size, unit = hypot(x[1] / ONE, x[2] / ONE), (1 << FRAME) * (1 - 2**-18)
        if not size:
            return None
        frame = int(unit * (x[1] / ONE) / size), int(unit * (x[2] / ONE) / size)
        xu, xv, xuu, xuv, xvv = _on_box(framed(x, frame), third, reach)
        if 4 * max(-xv.lower, xv.upper) >= xu.lower:
            return None
        ju, jv, juu, juv, jvv = _on_box(
            framed(front.singular.jet(here), frame), front.singular.norms[3], reach
        )
        second = (xv * xuv - xu * xvv) * ju + (xv * juu - xu * juv) * xv
        second = second - (xv * xuu - xu * xuv) * jv - (xv * juv - xu * jvv) * xu
        return cls(middle, reach) if (xv * ju - xu * jv).sign or second.sign else None

    def holds(self, place: Vector, across: int) -> bool:
        """Whether all poses no farther from a place than this are in the disc, up to full turns."""
        a, t = ((x - y + TURN // 2) % TURN - TURN // 2 for x, y in zip(place, self.middle, strict=True))
        room = self.reach - (self.reach >> 12) - across - ERROR  # frames are shorter than 1 by 2^-18
        return room > 0 and a * a + t * t < room * room


def framed(jet: Sequence[int], frame: Vector) -> Jet:
    """The derivatives along a direction and its left normal, in units of 2^−20."""
    (x, y), (value, a, t, aa, at, tt) = frame, jet
    return (
        value,
        (x * a + y * t) >> FRAME,
        (x * t - y * a) >> FRAME,
        (x * x * aa + 2 * x * y * at + y * y * tt) >> (2 * FRAME),
        (x * y * (tt - aa) + (x * x - y * y) * at) >> (2 * FRAME),
        (y * y * aa - 2 * x * y * at + x * x * tt) >> (2 * FRAME),
    )


def _on_box(jet: Sequence[int], third: int, reach: int) -> list[Interval]:
    """The first and second derivatives in a box of 3/2 and 1 times a reach, given those in the middle."""
    (_, du, dv, uu, uv, vv), long = jet, 3 * reach // 2
    far = 2 * reach  # no less than the distance from the middle
    more = product(third, far) + 16 * ERROR
    square = product(third, product(far, far)) // 2 + 16 * ERROR
    first = product(abs(uu), long) + product(abs(uv), reach) + square
    second = product(abs(uv), long) + product(abs(vv), reach) + square
    pairs = (du, first), (dv, second), (uu, more), (uv, more), (vv, more)
    return [Interval(x - r, x + r, BITS) for x, r in pairs]


def _rest(sizes: Sequence[int]) -> int | None:
    """A bound of what is left of exp(D), D = Σ dₖ sᵏ, after order ORDER ≥ the degree of D, for |s| ≤ 1.

    For each z ≥ 1 it is at most (exp(D(z)) − 1 − D(z)) / z^(ORDER + 1): 1 and D leave nothing. The best z is
    sought among powers of √2, or nearly so; the bound is convex in the logarithm of z.
    """

    def bound(n: int) -> int | None:
        z = (24 if n % 2 else 16) << (n // 2)
        total = sum(d * z**k >> (4 * k) for k, d in enumerate(sizes)) + len(sizes)
        if total > _ARGUMENT * ONE:
            return None
        largest: int = 3 ** (total // ONE + 1)
        scale: int = z ** (ORDER + 1)
        return (product(total, total) * largest << (4 * ORDER + 4)) // scale + 1

    low, high = 0, 2 * (BITS - sizes[1].bit_length() + 3)
    while low < high:
        middle = (low + high) // 2
        here, there = bound(middle), bound(middle + 1)
        if here is None or (there is not None and here <= there) or there is None:
            high = middle
        else:
            low = middle + 1
    return bound(low)


def _angles(box: Box) -> tuple[int, int, int]:
    """The middle of a box, and a bound of how far it reaches; all within a few turns."""
    alpha, theta = (int(x.middle * ONE) for x in (box.alpha, box.theta))
    return alpha, theta, int(max(box.alpha.radius, box.theta.radius) * ONE) + (1 << 10)


def powers_of(angle: int, number: int) -> list[Vector]:
    """Cosine and sine of the first multiples of an angle."""
    cos, sin = (x.lower for x in cos_sin(Interval(angle, angle, BITS)))
    result = [(ONE, 0)]
    while len(result) < number:
        c, s = result[-1]
        result.append(((c * cos - s * sin) >> BITS, (s * cos + c * sin) >> BITS))
    return result
