"""Where a curve in a tube turns back in the fixed length: bounds of the derivatives along it.

In a tube whose parameter r is an angle, z = L/L₀ − 1 is a function of r on the curve. For w = (p, q) on it,
G = w + N = 0 gives

    w′ = v − N_w w′ with v = −N_r,    w″ = u − N_w w″ with u = −(N_ww[w′, w′] + 2 N_wr w′ + N_rr).

Bounds |N_w| ≤ D give |w′| ≤ (1 − D)⁻¹ |v|, so w′ lies within D (1 − D)⁻¹ |v| of v; likewise w″. An arc is
halved until z′ has a sign on each part, or z″ has one and z′ one at either end (docs/mathematics.md#turns).
"""

from __future__ import annotations

from fractions import Fraction

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.expansions import Expansion, Index, P, Q
from rpr_solver.verify.tubes import LENGTH, Local

_Z = 1
"""The length is q where the parameter is an angle."""
_PARTS, _STEPS = 256, 4
_R, _RR = (0, 0, 1), (0, 0, 2)
_WR: tuple[Index, Index] = ((1, 0, 1), (0, 1, 1))
_WW: tuple[tuple[Index, Index], ...] = (((2, 0, 0), (1, 1, 0)), ((1, 1, 0), (0, 2, 0)))


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
