"""The functions that vanish at degenerate cusps, on a box of poses and geometries, and what they exclude.

Half the squared length of a moving leg is, up to a constant and the factor μ, where λ/μ is the fixed length,

    F = λ e·R m − λ e·a − μ a·R m;    φ = F_α,   ψ = F_θ / λ,   K = φ_f ψ_g − ψ_f φ_g,

where a and m are its points of base and platform as seen from the fixed leg, e is the direction of that, R
the rotation by α. v = (−λ ψ, φ) is tangent to F = const, E = v·∇K and S = v·∇E; K is J without factors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import comb, inf, ldexp
from operator import mul

from rpr_solver.verify.core.intervals import Expansion, Terms, constant, have_no_common_zero
from rpr_solver.verify.core.reader import spend

Pair = tuple[Expansion, Expansion]
Sinusoid = tuple[Expansion, Expansion, Expansion, Expansion]
"""A sinusoid and its derivatives of order 1, 2, 3; they repeat."""
Jet = Mapping[tuple[int, int], Expansion]
"""Derivatives of a function by their orders in α and θ."""

_COSTS = (400, 640, 1600)
"""Products of numbers for the functions with derivatives of K up to an order."""


@dataclass(frozen=True)
class Bound:
    """The least (side −1) or greatest (side 1) length of a moving leg, f (0) or g (1)."""

    leg: int
    side: int
    length: Fraction


@dataclass(frozen=True)
class MovingLeg:
    """A moving leg as seen from the fixed one: m, a, and the products m·a and (m, a) as a determinant."""

    platform: Pair
    base: Pair
    products: Pair

    @classmethod
    def of(cls, platform: Pair, base: Pair, half: Sequence[int]) -> MovingLeg:
        """The leg with these points, on a box of these half widths."""
        (m, n), (x, y) = (tuple(z.tightened(half) for z in point) for point in (platform, base))
        products = m * x + n * y, n * x - m * y
        return cls((m, n), (x, y), (products[0].tightened(half), products[1].tightened(half)))


@dataclass(frozen=True)
class Part:
    """A box of poses and geometries.

    Attributes:
        half: its half widths.
        alpha, theta, between: cosines and sines of α, of θ and of α − θ.
        scales: λ and μ; None is 1.
        legs: f and g.
        limits: of these legs.
    """

    half: Sequence[int]
    alpha: Pair
    theta: Pair
    between: Pair
    scales: tuple[Expansion | None, Expansion | None]
    legs: tuple[MovingLeg, MovingLeg]
    limits: tuple[Bound, ...]
    _jets: dict[int, tuple[list[tuple[Jet, Jet]], Jet]] = field(default_factory=dict)

    def decided(self) -> bool:
        """Whether one of the conditions of mathematics.md#margins holds."""
        slopes, k = self._up_to(0)
        if Terms.of(k[0, 0], self.half).excludes_zero or any(map(self._is_outside, self.limits)):
            return True
        first, second = (sum(jet[0, 0].middle[0] ** 2 for jet in pair) for pair in slopes)
        legs = (1, 0) if first < second else (0, 1)
        return any(self._has_no_cusp(leg) or self._has_none_degenerate(leg) for leg in legs)

    def _has_no_cusp(self, leg: int) -> bool:
        """Whether K = E = 0 has no solution."""
        _, k = self._up_to(1)
        return self._no_common_zero(k[0, 0], self._along(leg, k, 1)[0, 0])

    def _has_none_degenerate(self, leg: int) -> bool:
        """Whether v ≠ 0, and no cusp is degenerate or on a limit."""
        slopes, k = self._up_to(2)
        e = self._along(leg, k, 2)
        tests = [(k[0, 0], e[0, 0], self._along(leg, e, 1)[0, 0]), (k[0, 0], k[1, 0], k[0, 1])]
        tests += [(k[0, 0], e[0, 0], self._excess(bound)) for bound in self.limits]
        regular = any(jet[0, 0].is_without_zero for jet in slopes[leg])
        return regular and all(self._no_common_zero(*test) for test in tests)

    def _is_outside(self, bound: Bound) -> bool:
        """Whether a leg is beyond one of its limits."""
        terms = Terms.of(self._excess(bound), self.half)
        return terms.excludes_zero and terms.value * bound.side > 0

    def _no_common_zero(self, *functions: Expansion) -> bool:
        terms = [Terms.of(function, self.half) for function in functions]
        return any(have_no_common_zero(terms, factors) for factors in good_factors(terms))

    @cached_property
    def _sinusoids(self) -> list[tuple[Sinusoid, Sinusoid, Sinusoid]]:
        """Of each leg e·R m, e·a and μ a·R m, by α − θ, θ and α."""
        _, mu = self.scales
        return [
            (
                _sinusoid(leg.platform, self.between),
                _sinusoid((leg.base[0], -leg.base[1]), self.theta),
                _sinusoid((_times(mu, leg.products[0]), _times(mu, leg.products[1])), self.alpha),
            )
            for leg in self.legs
        ]

    def _up_to(self, order: int) -> tuple[list[tuple[Jet, Jet]], Jet]:
        """φ and ψ of both legs, and K, with their derivatives up to an order."""
        if order not in self._jets:
            spend(_COSTS[order], self.legs[0].base[0].bits)
            slopes = [self._slopes(leg, order) for leg in (0, 1)]
            (phi, psi), (chi, omega) = slopes
            k = self._refined(lambda i, j: _leibniz(phi, omega, i, j) - _leibniz(psi, chi, i, j), order)
            self._jets[order] = slopes, k
        return self._jets[order]

    def _slopes(self, leg: int, order: int) -> tuple[Jet, Jet]:
        (both, base, platform), (lam, _) = self._sinusoids[leg], self.scales
        first, second = _times(lam, both[1]), _times(lam, both[2])
        long = (-second, first, second, -first)

        def phi(i: int, j: int) -> Expansion:
            value = long[(1 + i + 3 * j) % 4]
            return value - platform[(1 + i) % 4] if j == 0 else value

        def psi(i: int, j: int) -> Expansion:
            value = both[(3 + i + 3 * j) % 4]
            return value - base[(1 + j) % 4] if i == 0 else value

        return self._refined(phi, order), self._refined(psi, order)

    def _along(self, leg: int, function: Jet, order: int) -> Jet:
        """v·∇ of a function that has derivatives up to an order."""
        (phi, psi), (lam, _) = self._up_to(order)[0][leg], self.scales
        across = {key: _times(lam, psi[key]) for key in psi if sum(key) < order}
        alpha = {(i - 1, j): x for (i, j), x in function.items() if i}
        theta = {(i, j - 1): x for (i, j), x in function.items() if j}
        return self._refined(
            lambda i, j: _leibniz(phi, theta, i, j) - _leibniz(across, alpha, i, j), order - 1
        )

    def _refined(self, entry: Callable[[int, int], Expansion], order: int) -> Jet:
        """A jet with smaller radii: of values by slopes, of slopes by the values of its entries."""
        keys = [(i, j) for i in range(order + 1) for j in range(order + 1 - i)]
        jet = {key: entry(*key).tightened(self.half) for key in keys}
        return {
            (i, j): x.with_angles(jet[i + 1, j], jet[i, j + 1]) if i + j < order else x
            for (i, j), x in jet.items()
        }

    def _excess(self, bound: Bound) -> Expansion:
        """The squared length of a leg, less that of its limit; for μ = 1 alone."""
        (both, *_), (base, *_), (platform, *_) = self._sinusoids[bound.leg]
        leg, (lam, _) = self.legs[bound.leg], self.scales
        assert lam is not None
        rest = lam * lam - constant(bound.length**2, lam.bits, len(self.half))
        for x in (*leg.platform, *leg.base):
            rest = rest + x * x
        return ((both - base) * lam - platform).doubled() + rest


