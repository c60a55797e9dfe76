"""Tubes of a full certificate: each holds one point of J = E = 0 for each value of its parameter.

About the origin of a tube, x = tan((α − α₀)/2), y = tan((θ − θ₀)/2) and z = L/L₀ − 1 are coordinates in which
J and E, times powers of (1 + x²) and (1 + y²), are polynomials. One of x, y, z is the parameter r, the other
two are p and q. With a constant matrix A, A (J, E) = G = (p, q) + N. If on the parabola (p̂, q̂)(r), for
|r| ≤ h, |G| + |N′| ρ < ρ, with bounds |N′| of ∂N/∂(p, q) over the tube of radii ρ, it holds exactly one zero
for each r: Krawczyk's test (turns.py). Coefficients are integers in units of 2^−bits, and all bounds are sums
of absolute values, rounded up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import product
from math import comb, isqrt
from operator import mul

from rpr_solver.verify.core.intervals import Interval, cos_sin, ends_of
from rpr_solver.verify.core.krawczyk import Pair
from rpr_solver.verify.core.reader import Record, refusal, spend
from rpr_solver.verify.core.surds import ZERO, Surd
from rpr_solver.verify.core.system import Graded, Surface, half_angle_form, in_half_tangent

DEGREE = 6
"""The greatest exponent of p, of q and of r,"""
_SHEARED = 3 * DEGREE
"""and of r once p and q are counted from a line."""
Index = tuple[int, int, int]
"""The exponents of p, q and r."""
Sizes = dict[tuple[int, int], list[int]]
"""Bounds of coefficients, by the exponents of p and q, in the order of the exponents of r."""
Moved = tuple[list[Mapping[Index, int]], int]
"""Two forms, and what their coefficients may be off."""
P, Q = (1, 0, 0), (0, 1, 0)

_FALLING = ([1] * (_SHEARED + 1), list(range(_SHEARED + 1)), [k * (k - 1) for k in range(_SHEARED + 1)])
"""What differentiating 0, 1 and 2 times multiplies a power by."""


@dataclass(frozen=True)
class Expansion:
    """G = (p, q) + N, in units of 2^−bits; each coefficient is off by at most ``error`` units."""

    forms: tuple[Mapping[Index, int], Mapping[Index, int]]
    error: int
    bits: int

    @classmethod
    def of(
        cls, first: Mapping[Index, int], second: Mapping[Index, int], errors: tuple[int, int], bits: int
    ) -> Expansion | None:
        """A constant matrix times two polynomials of any unit; None if their linear parts are dependent."""
        (a, b), (c, d) = ((form[P], form[Q]) for form in (first, second))
        determinant = a * d - b * c
        if not determinant:
            return None
        rows = ((d, -b), (-c, a))
        one, two = (
            {key: ((m * first[key] + n * second[key]) << bits) // determinant for key in first}
            for m, n in rows
        )
        off = max(
            ((abs(m) * errors[0] + abs(n) * errors[1]) << bits) // abs(determinant) + 2 for m, n in rows
        )
        return cls((one, two), off, bits)

    @cached_property
    def sizes(self) -> list[Sizes]:
        """Bounds of the coefficients of N."""
        result = []
        for form, linear in zip(self.forms, (P, Q), strict=True):
            rows: Sizes = {}
            for (i, j, k), c in {**form, linear: form[linear] - (1 << self.bits)}.items():
                rows.setdefault((i, j), [0] * (_SHEARED + 1))[k] = abs(c) + self.error
            result.append(rows)
        return result

    def coefficient(self, n: int, key: Index) -> Interval:
        """A coefficient of one of the polynomials."""
        c = self.forms[n].get(key, 0)
        return Interval(c - self.error, c + self.error, self.bits)

    def powers(self, *bounds: int) -> list[list[int]]:
        """Powers of bounds of p, q and r, rounded up."""
        result = []
        for x in bounds:
            row = [1 << self.bits]
            for _ in range(_SHEARED):
                row.append((row[-1] * x >> self.bits) + 1)
            result.append(row)
        return result

    def derivative(self, sizes: Sizes, powers: Sequence[Sequence[int]], order: Index) -> int:
        """A bound of a derivative of terms, of orders 0 to 2 in each of p, q and r."""
        total, (a, b, c), (x, y, z) = 0, order, powers
        last = list(map(mul, _FALLING[c][c:], z))
        for (i, j), row in sizes.items():
            if i >= a and j >= b:
                factor = _FALLING[a][i] * _FALLING[b][j] * x[i - a] * y[j - b]
                total += factor * sum(map(mul, row[c:], last))
        return (total >> (3 * self.bits)) + 1

    def about(self, point: Sequence[int], slopes: Sequence[int] = ()) -> Expansion | None:
        """The same about another point, p and q being counted from a line with these slopes, if any.

        None if the point is more than 1 from the origin in p, q or r, or a slope more than 1.
        """
        if max(map(abs, (*point, *slopes))) > 1 << self.bits:
            return None
        here = tuple(point)
        if here not in self._known:
            self._known[here] = self._moved((list(self.forms), self.error), here, sheared=False)
        forms, error = self._moved(self._known[here], slopes, sheared=True)
        return Expansion.of(forms[0], forms[1], (error, error), self.bits)

    @cached_property
    def _known(self) -> dict[tuple[int, ...], Moved]:
        """The forms about the points that were asked for."""
        return {}

    def _moved(self, start: Moved, steps: Sequence[int], *, sheared: bool) -> Moved:
        """The forms with p, q and r moved by these steps, or p and q along such slopes."""
        forms, error = start
        for axis, x in enumerate(steps):
            spend(5 * len(forms[0]), self.bits)
            powers = [1 << self.bits]
            for _ in range(DEGREE):
                powers.append(powers[-1] * x >> self.bits)
            greatest = max(max(map(abs, form.values())) for form in forms) + error
            forms = [self._shifted(form, axis, powers, sheared=sheared) for form in forms]
            # a sum of C(l, m) xˡ⁻ᵐ over l has at most 2⁶ · 7 in all; the powers are off by at most 6 units
            error = 448 * (error + 1) + (448 * 6 * greatest >> self.bits) + 1
        return forms, error

    def _shifted(
        self, form: Mapping[Index, int], axis: int, powers: Sequence[int], *, sheared: bool
    ) -> dict[Index, int]:
        """A form with x + w, or x + r w, in the place of the coordinate x; ``powers`` are those of w."""
        values = list(form.values())
        weights = [[comb(n, m) * powers[n - m] for m in range(n + 1)] for n in range(DEGREE + 1)]
        return {
            key: sum([values[place] * weights[n][m] for place, n, m in terms]) >> self.bits
            for key, terms in _terms(tuple(form), axis, sheared)
        }


@cache
def _terms(keys: tuple[Index, ...], axis: int, sheared: bool) -> list[tuple[Index, list[Index]]]:
    """Of what each coefficient of a shifted form is a sum: places of coefficients, and of weights."""
    result: dict[Index, list[Index]] = {} if sheared else {key: [] for key in keys}
    for place, key in enumerate(keys):
        n = key[axis]
        for m in range(n + 1):
            row = list(key)
            row[axis] = m
            row[2] += n - m if sheared else 0
            result.setdefault((row[0], row[1], row[2]), []).append((place, n, m))
    return list(result.items())


_LAYERS = 3
GUARD = 128
_MOST_BITS = 1 << 14
LENGTH = 2
"""The coordinate z."""

Square = list[list[int]]


@dataclass(frozen=True)
class Tube:
    """A tube as it is printed; the length is scaled, and the origin of an angle is an integer (s, c)."""

    parameter: int
    leg: int
    origins: tuple[tuple[int, int], tuple[int, int]]
    length: Fraction
    slopes: tuple[Fraction, Fraction]
    bends: tuple[Fraction, Fraction]
    reach: Fraction
    radii: tuple[Fraction, Fraction]

    @classmethod
    def of(cls, surface: Surface, tube: Record, at: str) -> Tube:
        """The tube of a document.

        Raises:
            InputError: naming a number that is longer than any tube needs, or no leg that is free.
        """
        length = f"l{surface.fixed}"
        if tube["leg"] not in surface.free:
            raise refusal(f"{at}/leg", "is not free")
        for name in ("half_alpha", "half_theta"):
            if not any(tube[name]):
                raise refusal(f"{at}/{name}", "is no direction")
        result = cls(
            ("alpha", "theta", length).index(tube["parameter"]),
            tube["leg"],
            (tube["half_alpha"], tube["half_theta"]),
            tube[length] * surface.unit,
            tube["slopes"],
            tube["bends"],
            tube["reach"],
            tube["radii"],
        )
        parts = (*result.slopes, *result.bends, result.length, result.reach, *result.radii)
        integers = [x for pair in (*map(Fraction.as_integer_ratio, parts), *result.origins) for x in pair]
        if max(x.bit_length() for x in integers) > _MOST_BITS:
            raise refusal(at, "has longer numbers than any tube needs")
        return result

    @property
    def bits(self) -> int:
        """Bits well below the radii."""
        least = min(*self.radii, self.reach)
        return (least.denominator // least.numerator).bit_length() + GUARD

    def length_at(self, z: Interval) -> tuple[Fraction, Fraction]:
        """The scaled lengths of an interval of z."""
        low, high = (self.length * (1 + end) for end in ends_of(z))
        return low, high

    def contains(self, box: Sequence[Interval]) -> bool:
        """Whether a box of (x, y, z) lies in the tube."""
        p, q = (box[i] for i in range(3) if i != self.parameter)
        r = box[self.parameter]
        if r.greatest > self.reach:
            return False
        for w, slope, bend, radius in zip((p, q), self.slopes, self.bends, self.radii, strict=True):
            first, second = (Interval.of(x, r.bits) for x in (slope, bend))
            if (w - r * (first + r * second)).greatest >= radius:
                return False
        return True


Coordinates = list[Interval]
"""A box of (x, y, z)."""


@dataclass(frozen=True)
class Pose:
    """A box of poses: α and θ in radians, and the scaled length."""

    alpha: Interval
    theta: Interval
    length: Interval

    def about(self, tube: Tube) -> Coordinates:
        """The box in the coordinates of a tube.

        Raises:
            ZeroDivisionError: it is too large, or half a turn away.
        """
        box = []
        for angle, origin in zip((self.alpha, self.theta), tube.origins, strict=True):
            half = Interval(angle.lower >> 1, -(-angle.upper >> 1), angle.bits)
            cos, sin = cos_sin(half)
            s, c = direction_of(origin, angle.bits)
            box.append((sin * c - cos * s).over(sin * s + cos * c))
        one = Interval.of(1, self.length.bits)
        return [*box, self.length.over(Interval.of(tube.length, self.length.bits)) - one]


def moved(box: Sequence[Interval], start: Tube, stop: Tube) -> Coordinates:
    """A box from the coordinates of one tube to those of another.

    Raises:
        ZeroDivisionError: it is too large, or half a turn away.
    """
    bits = max(start.bits, stop.bits)
    one = Interval.of(1, bits)
    result = []
    for x, (s, c), (n, d) in zip(box, start.origins, stop.origins, strict=False):
        between, w = Interval.of(Fraction(s * d - c * n, s * n + c * d), bits), x.at(bits)
        result.append((between + w).over(one - between * w))  # the tangent of a sum
    ratio = Interval.of(start.length / stop.length, bits)
    return [*result, ratio * (one + box[2].at(bits)) - one]


def direction_of(origin: tuple[int, int], bits: int) -> Pair:
    size = max(map(abs, origin))
    return Interval.of(Fraction(origin[0], size), bits), Interval.of(Fraction(origin[1], size), bits)


class Forms:
    """J, and E along either leg, as polynomials of degree 6 in tan(α/2) and tan(θ/2), by powers of L."""

    def __init__(self, surface: Surface) -> None:
        self._radicand = surface.ring.radicand
        self._singular = _layers(surface.singular)
        self._kernels = {leg.number: _layers(leg.kernel) for leg in surface.legs}
        self._known: dict[tuple[int, int], tuple[list[Square], int]] = {}

    def about(self, tube: Tube, bits: int) -> list[tuple[list[Square], int]]:
        """J and E about the origin of a tube, by powers of z, and what their coefficients may be off."""
        (up, widths), (down, heights) = (_moved(origin) for origin in tube.origins)
        n, d = tube.length.numerator, tube.length.denominator
        result = []
        for leg in (0, tube.leg):
            (c0, c1, c2), error = self._at(leg, bits)
            layers = (
                _combined(((d * d, c0), (d * n, c1), (n * n, c2))),
                _combined(((d * n, c1), (2 * n * n, c2))),
                _combined(((n * n, c2),)),
            )
            moved = [_times(_times(up, layer), list(map(list, zip(*down, strict=True)))) for layer in layers]
            result.append((moved, error * (d + 2 * n) ** 2 * widths * heights))
        return result

    def _at(self, leg: int, bits: int) -> tuple[list[Square], int]:
        """Coefficients in units of 2^−bits, off by at most the second entry."""
        if (leg, bits) not in self._known:
            layers = self._kernels[leg] if leg else self._singular
            omega = isqrt(self._radicand << (2 * bits))
            rows = [[[(a << bits) + b * omega for a, b in row] for row in layer] for layer in layers]
            error = max(abs(b) for layer in layers for row in layer for _, b in row)
            self._known[leg, bits] = rows, error
        return self._known[leg, bits]


def _layers(p: Graded) -> list[list[list[Surd]]]:
    layers = [_in_half_tangents(row) for row in p]
    empty = [[ZERO] * (DEGREE + 1)] * (DEGREE + 1)
    return layers + [empty] * (_LAYERS - len(layers))


def _in_half_tangents(p: Mapping[tuple[int, int, int, int], Surd]) -> list[list[Surd]]:
    """Row i, column k: the coefficient of tⁱ uᵏ of p (1 + t²)³ (1 + u²)³."""
    result = [[ZERO] * (DEGREE + 1) for _ in range(DEGREE + 1)]
    for cos, sin in {key[2:] for key in p}:
        part = {key: x for key, x in p.items() if key[2:] == (cos, sin)}
        column = in_half_tangent(part, DEGREE // 2, lambda _k, _m: 1)
        for (i, (a, b)), (k, factor) in product(
            enumerate(column), enumerate(half_angle_form(cos, sin, DEGREE // 2))
        ):
            c, e = result[i][k]
            result[i][k] = (c + a * factor, e + b * factor)
    return result


def _moved(origin: tuple[int, int]) -> tuple[Square, int]:
    """Row a, column i: the coefficient of xᵃ in (c x + s)ⁱ (c − s x)⁶⁻ⁱ; and the greatest sum of a row."""
    s, c = origin
    columns = []
    for i in range(DEGREE + 1):
        form = [1]
        for low, high in [(s, c)] * i + [(c, -s)] * (DEGREE - i):
            form = [low * a + high * b for a, b in zip([*form, 0], [0, *form], strict=True)]
        columns.append(form)
    rows = [list(row) for row in zip(*columns, strict=True)]
    return rows, max(sum(map(abs, row)) for row in rows)


def _combined(parts: Sequence[tuple[int, Square]]) -> Square:
    size = range(DEGREE + 1)
    return [[sum(factor * layer[i][k] for factor, layer in parts) for k in size] for i in size]


def _times(first: Square, second: Square) -> Square:
    columns = list(zip(*second, strict=True))
    return [[sum(map(int.__mul__, row, column)) for column in columns] for row in first]
