"""Tubes of a full certificate: each holds one point of J = E = 0 for each value of its parameter.

About the origin of a tube, x = tan((α − α₀)/2), y = tan((θ − θ₀)/2) and z = L/L₀ − 1 are coordinates in which
J and E, times powers of (1 + x²) and (1 + y²), are polynomials. One of x, y, z is the parameter r, the other
two are p and q. With a constant matrix A, A (J, E) = G = (p, q) + N. If on the parabola (p̂, q̂)(r), for
|r| ≤ h, |G| + |N′| ρ < ρ, with bounds |N′| of ∂N/∂(p, q) over the tube of radii ρ, it holds exactly one zero
for each r: Krawczyk's test. Coefficients are integers in units of 2^−bits, and all bounds are sums
of absolute values, rounded up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import isqrt

from rpr_solver.verify.core.intervals import Interval, cos_sin, ends_of
from rpr_solver.verify.core.krawczyk import Pair
from rpr_solver.verify.core.reader import Record, refusal, spend
from rpr_solver.verify.core.surds import ZERO, Surd
from rpr_solver.verify.core.system import Graded, Surface, half_angle_form, in_half_tangent

DEGREE = 6
"""The greatest exponent of p, of q and of r."""
Index = tuple[int, int, int]
"""The exponents of p, q and r."""
P, Q = (1, 0, 0), (0, 1, 0)

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

    def holds(self, box: Sequence[Interval]) -> bool | None:
        """Whether a box of (x, y, z) lies in the tube; False if none of it does, None if that is open."""
        p, q = (box[i] for i in range(3) if i != self.parameter)
        r, sides = box[self.parameter], list[bool | None]()
        offsets = [(r, self.reach)]
        for w, slope, bend, radius in zip((p, q), self.slopes, self.bends, self.radii, strict=True):
            first, second = (Interval.of(x, r.bits) for x in (slope, bend))
            offsets.append((w - r * (first + r * second), radius))
        for x, bound in offsets:
            open_or_none = None if x.meets(Interval.of(0, x.bits, bound)) else False
            sides.append(x.inside(-bound, bound) or open_or_none)
        return False if False in sides else None if None in sides else True


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


class Local:
    """A tube with G = (p, q) + N about its origin, in units of 2^−bits; coefficients are off by ``error``.

    Raises:
        ArithmeticError: the equations are dependent there.
    """

    def __init__(self, forms: Forms, tube: Tube) -> None:
        self.tube, self.bits = tube, tube.bits
        spend(4000, 2 * self.bits)
        layers, errors = zip(*forms.about(tube, 2 * (self.bits + GUARD)), strict=True)
        first, second = (_by_exponents(part, tube.parameter) for part in layers)
        determinant = first[P] * second[Q] - first[Q] * second[P]
        if not determinant:
            raise ArithmeticError("the gradients are dependent")
        matrix = (second[Q], -first[Q]), (-second[P], first[P])
        self.forms = [
            {key: ((m * first[key] + n * second[key]) << self.bits) // determinant for key in first}
            for m, n in matrix
        ]
        off = [abs(m) * errors[0] + abs(n) * errors[1] for m, n in matrix]
        self.error = (max(off) << self.bits) // abs(determinant) + 2

    def passes(self) -> bool:
        """Krawczyk's test of the tube."""
        tube = self.tube
        h, sides = self.up(tube.reach), self._sides()
        radii = [self.up(x) for x in tube.radii]
        powers = self._powers(sides[0] + radii[0], sides[1] + radii[1], h)
        for n, radius in enumerate(radii):
            steep = self._steepness(n, powers)
            spread = sum((x * rho >> self.bits) + 1 for x, rho in zip(steep, radii, strict=True))
            if self._residue(n, sides, h) + spread >= radius:
                return False
        return True

    def middle(self) -> list[Interval] | None:
        """A box of (x, y, z) that holds the one zero of the tube with r = 0; None if none is proved."""
        values = [self._coefficient(n, (0, 0, 0)) for n in (0, 1)]
        radius = 2 * max(max(abs(x.lower), abs(x.upper)) for x in values) + 1
        if radius >= min(self.down(x) for x in self.tube.radii):
            return None
        powers = self._powers(radius, radius, 0)
        box = []
        for n, x in enumerate(values):
            spread = (sum(self._steepness(n, powers)) * radius >> self.bits) + 1
            image = Interval(-x.upper - spread, -x.lower + spread, self.bits)
            if not -radius < image.lower <= image.upper < radius:
                return None
            box.append(image)
        box.insert(self.tube.parameter, Interval(0, 0, self.bits))
        return box

    def lengths(self) -> tuple[Fraction, Fraction]:
        """What holds all scaled lengths of the curve, if its parameter is an angle."""
        z = self._sides()[1] + self.up(self.tube.radii[1])
        return self.tube.length_at(Interval(-z, z, self.bits))

    def up(self, x: Fraction) -> int:
        """A number ≥ 0 in units, rounded up."""
        return -((-x.numerator << self.bits) // x.denominator)

    def down(self, x: Fraction) -> int:
        """A number in units, rounded down."""
        return (x.numerator << self.bits) // x.denominator

    def _sides(self) -> list[int]:
        """Bounds of p and q on the parabola."""
        reach, pairs = self.tube.reach, zip(self.tube.slopes, self.tube.bends, strict=True)
        return [self.up(abs(slope) * reach + abs(bend) * reach**2) for slope, bend in pairs]

    def _coefficient(self, n: int, key: Index) -> Interval:
        """A coefficient of one of the polynomials."""
        c = self.forms[n].get(key, 0)
        return Interval(c - self.error, c + self.error, self.bits)

    def _powers(self, *bounds: int) -> list[list[int]]:
        """Powers of bounds of p, q and r, rounded up."""
        result = []
        for x in bounds:
            row = [1 << self.bits]
            for _ in range(DEGREE):
                row.append((row[-1] * x >> self.bits) + 1)
            result.append(row)
        return result

    def _steepness(self, n: int, powers: Sequence[Sequence[int]]) -> list[int]:
        """Bounds of the derivatives of a part of N in p and in q."""
        totals, (x, y, z) = [0, 0], powers
        for (i, j, k), c in self.forms[n].items():
            size = (abs(c - (1 << self.bits) if (i, j, k) == (P, Q)[n] else c) + self.error) * z[k]
            totals[0] += i * size * x[i - 1] * y[j] if i else 0
            totals[1] += j * size * x[i] * y[j - 1] if j else 0
        return [(total >> (3 * self.bits)) + 1 for total in totals]

    def _residue(self, n: int, sides: Sequence[int], h: int) -> int:
        """A bound of G on the parabola: its terms of order 0 to 2 in r exactly, all others by their sizes."""
        tube = self.tube
        s, t, first, second = (Interval.of(x, self.bits) for x in (*tube.slopes, *tube.bends))

        def g(i: int, j: int, k: int) -> Interval:
            return self._coefficient(n, (i, j, k))

        once = g(0, 0, 1) + g(1, 0, 0) * s + g(0, 1, 0) * t
        twice = g(0, 0, 2) + g(1, 0, 1) * s + g(0, 1, 1) * t + g(2, 0, 0) * s * s + g(1, 1, 0) * s * t
        twice = twice + g(0, 2, 0) * t * t + g(1, 0, 0) * first + g(0, 1, 0) * second
        total = 0
        for power, term in enumerate((g(0, 0, 0), once, twice)):
            size = max(abs(term.lower), abs(term.upper))
            for _ in range(power):
                size = (size * h >> self.bits) + 1
            total += size
        powers, rest = self._powers(*sides, h), 0
        lines = [self.down(abs(slope) * tube.reach) for slope in tube.slopes]
        lines.append(self.down(tube.reach))
        for (i, j, k), c in self.forms[n].items():
            order = i + j + k
            if order < 2:
                continue
            size = powers[0][i] * powers[1][j] * powers[2][k]
            if order == 2:  # without its part of order 2 in r, which is above
                x, y = [lines[0]] * i + [lines[1]] * j + [lines[2]] * k
                size -= x * y << self.bits
            rest += (abs(c) + self.error) * size
        return total + (rest >> (3 * self.bits)) + 1


def _by_exponents(layers: Sequence[Square], parameter: int) -> dict[Index, int]:
    """Coefficients by the exponents of p, q and r."""
    result = {}
    for k, layer in enumerate(layers):
        for (a, row), b in product(enumerate(layer), range(DEGREE + 1)):
            powers = [a, b, k]
            r = powers.pop(parameter)
            result[powers[0], powers[1], r] = row[b]
    return result