def _sinusoid(point: Pair, turn: Pair) -> Sinusoid:
    """x cos t − y sin t and its derivatives by t."""
    (x, y), (cos, sin) = point, turn
    value, slope = x * cos - y * sin, -(x * sin + y * cos)
    return value, slope, -value, -slope


def _times(scale: Expansion | None, x: Expansion) -> Expansion:
    return x if scale is None else scale * x


def _leibniz(first: Jet, second: Jet, i: int, j: int) -> Expansion:
    """A derivative of a product."""
    total: Expansion | None = None
    for k in range(i + 1):
        for m in range(j + 1):
            term = first[k, m] * second[i - k, j - m]
            term = term.doubled() if comb(i, k) * comb(j, m) == 2 else term
            total = term if total is None else total + term
    assert total is not None
    return total


_ROUNDS, _FACTOR_BITS, _SMALL = 8, 50, 1e-6


def good_factors(terms: Sequence[Terms]) -> Iterator[list[int]]:
    """Factors for which Σ factor · function may be nowhere 0, by reweighted least squares in floats."""
    shifts = [max(abs(t.value), sum(map(abs, t.change)) + t.rest).bit_length() for t in terms]
    values, rests = (
        [_float(x, n) for x, n in zip(row, shifts, strict=True)]
        for row in zip(*((t.value, t.rest) for t in terms), strict=True)
    )
    changes = [[_float(x, n) for x in t.change] for t, n in zip(terms, shifts, strict=True)]
    columns = list(zip(*changes, strict=True))
    weights, own = [1.0] * len(columns), [1.0] * len(terms)
    for _ in range(_ROUNDS):
        factors = _least_squares(
            values, columns, weights, [w * r * r for w, r in zip(own, rests, strict=True)]
        )
        slopes = [abs(sum(map(mul, factors, column))) for column in columns]
        parts = [abs(f) * r for f, r in zip(factors, rests, strict=True)]
        total = sum(slopes) + sum(parts)
        if total < abs(sum(map(mul, factors, values))):
            most = max(map(abs, factors))
            yield [
                int(ldexp(f / most, _FACTOR_BITS)) << (max(shifts) - n)
                for f, n in zip(factors, shifts, strict=True)
            ]
        small = _SMALL * total
        if not 0 < small < inf:
            return
        weights, own = [1 / (x + small) for x in slopes], [1 / (x + small) for x in parts]


