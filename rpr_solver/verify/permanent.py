"""Poses that are singular for every length of the fixed leg: shown to be no events, and at no joint limit.

With the fixed leg along e, J = 0 for every length where

- all three legs are parallel: (m z − a) × e = (n z − b) × e = 0;
- e and m z are parallel to a, or e and n z to b: the gradient of f, or of g, is 0;
- (m − n) z is parallel to a − b, and e to (m b − n a) / (m − n): all legs meet in one point.

At such a pose the slopes of J are of degree 1 in the length, E and v·∇E of degrees 2 and 3. It is degenerate
for some length only if both slopes have a common root, or E and v·∇E along both legs; and it is a cusp at a
joint limit only if E along both legs, and the squared length of the leg less that of the limit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Directions, Pair
from rpr_solver.verify.core.system import Graded, Surface

_BITS = 256
Vector = tuple[Interval, Interval]


class Unclear(Exception):  # noqa: N818 - a verdict, not a fault
    """Intervals do not tell where these poses are."""


def never_degenerate(surface: Surface) -> bool:
    """Whether intervals prove that no pose that is singular for every length is degenerate for any.

    A pose and its opposite, with θ + 180° and the length −L, are one.
    """
    try:
        return all(_never(surface, pose) for pose in _poses(surface))
    except (Unclear, ZeroDivisionError, ValueError):
        return False


def never_at_limit(surface: Surface, squared: Graded) -> bool:
    """Whether intervals prove that no pose that is singular for every length is a cusp at a joint limit.

    Args:
        surface: the equations.
        squared: the squared length of a free leg, less that of its limit.
    """
    try:
        return all(
            any(_coprime(_in_length(pose, leg.kernel), _in_length(pose, squared)) for leg in surface.legs)
            for pose in _poses(surface)
        )
    except (Unclear, ZeroDivisionError, ValueError):
        return False


def _in_length(pose: Directions, p: Graded) -> list[Interval]:
    return [pose.value(row) for row in p]


def _never(surface: Surface, pose: Directions) -> bool:
    slopes = [_in_length(pose, p) for p in surface.slopes]
    if not _coprime(*slopes):
        return False
    conditions = [_in_length(pose, p) for leg in surface.legs for p in (leg.kernel, leg.kernel2)]
    return any(_coprime(p, q) for p, q in combinations(conditions, 2))


def _coprime(p: Sequence[Interval], q: Sequence[Interval]) -> bool:
    """Whether Sylvester's determinant excludes 0, so that two polynomials have no common root, even at ∞."""
    m, n = len(p) - 1, len(q) - 1
    zero = Interval(0, 0, p[0].bits)
    rows = [[zero] * k + list(reversed(p)) + [zero] * (n - 1 - k) for k in range(n)]
    rows += [[zero] * k + list(reversed(q)) + [zero] * (m - 1 - k) for k in range(m)]
    return bool(rows) and bool(_determinant(rows).sign)


def _determinant(rows: list[list[Interval]]) -> Interval:
    if len(rows) == 1:
        return rows[0][0]
    total = Interval(0, 0, rows[0][0].bits)
    for k, row in enumerate(rows):
        if row[0].lower or row[0].upper:
            term = row[0] * _determinant([other[1:] for i, other in enumerate(rows) if i != k])
            total = total - term if k % 2 else total + term
    return total


@dataclass(frozen=True)
class _Vectors:
    """a, b: from the fixed leg's base point to those of the free legs; m, n: likewise on the platform."""

    a: Vector
    b: Vector
    m: Vector
    n: Vector

    @classmethod
    def of(cls, surface: Surface) -> _Vectors:
        geometry, fixed = surface.geometry, surface.fixed
        factor, radicand = geometry.height
        omega = Interval.of(radicand, _BITS).root() if radicand != 1 else Interval.of(1, _BITS)
        zero = Interval.of(0, _BITS)
        corners = (
            (zero, zero),
            (Interval.of(geometry.d1, _BITS), zero),
            (Interval.of(geometry.foot, _BITS), omega * Interval.of(factor, _BITS)),
        )
        base = [(Interval.of(x, _BITS), Interval.of(y, _BITS)) for x, y in geometry.base]
        first, second = (leg - 1 for leg in geometry.free_legs(fixed))
        here = fixed - 1
        return cls(
            _minus(base[first], base[here]),
            _minus(base[second], base[here]),
            _minus(corners[first], corners[here]),
            _minus(corners[second], corners[here]),
        )


def _poses(surface: Surface) -> Iterator[Directions]:
    """All of them, one of two opposite ones each."""
    v, radicand = _Vectors.of(surface), surface.ring.radicand
    base, side = _minus(v.a, v.b), _minus(v.m, v.n)
    meeting = _times(_minus(_times(v.m, v.b), _times(v.n, v.a)), _conjugate(side))
    for direction, platform, ground in ((v.a, v.m, v.a), (v.b, v.n, v.b), (meeting, side, base)):
        turned = _unit(_times(ground, _conjugate(platform)))
        for alpha in (turned, (turned[0].scaled(-1), turned[1].scaled(-1))):
            yield Directions(alpha, _unit(direction), radicand)
    for alpha in _parallel(v):
        along = _minus(_times(v.m, alpha), v.a)
        yield Directions(alpha, _unit(along), radicand)


def _parallel(v: _Vectors) -> Iterator[Pair]:
    """The z of (m z − a) × (n z − b) = 0, which is r − p cos α − q sin α."""
    mixed = _minus(_times(_conjugate(v.m), v.b), _times(v.a, _conjugate(v.n)))
    r = _imaginary(_times(_conjugate(v.m), v.n)) + _imaginary(_times(_conjugate(v.a), v.b))
    # Im(conj(z) (conj(m) b − a conj(n))) = Im(mixed) cos α − Re(mixed) sin α
    p, q = mixed[1], mixed[0].scaled(-1)
    square = p * p + q * q
    rest = square - r * r
    if rest.sign < 0:
        return
    if not rest.sign:
        raise Unclear
    root = rest.root()
    for sign in (1, -1):
        s = root.scaled(sign)
        yield (p * r - q * s).over(square), (q * r + p * s).over(square)


def _minus(x: Vector, y: Vector) -> Vector:
    return x[0] - y[0], x[1] - y[1]


def _times(x: Vector, y: Vector) -> Vector:
    return x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0]


def _conjugate(x: Vector) -> Vector:
    return x[0], x[1].scaled(-1)


def _imaginary(x: Vector) -> Interval:
    return x[1]


def _unit(x: Vector) -> Pair:
    """The direction of a vector.

    Raises:
        ZeroDivisionError: it may be 0.
    """
    size = (x[0] * x[0] + x[1] * x[1]).root()
    return x[0].over(size), x[1].over(size)
