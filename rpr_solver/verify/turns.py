"""That a tube holds one curve, and where this turns back in the fixed length: bounds of derivatives along it.

In a tube whose parameter r is an angle, z = L/L₀ − 1 is a function of r on the curve. For w = (p, q) on it,
G = w + N = 0 gives

    w′ = v − N_w w′ with v = −N_r,    w″ = u − N_w w″ with u = −(N_ww[w′, w′] + 2 N_wr w′ + N_rr).

Bounds |N_w| ≤ D give |w′| ≤ (1 − D)⁻¹ |v|, so w′ lies within D (1 − D)⁻¹ |v| of v; likewise w″. An arc is
halved until z′ has a sign on each part, or z″ has one and z′ one at either end (docs/mathematics.md#turns).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import product

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.tubes import DEGREE, GUARD, LENGTH, Expansion, Forms, Index, P, Q, Square, Tube

_Z = 1
"""The length is q where the parameter is an angle."""
_PARTS, _STEPS = 256, 4
_R, _RR = (0, 0, 1), (0, 0, 2)
_WR: tuple[Index, Index] = ((1, 0, 1), (0, 1, 1))
_WW: tuple[tuple[Index, Index], ...] = (((2, 0, 0), (1, 1, 0)), ((1, 1, 0), (0, 2, 0)))


class Local:
    """A tube with its equations about its origin.

    Raises:
        ArithmeticError: the equations are dependent there.
    """

    def __init__(self, forms: Forms, tube: Tube) -> None:
        self.tube, bits = tube, tube.bits
        spend(4000, 2 * bits)
        (j, first), (e, second) = forms.about(tube, 2 * (bits + GUARD))
        parameter = tube.parameter
        known = Expansion.of(_by_exponents(j, parameter), _by_exponents(e, parameter), (first, second), bits)
        if known is None:
            raise ArithmeticError("the gradients are dependent")
        self.bits, self.expansion = bits, known

    def passes(self) -> bool:
        """Krawczyk's test of the tube."""
        known, tube = self.expansion, self.tube
        h, sides = self.up(tube.reach), self.sides(tube.reach)
        radii = [self.up(x) for x in tube.radii]
        powers = known.powers(sides[0] + radii[0], sides[1] + radii[1], h)
        for n, radius in enumerate(radii):
            total = self._residue(n, sides, h)
            for order, rho in zip((P, Q), radii, strict=True):
                total += (known.derivative(known.sizes[n], powers, order) * rho >> self.bits) + 1
            if total >= radius:
                return False
        return True

    def middle(self) -> list[Interval] | None:
        """A box of (x, y, z) that holds the one zero of the tube with r = 0; None if none is proved."""
        known = self.expansion
        values = [known.coefficient(n, (0, 0, 0)) for n in (0, 1)]
        radius = 2 * max(max(abs(x.lower), abs(x.upper)) for x in values) + 1
        if radius >= min(self.down(x) for x in self.tube.radii):
            return None
        powers = known.powers(radius, radius, 0)
        box = []
        for x, sizes in zip(values, known.sizes, strict=True):
            steep = sum(known.derivative(sizes, powers, order) for order in (P, Q))
            spread = (steep * radius >> self.bits) + 1
            image = Interval(-x.upper - spread, -x.lower + spread, self.bits)
            if not -radius < image.lower <= image.upper < radius:
                return None
            box.append(image)
        box.insert(self.tube.parameter, Interval(0, 0, self.bits))
        return box

    def sides(self, reach: Fraction) -> list[int]:
        """Bounds of p and q on the parabola for |r| ≤ reach."""
        pairs = zip(self.tube.slopes, self.tube.bends, strict=True)
        return [self.up(abs(slope) * reach + abs(bend) * reach**2) for slope, bend in pairs]

    def lengths(self) -> tuple[Fraction, Fraction]:
        """What holds all scaled lengths of the curve, if its parameter is an angle."""
        z = self.sides(self.tube.reach)[1] + self.up(self.tube.radii[1])
        return self.tube.length_at(Interval(-z, z, self.bits))

    def parabola(self, r: Fraction) -> list[int]:
        """p and q at one value of r, in units, rounded down."""
        pairs = zip(self.tube.slopes, self.tube.bends, strict=True)
        return [self.down(r * (slope + r * bend)) for slope, bend in pairs]

    def up(self, x: Fraction) -> int:
        """A number ≥ 0 in units, rounded up."""
        return -((-x.numerator << self.bits) // x.denominator)

    def down(self, x: Fraction) -> int:
        """A number in units, rounded down."""
        return (x.numerator << self.bits) // x.denominator

    def _residue(self, n: int, sides: Sequence[int], h: int) -> int:
        """A bound of G on the parabola: its terms of order 0 to 2 in r exactly, all others by their sizes."""
        known, tube = self.expansion, self.tube
        s, t, first, second = (Interval.of(x, self.bits) for x in (*tube.slopes, *tube.bends))

        def g(i: int, j: int, k: int) -> Interval:
            return known.coefficient(n, (i, j, k))

        once = g(0, 0, 1) + g(1, 0, 0) * s + g(0, 1, 0) * t
        twice = g(0, 0, 2) + g(1, 0, 1) * s + g(0, 1, 1) * t + g(2, 0, 0) * s * s + g(1, 1, 0) * s * t
        twice = twice + g(0, 2, 0) * t * t + g(1, 0, 0) * first + g(0, 1, 0) * second
        total = 0
        for power, term in enumerate((g(0, 0, 0), once, twice)):
            size = max(abs(term.lower), abs(term.upper))
            for _ in range(power):
                size = (size * h >> self.bits) + 1
            total += size
        powers, rest = known.powers(*sides, h), 0
        lines = [self.down(abs(slope) * tube.reach) for slope in tube.slopes]
        lines.append(self.down(tube.reach))
        for (i, j, k), c in known.forms[n].items():
            order = i + j + k
            if order < 2:
                continue
            size = powers[0][i] * powers[1][j] * powers[2][k]
            if order == 2:  # without its part of order 2 in r, which is above
                x, y = [lines[0]] * i + [lines[1]] * j + [lines[2]] * k
                size -= x * y << self.bits
            rest += (abs(c) + known.error) * size
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


def turns(local: Local, entry: Interval, exit_: Interval) -> int | None:
    """How often the length turns back on the arc of a tube between two values of r; None if that is open."""
    if local.tube.parameter == LENGTH:
        return 0
    total = 0
    parts = [(min(entry.lower, exit_.lower), max(entry.upper, exit_.upper))]
    for _ in range(_PARTS):
        low, high = parts.pop()
        found = _turns(local, low, high)
        if found is None:
            middle = (low + high) // 2
            parts += [(low, middle), (middle, high)]
        else:
            total += found
        if not parts:
            return total
    return None


def _turns(local: Local, low: int, high: int) -> int | None:
    """The same between two values of r in units of 2^−bits."""
    middle, half = (low + high) // 2, (high - low) // 2 + 1
    part = _Part.of(local, middle, half, along=False)
    slopes = part and part.slopes()
    if not slopes or not slopes[_Z].sign:
        part = _Part.of(local, middle, half, along=True)
        slopes = part and part.slopes()
    if slopes and not slopes[_Z].sign:
        part = _Part.within(local, middle, half, part)
        slopes = part and part.slopes()
    if not part or not slopes:
        return None
    if slopes[_Z].sign:
        return 0
    bends = part.bends()
    if not bends or not bends[_Z].sign:
        return None
    signs = [_sign(local, r) for r in (low, high)]
    return None if 0 in signs else int(signs[0] != signs[1])


def _sign(local: Local, r: int) -> int:
    """The sign of z′ at one value of r, 0 if it is open."""
    part = _Part.within(local, r, 0)
    slopes = part and part.slopes()
    return slopes[_Z].sign if slopes else 0


def _point(local: Local, r: int) -> tuple[list[int], list[int]] | None:
    """The point of the curve at one value of r, and how far p and q may be off."""
    point = local.parabola(Fraction(r, 1 << local.bits))
    radii = [local.up(radius) for radius in local.tube.radii]
    for _ in range(_STEPS):
        known = local.expansion.about([*point, r])
        if known is None:
            return None
        # p = −N(p, q) at the zero, which lies within the radii of the point
        powers = known.powers(*radii, 0)
        steep = [[known.derivative(sizes, powers, order) for order in (P, Q)] for sizes in known.sizes]
        off = [(a * radii[0] + b * radii[1] >> local.bits) + known.error + 2 for a, b in steep]
        if not all(new < old for new, old in zip(off, radii, strict=True)):
            break
        point = [x - known.forms[n][0, 0, 0] for n, x in enumerate(point)]
        radii = off
    return point, radii


class _Part:
    """A part of a tube: bounds of r from its middle, and of p and q from a line near the curve."""

    def __init__(self, known: Expansion, bounds: tuple[int, int, int], line: list[int]) -> None:
        self._known, self._powers, self._line = known, known.powers(*bounds), line
        one = 1 << known.bits
        (a, b), (c, d) = (
            [known.derivative(sizes, self._powers, order) for order in (P, Q)] for sizes in known.sizes
        )
        self._steepness = (a, b), (c, d)
        self._determinant = (one - a) * (one - d) - b * c if a < one and d < one else 0

    @classmethod
    def of(cls, local: Local, middle: int, half: int, *, along: bool) -> _Part | None:
        """The part with |r − middle| ≤ half, in units; None if it is too large.

        Bounds by a line along the curve are better, and dearer, than those by one along r.
        """
        tube, bounds, line = local.tube, [], []
        r, h = (Fraction(x, 1 << local.bits) for x in (middle, half))
        for slope, bend, radius in zip(tube.slopes, tube.bends, tube.radii, strict=True):
            steep = slope + 2 * r * bend
            near = max(min(steep, Fraction(1)), Fraction(-1)) if along else Fraction(0)
            line.append(local.down(near))
            bounds.append(local.up(h * (abs(steep - near) + h * abs(bend)) + radius) + local.up(h) + 2)
        known = local.expansion.about([*local.parabola(r), middle], line if along else ())
        return None if known is None else cls(known, (bounds[0], bounds[1], half), line)

    @classmethod
    def within(cls, local: Local, middle: int, half: int, wide: _Part | None = None) -> _Part | None:
        """A smaller part with the same r about a point of the curve, by the bounds of w′ in a wide one."""
        found = _point(local, middle)
        off = wide and wide._off_line()
        if found is None or (wide and not off):
            return None
        point, bounds = found
        for n, slope in enumerate(off or ()):
            bounds[n] += (max(abs(slope.lower), abs(slope.upper)) * half >> local.bits) + 1
        line = wide._line if wide else []
        known = local.expansion.about([*point, middle], line)
        return None if known is None else cls(known, (bounds[0], bounds[1], half), line)

    def slopes(self) -> list[Interval] | None:
        """All values of w′; None if there are no bounds."""
        off = self._off_line()
        if off is None or not self._line:
            return off
        return [x + Interval(s, s, x.bits) for x, s in zip(off, self._line, strict=True)]

    def _off_line(self) -> list[Interval] | None:
        """All values of w′ less the slopes of the line."""
        return self._solved([self._values(n, _R).scaled(-1) for n in (0, 1)])

    def bends(self) -> list[Interval] | None:
        """All values of w″."""
        slopes, right = self._off_line(), []
        if slopes is None:
            return None
        for n in (0, 1):
            total = self._values(n, _RR)
            for k in (0, 1):
                total += (self._values(n, _WR[k]) * slopes[k]).scaled(2)
                for m in (0, 1):
                    total += self._values(n, _WW[k][m]) * slopes[k] * slopes[m]
            right.append(total.scaled(-1))
        return self._solved(right)

    def _values(self, n: int, order: Index) -> Interval:
        """All values of a derivative of N, by its constant term and the sizes of the others."""
        known, factor = self._known, 2 if 2 in order else 1
        sizes, constant = known.sizes[n], known.coefficient(n, order).scaled(factor)
        own = sizes[order[:2]][order[2]] if order[:2] in sizes else 0
        radius = known.derivative(sizes, self._powers, order) - factor * own
        return Interval(constant.lower - radius, constant.upper + radius, known.bits)

    def _solved(self, right: list[Interval]) -> list[Interval] | None:
        """All w with w = right − N_w w."""
        if self._determinant <= 0:
            return None
        (a, b), (c, d) = self._steepness
        bits = self._known.bits
        one = 1 << bits
        x, y = (max(abs(v.lower), abs(v.upper)) for v in right)
        p = (((one - d) * x + b * y) << bits) // self._determinant + 1
        q = ((c * x + (one - a) * y) << bits) // self._determinant + 1
        result = []
        for v, (first, second) in zip(right, self._steepness, strict=True):
            off = ((first * p + second * q) >> bits) + 1
            result.append(Interval(v.lower - off, v.upper + off, bits))
        return result