def _float(x: int, shift: int) -> float:
    """x / 2^shift, without overflow."""
    spare = max(shift - 64, 0)
    return ldexp(float(x >> spare), spare - shift)


def _least_squares(
    values: Sequence[float],
    columns: Sequence[Sequence[float]],
    weights: Sequence[float],
    own: Sequence[float],
) -> list[float]:
    """The factors of least Σ weight (Σ factor · entry)² + Σ own factor², up to a common factor."""
    if len(values) == 2:
        a, b, d = own[0], 0.0, own[1]
        for (p, q), w in zip(columns, weights, strict=True):
            a, b, d = a + w * p * p, b + w * p * q, d + w * q * q
        x, y = values
        return [d * x - b * y, a * y - b * x]
    a, b, c, d, e, f = own[0], 0.0, 0.0, own[1], 0.0, own[2]
    for (p, q, r), w in zip(columns, weights, strict=True):
        wp, wq = w * p, w * q
        a, b, c, d, e, f = a + wp * p, b + wp * q, c + wp * r, d + wq * q, e + wq * r, f + w * r * r
    x, y, z = values
    xy, xz, yz = c * e - b * f, b * e - c * d, b * c - a * e
    return [
        (d * f - e * e) * x + xy * y + xz * z,
        xy * x + (a * f - c * c) * y + yz * z,
        xz * x + yz * y + (a * d - b * b) * z,
    ]
