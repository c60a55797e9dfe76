"""All poses with three given data of legs: the closure of the legs, one polynomial in a half tangent.

Leg i is the vector V_i = p + w_i, p being B1, and w_i = R b_i − A_i turning with the platform. Its length
says |V_i|² = L_i²; its angle, with the unit vector u_i, says V_i × u_i = 0, and V_i · u_i > 0. Two data give
p as a quotient of polynomials in the half tangent t of α, and the third one then a polynomial in t:

    length and angle of leg i        p = L_i u_i − w_i                            degree 2
    angles of legs i and j           p from two lines                             degree 2 with an angle,
                                                                                  4 with a length
    lengths of i and j, angle of k   V_i from a line, and 2 V_i·(w_j − w_i) = …   degree 6

Where the two data do not give p, since lines are parallel or the equations depend on each other, α has the
roots of another polynomial, and p is on a line and a circle (mathematics.md#poses-from-lengths-and-angles).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias

from flint import arb, ctx

from rpr_solver.errors import ControlFlow, Unproved
from rpr_solver.exact.precision import precisions
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.sensed.reals import GREATEST_BITS, Reals
from rpr_solver.workspaces.curves import (
    common_divisor,
    real_roots,
    squarefree,
    unit_vectors,
)
from rpr_solver.workspaces.tower import Open

_FIRST_BITS = 128
_BEFORE_EXACT = 512
"""Roots that are still together are most likely one, which a common divisor decides."""

Poly: TypeAlias = tuple[Any, ...]
"""Coefficients of t⁰, t¹, …"""
Vector: TypeAlias = tuple[Any, Any]
Pair: TypeAlias = tuple[arb, arb]
_Turn: TypeAlias = tuple[Fraction, Fraction]


class Curve(ControlFlow):
    """The data are fulfilled along a whole curve of poses."""


@dataclass(frozen=True)
class Legs:
    """A manipulator in the frame of the article, and what is known of its legs.

    Attributes:
        reals: the numbers.
        base, platform: A1, A2, A3, and B1, B2, B3 at α = 0.
        lengths: leg → length.
        turns: leg → u, the unit vector of its angle.
        parallel: pairs of legs whose angles are equal, or opposite.
    """

    reals: Reals
    base: Sequence[Vector]
    platform: Sequence[Vector]
    lengths: Mapping[int, Fraction]
    turns: Mapping[int, Vector]
    parallel: frozenset[frozenset[int]]

    def around(self, leg: int, turn: _Turn) -> tuple[Poly, Poly]:
        """w of a leg times 1 + t², with α measured from a direction."""
        (x, y), (a, b) = self.platform[leg - 1], self.base[leg - 1]
        u, v = turn
        c, s = (u, -2 * v, -u), (v, 2 * u, -v)
        one = (1, 0, 1)
        return (
            tuple(x * p - y * q - a * k for p, q, k in zip(c, s, one, strict=True)),
            tuple(x * q + y * p - b * k for p, q, k in zip(c, s, one, strict=True)),
        )

    def around_ball(self, leg: int, turned: Pair, bits: int) -> Pair:
        """w of a leg, from cos α and sin α."""
        (x, y), (a, b) = (
            tuple(z.ball(bits) for z in corner) for corner in (self.platform[leg - 1], self.base[leg - 1])
        )
        c, s = turned
        return x * c - y * s - a, x * s + y * c - b

    def turn_ball(self, leg: int, bits: int) -> Pair:
        """u of a leg."""
        u, v = self.turns[leg]
        return u.ball(bits), v.ball(bits)


Places: TypeAlias = Callable[[Pair, int], Pair]
"""B1 from cos α and sin α, at a precision."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A pose that fulfils three data, but perhaps not the senses of angles.

    Attributes:
        root: the roots among which t is.
        number: that of t.
        place: gives B1.
    """

    root: Roots
    number: int
    place: Places

    def pose(self, bits: int) -> tuple[Pair, Pair]:
        """cos α and sin α, and B1."""
        with ctx.workprec(bits):
            turned = self.root.turned(self.number, bits)
            return turned, self.place(turned, bits)


@dataclass(frozen=True, eq=False)
class Roots:
    """The real roots of a polynomial in t.

    Attributes:
        turn: the direction from which α is measured, in which t is never ∞.
        polynomial: with a leading coefficient that is not 0.
        is_exact: whether its coefficients are compared exactly.
    """

    turn: _Turn
    polynomial: Poly
    is_exact: bool

    @cached_property
    def simple(self) -> Poly:
        """A polynomial with the same roots, all of which are simple."""
        try:
            for bits in precisions(_FIRST_BITS, _BEFORE_EXACT if self.is_exact else GREATEST_BITS):
                try:
                    self._found(self.polynomial, bits)
                except Open:
                    continue
                return self.polynomial
            if self.is_exact:
                return squarefree(self.polynomial)
        except Unproved:
            pass
        raise Unproved("two poses are one, or so near that it is undecided: closer than 1e-1200")

    @cached_property
    def count(self) -> int:
        """Their number."""
        for bits in precisions(_FIRST_BITS, GREATEST_BITS):
            try:
                return len(self._found(self.simple, bits))
            except Open:
                continue
        raise Unproved("the poses could not be told apart")

    def turned(self, number: int, bits: int) -> Pair:
        """cos α and sin α of a root."""
        t = self._found(self.simple, bits)[number]
        u, v = map(ball_of, self.turn)
        over = 1 / (1 + t * t)
        c, s = (1 - t * t) * over, 2 * t * over
        return u * c - v * s, v * c + u * s

    @staticmethod
    def _found(polynomial: Poly, bits: int) -> list[arb]:
        with ctx.workprec(bits):
            return real_roots([x.ball(bits) for x in polynomial], bits)


def candidates(legs: Legs) -> list[Candidate]:
    """All poses with three given data, but for the senses of angles.

    Raises:
        Curve: there is a whole curve of them.
        Unproved: their number could not be decided.
    """
    both = [leg for leg in legs.lengths if leg in legs.turns]
    if both:
        return _with_known_leg(legs, both[0])
    if len(legs.turns) == 1:
        return _with_two_lengths(legs)
    return _with_lines(legs)


def _with_known_leg(legs: Legs, leg: int) -> list[Candidate]:
    length, (u, v) = legs.lengths[leg], legs.turns[leg]
    [other] = {*legs.lengths, *legs.turns} - {leg}

    def polynomial(turn: _Turn) -> Poly:
        one: Poly = tuple(map(legs.reals.number, (1, 0, 1)))
        own, far = legs.around(leg, turn), legs.around(other, turn)
        vector = [
            _sum(_scaled(one, z * length), _sum(w, _scaled(x, -1)))
            for z, w, x in zip((u, v), far, own, strict=True)
        ]
        if other in legs.turns:
            return _crossed(vector, legs.turns[other])
        square = _scaled(_times(one, one), -(legs.lengths[other] ** 2))
        return _over_one(_sum(_squared(vector), square))

    def place(turned: Pair, bits: int) -> Pair:
        (x, y), (p, q) = legs.turn_ball(leg, bits), legs.around_ball(leg, turned, bits)
        r = ball_of(length)
        return r * x - p, r * y - q

    return _all(legs, polynomial, place)


def _with_lines(legs: Legs) -> list[Candidate]:
    """With two or three angles, of legs without a length."""
    names = sorted(legs.turns)
    pairs = [(i, j) for i in names for j in names if i < j and frozenset((i, j)) not in legs.parallel]
    if not pairs:
        return _with_parallels(legs, names)
    i, j = pairs[0]
    (a, b), (c, d) = legs.turns[i], legs.turns[j]
    det = a * d - b * c

    def polynomial(turn: _Turn) -> Poly:
        # V × u = 0 is p · n = −w · n, with n = (u_y, −u_x)
        first, second = (_scaled(_crossed(legs.around(k, turn), legs.turns[k]), -1) for k in (i, j))
        x = _sum(_scaled(second, a), _scaled(first, -c))
        y = _sum(_scaled(second, b), _scaled(first, -d))
        [third] = ({*legs.lengths, *legs.turns} - {i, j}) or {0}
        own = legs.around(third, turn)
        vector = [_sum(z, _scaled(w, det)) for z, w in zip((x, y), own, strict=True)]
        if third in legs.turns:
            return _crossed(vector, legs.turns[third])
        one: Poly = tuple(map(legs.reals.number, (1, 0, 1)))
        square = _scaled(_times(one, one), det * det * -(legs.lengths[third] ** 2))
        return _sum(_squared(vector), square)

    def place(turned: Pair, bits: int) -> Pair:
        (a, b), (c, d) = (legs.turn_ball(k, bits) for k in (i, j))
        first, second = (-_cross(legs.around_ball(k, turned, bits), legs.turn_ball(k, bits)) for k in (i, j))
        over = a * d - b * c
        return (second * a - first * c) / over, (second * b - first * d) / over

    return _all(legs, polynomial, place)


def _with_parallels(legs: Legs, names: Sequence[int]) -> list[Candidate]:
    """With legs whose angles are equal or opposite: α follows from their distance."""
    i, *others = names

    def apart(turn: _Turn, other: int) -> Poly:
        own, far = legs.around(i, turn), legs.around(other, turn)
        return _crossed([_sum(w, _scaled(x, -1)) for w, x in zip(own, far, strict=True)], legs.turns[i])

    if len(others) == 2:
        turn = next(iter(unit_vectors()))
        first, second = (_trimmed(apart(turn, other)) for other in others)
        if not first or not second or len(common_divisor(first, second)) > 1:
            raise Curve
        if len(first) < 3 and len(second) < 3:
            raise Curve  # α = 180° from the direction, too
        return []
    [length] = legs.lengths

    def place_on(side: int) -> Places:
        def place(turned: Pair, bits: int) -> Pair:
            (u, v), (p, q) = legs.turn_ball(i, bits), legs.around_ball(i, turned, bits)
            x, y = legs.around_ball(length, turned, bits)
            x, y = x - p, y - q
            along, across = u * x + v * y, u * y - v * x
            far = _root(ball_of(legs.lengths[length]) ** 2 - across * across) * side - along
            return far * u - p, far * v - q

        return place

    found = _all(legs, lambda turn: apart(turn, others[0]), place_on(1))
    return _real_ones([*found, *(Candidate(x.root, x.number, place_on(-1)) for x in found)])


def _with_two_lengths(legs: Legs) -> list[Candidate]:
    i, j = sorted(legs.lengths)
    [(k, (nx, ny))] = legs.turns.items()
    n = ny, -nx
    si, sj = (legs.lengths[leg] ** 2 for leg in (i, j))

    def parts(turn: _Turn) -> tuple[list[Poly], Poly, Poly, Poly]:
        one: Poly = tuple(map(legs.reals.number, (1, 0, 1)))
        own, far, line = (legs.around(leg, turn) for leg in (i, j, k))
        v = [_sum(x, _scaled(w, -1)) for x, w in zip(far, own, strict=True)]
        # 2 q · v = r and q · n = h, for q = V_i
        r = _sum(_scaled(one, sj - si), _scaled(_over_one(_squared(v)), -1))
        h = _crossed([_sum(w, _scaled(x, -1)) for w, x in zip(own, line, strict=True)], (nx, ny))
        return v, r, h, one

    def determinant(turn: _Turn) -> Poly:
        v = parts(turn)[0]
        return _scaled(_sum(_scaled(v[0], n[1]), _scaled(v[1], -n[0])), 2)

    def polynomial(turn: _Turn) -> Poly:
        v, r, h, one = parts(turn)
        long = _times(r, one)
        x = _sum(_scaled(long, n[1]), _scaled(_times(h, v[1]), -2))
        y = _sum(_scaled(_times(h, v[0]), 2), _scaled(long, -n[0]))
        whole = _times(determinant(turn), one)
        return _over_one(_sum(_squared([x, y]), _scaled(_times(whole, whole), -si)))

    def vectors(turned: Pair, bits: int) -> tuple[Pair, arb, arb, Pair, Pair]:
        own, far, line = (legs.around_ball(leg, turned, bits) for leg in (i, j, k))
        v = far[0] - own[0], far[1] - own[1]
        u, w = legs.turn_ball(k, bits)
        r = ball_of(sj - si) - v[0] * v[0] - v[1] * v[1]
        h = (own[0] - line[0]) * w - (own[1] - line[1]) * u
        return v, r, h, (w, -u), own

    def place(turned: Pair, bits: int) -> Pair:
        v, r, h, m, own = vectors(turned, bits)
        over = 2 * (v[0] * m[1] - v[1] * m[0])
        x, y = (r * m[1] - 2 * h * v[1]) / over, (2 * v[0] * h - r * m[0]) / over
        return x - own[0], y - own[1]

    def place_on(side: int) -> Places:
        def place(turned: Pair, bits: int) -> Pair:
            _, _, h, m, own = vectors(turned, bits)
            far = _root(ball_of(si) - h * h) * side
            return h * m[0] - far * m[1] - own[0], h * m[1] + far * m[0] - own[1]

        return place

    roots = _roots(legs, polynomial)
    det = _trimmed(determinant(roots.turn))
    if not det:
        raise Unproved("the platform cannot turn where these lengths and this angle hold: not decided")
    shared = _shared_roots(roots, det)
    found: list[Candidate] = []
    for number in range(roots.count):
        if number in shared:
            found += _real_ones([Candidate(roots, number, place_on(side)) for side in (1, -1)])
        else:
            found.append(Candidate(roots, number, place))
    return found


def _shared_roots(roots: Roots, other: Poly) -> set[int]:
    """The numbers of those roots at which another polynomial is 0, too."""
    for bits in precisions(_FIRST_BITS, _BEFORE_EXACT):
        with ctx.workprec(bits):
            values = [_value(other, t, bits) for t in Roots._found(roots.simple, bits)]
        if not any(x.contains(0) for x in values):
            return set()
    common = common_divisor(roots.simple, other)
    if len(common) == 1:
        return set()
    for bits in precisions(_BEFORE_EXACT, GREATEST_BITS):
        try:
            own, both = (Roots._found(p, bits) for p in (roots.simple, squarefree(common)))
        except Open:
            continue
        near = [[k for k, x in enumerate(own) if x.overlaps(y)] for y in both]
        if all(len(places) == 1 for places in near):
            return {places[0] for places in near}
    raise Unproved("where two lengths and an angle depend on each other is undecided")


def _real_ones(found: Sequence[Candidate]) -> list[Candidate]:
    """The candidates whose places are real, each once."""
    kept: list[Candidate] = []
    for one in found:
        for bits in precisions(_FIRST_BITS, GREATEST_BITS):
            try:
                one.pose(bits)
            except _NotReal:
                break
            except Open:
                continue
            kept.append(one)
            break
        else:
            raise Unproved("two poses are one, or so near that it is undecided")
    return kept


class _NotReal(ControlFlow):
    """A root is of a negative number."""


def _root(x: arb) -> arb:
    if x < 0:
        raise _NotReal
    if not x > 0:
        raise Open
    return x.sqrt()


def _all(legs: Legs, polynomial: Callable[[_Turn], Poly], place: Places) -> list[Candidate]:
    roots = _roots(legs, polynomial)
    return [Candidate(roots, number, place) for number in range(roots.count)]


def _roots(legs: Legs, polynomial: Callable[[_Turn], Poly]) -> Roots:
    """The roots, seen from a direction that none of them is opposite to."""
    is_exact = legs.reals.tower is not None
    for turn in unit_vectors():
        found = polynomial(turn)
        try:
            if found[-1].sign:
                return Roots(turn, found, is_exact)
        except Unproved:
            continue
    if is_exact and all(x.is_zero for x in found):
        raise Curve
    raise Unproved("whether the data hold along a whole curve of poses is undecided")


# ---- polynomials in t


def _sum(p: Poly, q: Poly) -> Poly:
    return tuple(x + y for x, y in zip(p, q, strict=True))


def _scaled(p: Poly, x: Any) -> Poly:
    return tuple(y * x for y in p)


def _times(p: Poly, q: Poly) -> Poly:
    found: list[Any] = [p[0] * 0] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            found[i + j] = found[i + j] + x * y
    return tuple(found)


def _squared(v: Sequence[Poly]) -> Poly:
    return _sum(_times(v[0], v[0]), _times(v[1], v[1]))


def _crossed(v: Sequence[Poly], u: Vector) -> Poly:
    """v × u."""
    return _sum(_scaled(v[0], u[1]), _scaled(v[1], -u[0]))


def _over_one(p: Poly) -> Poly:
    """p / (1 + t²), which divides it."""
    found: list[Any] = [None] * (len(p) - 2)
    for k in reversed(range(len(found))):
        above = found[k + 2] if k + 2 < len(found) else None
        found[k] = p[k + 2] if above is None else p[k + 2] - above
    return tuple(found)


def _value(p: Poly, t: arb, bits: int) -> arb:
    value = arb(0)
    for x in reversed(p):
        value = value * t + x.ball(bits)
    return value


def _trimmed(p: Poly) -> Poly:
    count = len(p)
    while count and p[count - 1].is_zero:
        count -= 1
    return p[:count]


def _cross(p: Pair, q: Pair) -> arb:
    return p[0] * q[1] - p[1] * q[0]
