"""Poses that are singular for every length of the fixed leg: the lengths at which they are degenerate.

With the fixed leg along e, J = 0 for every length where

- all three legs are parallel: (m z − a) × e = (n z − b) × e = 0;
- e and m z are parallel to a, or e and n z to b: the gradient of f, or of g, is 0;
- (m − n) z is parallel to a − b, and e to (m b − n a) / (m − n): all legs meet in one point.

Each is known exactly over ℚ(ω, κ), κ being a square root, but for the length of e
(mathematics.md#exact-lines). With the leg in units of
that length, the slopes of J are of degree 1 in the leg, E and v·∇E of degrees 2 and 3. The pose is degenerate
where both slopes are 0, or E and v·∇E along both legs; and it is a cusp at a joint limit only where E along
both legs is 0, and the squared length of the free leg is that of the limit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import gcd

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Directions
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.roots import square_root
from rpr_solver.verify.core.surds import ONE, ZERO, Ring, Surd, negative, plus
from rpr_solver.verify.core.system import Graded, Surface
from rpr_solver.verify.landmarks import Event, Landmark, Unclear, cusps_beside, kind_of

Number = tuple[Surd, Surd]
"""a + b κ."""


@dataclass(frozen=True)
class Field:
    """ℤ[ω, κ] with κ = √square ≥ 0."""

    ring: Ring
    square: Surd

    def times(self, x: Number, y: Number) -> Number:
        """The product of two numbers."""
        (a, b), (c, d), times = x, y, self.ring.times
        if b == d == ZERO:
            return times(a, c), ZERO
        return plus(times(a, c), times(self.square, times(b, d))), plus(times(a, d), times(b, c))

    def sign(self, x: Number) -> int:
        """−1, 0 or 1."""
        a, b = x
        first, second = self.ring.sign(a), self.ring.sign(b) * self.ring.sign(self.square)
        if first * second >= 0:
            return first or second
        own, other = self.ring.times(a, a), self.ring.times(self.square, self.ring.times(b, b))
        return first * self.ring.sign((own[0] - other[0], own[1] - other[1]))

    def interval(self, x: Number, bits: int) -> Interval:
        """The number, in a small interval."""
        omega = Interval.of(self.ring.radicand, bits).root()
        a, b, k = (Interval.of(p, bits) + omega.scaled(q) for p, q in (*x, self.square))
        return a + b * k.root() if x[1] != ZERO else a

    def quotient(self, x: Number, y: Number) -> tuple[object, ...]:
        """A name of x / y that is the same for equal numbers over ℚ(ω), or with the same κ."""
        (c, d), square = y, self.square
        above = self.times(x, (c, (-d[0], -d[1])))
        below, _ = self.times(y, (c, (-d[0], -d[1])))
        p, q = below
        norm = p * p - self.ring.radicand * q * q
        parts = [self.ring.times(part, (p, -q)) for part in above]
        values = [Fraction(n, norm) for part in parts for n in part]
        return (*values[:2],) if not any(values[2:]) else (*values, square)


def difference(x: Number, y: Number) -> Number:
    """x − y."""
    return plus(x[0], negative(y[0])), plus(x[1], negative(y[1]))


def _shortened(field: Field, p: list[Number]) -> list[Number]:
    """Without leading zeros, and without an integer divisor."""
    while p and not field.sign(p[-1]):
        p = p[:-1]
    divisor = gcd(*(part for x in p for surd in x for part in surd)) or 1
    return [((a // divisor, b // divisor), (c // divisor, d // divisor)) for (a, b), (c, d) in p]


def gcd_of(field: Field, p: list[Number], q: list[Number]) -> list[Number]:
    """A greatest common divisor; one that is empty stands for 0."""
    p, q = sorted((p, q), key=len, reverse=True)
    while q:
        rest = p
        while len(rest) >= len(q):
            shift = len(rest) - len(q)
            spend(16 * len(rest), max(part.bit_length() for surd in (*rest[-1], *q[-1]) for part in surd))
            shifted = [(ZERO, ZERO)] * shift + [field.times(rest[-1], x) for x in q]
            rest = [difference(field.times(q[-1], x), y) for x, y in zip(rest, shifted, strict=True)]
            rest = _shortened(field, rest[:-1])
        p, q = q, rest
    return p


Vector = tuple[Surd, Surd]
"""x + i y over ℤ[ω]."""
_SPARE_BITS, _MOST_DEGREE = 256, 2


@dataclass(frozen=True)
class Permanent:
    """A pose with exp(iα) = (X + iY)/D and the fixed leg along U + iV, or against it."""

    field: Field
    turn: tuple[Number, Number, Number]
    along: tuple[Number, Number]

    @cached_property
    def _square(self) -> Number:
        """|U + iV|²."""
        (a, b), (c, d) = (self.field.times(x, x) for x in self.along)
        return plus(a, c), plus(b, d)

    @property
    def name(self) -> object:
        """A name that is the same for equal poses over ℚ(ω), but for the sense of the leg."""
        (x, y, d), (u, w) = self.turn, self.along
        slope = self.field.quotient(w, u) if self.field.sign(u) else None
        return self.field.quotient(x, d), self.field.quotient(y, d), slope

    def in_length(self, p: Graded, shift: int) -> list[Number]:
        """A multiple of a polynomial, by powers of the length in units of |U + iV|.

        Args:
            p: its coefficient of the k-th power has degree k + ``shift`` in θ, and terms of one parity.
            shift: 1 for J and what follows from it, 0 for squared lengths.
        """
        times = self.field.times
        x, y, d = self.turn
        degree = max((i + j for row in p for i, j, _, _ in row), default=0)
        result = []
        for k, row in enumerate(p):
            total: Number = (ZERO, ZERO)
            for (i, j, c, s), surd in row.items():
                rest, odd = divmod(k + shift - c - s, 2)
                if odd or rest < 0:
                    raise ArithmeticError("a form in the direction of the leg is not homogeneous")
                term: Number = (surd, ZERO)
                factors = (x, i), (y, j), (d, degree - i - j), (self.along[0], c), (self.along[1], s)
                for factor, power in (*factors, (self._square, rest)):
                    spend(4 * power, max(part.bit_length() for part in (*surd, *factor[0])))
                    for _ in range(power):
                        term = times(term, factor)
                total = plus(total[0], term[0]), plus(total[1], term[1])
            result.append(total)
        return _shortened(self.field, result)

    def lengths(self, polynomials: Sequence[Sequence[Number]], bits: int) -> Iterator[Resting]:
        """Where polynomials in the length vanish, for the leg along U + iV or against it, but for 0.

        Raises:
            Unclear: all vanish for every length, or they have three common roots.
        """
        field, common = self.field, list[Number]()
        for p in polynomials:
            common = gcd_of(field, common, list(p))
        while common and not field.sign(common[0]):
            common = common[1:]
        if not common or len(common) > _MOST_DEGREE + 1:
            raise Unclear
        if len(common) == 1:
            return
        size = max(part.bit_length() for x in (*common, self._square) for surd in x for part in surd)
        work = 4 * size + 2 * bits + _SPARE_BITS
        *_, first, last = (field.interval(x, work) for x in common)
        unit, times = field.interval(self._square, work).root(), field.times
        if len(common) == 3:
            b, double = common[1], ((2, 0), ZERO)
            discriminant = difference(times(b, b), times(((4, 0), ZERO), times(common[0], common[2])))
            sign = field.sign(discriminant)
            if sign < 0:
                return
            if sign > 0:
                root, below = field.interval(discriminant, work).root(), times(double, common[2])
                square = field.quotient(times(discriminant, self._square), times(below, below))
                exact = None if field.sign(b) else square  # that of both
                for side in (root, root.scaled(-1)):
                    ratio = (side - first).over(last.scaled(2))
                    yield Resting(Landmark(_positive(ratio * unit), exact), self, tuple(common), ratio.sign)
                return
            common = [b, times(double, common[2])]
        above, below = common
        ratio = field.interval(above, work).over(field.interval(below, work))
        exact = field.quotient(times(times(above, above), self._square), times(below, below))
        yield Resting(Landmark(_positive(ratio * unit), exact), self, tuple(common), -ratio.sign)

    def directions(self, sign: int, bits: int) -> Directions:
        """α, and θ along U + iV or against it."""
        x, y, d, u, w = (self.field.interval(part, bits) for part in (*self.turn, *self.along))
        size = (u * u + w * w).root()
        theta = u.scaled(sign).over(size), w.scaled(sign).over(size)
        return Directions((x.over(d), y.over(d)), theta, self.field.ring.radicand)

    def is_same(self, other: Permanent) -> bool:
        """Whether two poses are one, but for the sense of the leg.

        Raises:
            Unclear: they may be one, of different fields.
        """
        if self.field != other.field:
            own, its = (pose.directions(1, _SPARE_BITS).alpha for pose in (self, other))
            if all(a.meets(b) for a, b in zip(own, its, strict=True)):
                raise Unclear
            return False
        pairs = zip((*self.turn[:2], self.along[0]), (*other.turn[:2], other.along[0]), strict=True)
        below = (self.turn[2],) * 2 + (self.along[1],), (other.turn[2],) * 2 + (other.along[1],)
        times = self.field.times
        return not any(
            self.field.sign(difference(times(a, y), times(b, x)))
            for (a, b), x, y in zip(pairs, *below, strict=True)
        )


@dataclass(frozen=True)
class Resting:
    """A length of a permanent pose, a root of ``common``; the leg is along U + iV, or against it (−1)."""

    landmark: Landmark
    pose: Permanent
    common: tuple[Number, ...]
    sign: int

    def vanishes(self, p: Graded, shift: int) -> bool:
        """Whether a polynomial is exactly 0; its ``shift`` is as for :meth:`Permanent.in_length`.

        Raises:
            Unclear: it is at one of two lengths.
        """
        shared = gcd_of(self.pose.field, list(self.common), self.pose.in_length(p, shift))
        if 1 < len(shared) < len(self.common):
            raise Unclear
        return len(shared) == len(self.common)

    def event(self, surface: Surface) -> Landmark:
        """The event, if its kind is told."""
        here = self.pose.directions(self.sign, self.landmark.scaled.bits)
        try:
            kind = kind_of(surface, here, self.landmark.scaled, self.vanishes)
            sign = self.pose.field.sign
            zeros = {"alpha_deg"} if not sign(self.pose.turn[1]) else set()
            zeros |= {f"theta{surface.fixed}_deg"} if not sign(self.pose.along[1]) else set()
            zeros |= {f"l{leg.number}" for leg in surface.legs if self.vanishes(leg.squared, 0)}
            if kind is None:
                return self.landmark
            number = cusps_beside(surface, kind, here, self.landmark.scaled, self.vanishes)
        except Unclear:
            return self.landmark
        return Event.at(kind, here, self.landmark, zeros, (number, number))


def _positive(x: Interval) -> Interval:
    return x.scaled(-1) if x.sign < 0 else x


@dataclass(frozen=True)
class Vectors:
    """a, b: from the fixed leg's base point to those of the free legs; m, n: likewise on the platform."""

    ring: Ring
    a: Vector
    b: Vector
    m: Vector
    n: Vector

    @classmethod
    def of(cls, surface: Surface) -> Vectors:
        """Those of a manipulator and its fixed leg, scaled."""
        geometry, here, unit = surface.geometry, surface.fixed - 1, surface.unit
        factor, radicand = geometry.height
        top = int(factor * unit)
        corners: list[Vector] = [
            (ZERO, ZERO),
            ((int(geometry.d1 * unit), 0), ZERO),
            ((int(geometry.foot * unit), 0), (top, 0) if radicand == 1 else (0, top)),
        ]
        base: list[Vector] = [((int(x * unit), 0), (int(y * unit), 0)) for x, y in geometry.base]
        legs = [leg - 1 for leg in geometry.free_legs(surface.fixed)]
        sides = [_minus(points[leg], points[here]) for points in (base, corners) for leg in legs]
        return cls(surface.ring, *sides)

    def times(self, x: Vector, y: Vector) -> Vector:
        """The product of two complex numbers."""
        (a, b), (c, d), times = x, y, self.ring.times
        return plus(times(a, c), negative(times(b, d))), plus(times(a, d), times(b, c))


def permanent_poses(surface: Surface) -> list[Permanent]:
    """All of them, each once, and one of two opposite ones.

    Raises:
        Unclear: they are not isolated, or not told apart.
    """
    v = Vectors.of(surface)
    base, side = _minus(v.a, v.b), _minus(v.m, v.n)
    meeting = v.times(_minus(v.times(v.m, v.b), v.times(v.n, v.a)), conjugate(side))
    poses = []
    for along, platform, ground in ((v.a, v.m, v.a), (v.b, v.n, v.b), (meeting, side, base)):
        turned = v.times(ground, conjugate(platform))
        (size, _) = v.times(turned, conjugate(turned))
        for sign in (1, -1):
            x, y = ((_multiple(part, sign), ZERO) for part in turned)
            poses.append(_pose(v.ring, size, (x, y, (ZERO, ONE)), (plain(along[0]), plain(along[1]))))
    poses += _parallel(v)
    return [pose for n, pose in enumerate(poses) if not any(pose.is_same(other) for other in poses[:n])]


def _parallel(v: Vectors) -> Iterator[Permanent]:
    """Those with (m z − a) × (n z − b) = r − p cos α − q sin α = 0."""
    times = v.ring.times
    mixed = _minus(v.times(conjugate(v.m), v.b), v.times(v.a, conjugate(v.n)))
    r = plus(v.times(conjugate(v.m), v.n)[1], v.times(conjugate(v.a), v.b)[1])
    # Im(conj(z) (conj(m) b − a conj(n))) = Im(mixed) cos α − Re(mixed) sin α
    p, q = mixed[1], negative(mixed[0])
    square = plus(times(p, p), times(q, q))
    rest = plus(square, negative(times(r, r)))
    if v.ring.sign(rest) < 0:
        return
    for sign in (1, -1) if v.ring.sign(rest) else (1,):
        x = times(p, r), _multiple(q, -sign)
        y = times(q, r), _multiple(p, sign)
        field = Field(v.ring, rest)
        for platform, ground in ((v.m, v.a), (v.n, v.b)):
            along = []
            for part, (first, second), sense in ((0, (x, y), 1), (1, (y, x), -1)):
                turned = difference(
                    field.times(plain(platform[0]), first),
                    field.times(plain(_multiple(platform[1], sense)), second),
                )
                along.append(difference(turned, plain(times(ground[part], square))))
            if any(map(field.sign, along)):
                break
        yield _pose(v.ring, rest, (x, y, plain(square)), (along[0], along[1]))


def _pose(
    ring: Ring, square: Surd, turn: tuple[Number, Number, Number], along: tuple[Number, Number]
) -> Permanent:
    """A pose, over ℚ(ω) if the square is one there.

    Raises:
        Unclear: there is no such pose, or its direction is any.
    """
    field, root = Field(ring, square), square_root(ring, square)
    if root is not None:
        (x, y, d), (u, w) = ([plain(plus(a, ring.times(b, root))) for a, b in xs] for xs in (turn, along))
        field, turn, along = replace(field, square=ONE), (x, y, d), (u, w)
    if not field.sign(turn[2]) or not any(map(field.sign, along)):
        raise Unclear
    return Permanent(field, turn, along)


def plain(x: Surd) -> Number:
    return x, ZERO


def _multiple(x: Surd, factor: int) -> Surd:
    return x[0] * factor, x[1] * factor


def _minus(x: Vector, y: Vector) -> Vector:
    return plus(x[0], negative(y[0])), plus(x[1], negative(y[1]))


def conjugate(x: Vector) -> Vector:
    """The conjugate of a complex number."""
    return x[0], negative(x[1])
