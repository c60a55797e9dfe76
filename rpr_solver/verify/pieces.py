"""Pieces of the curve J = 0 of a slice, and the image of each in the plane of the squared free legs.

In the frame of a *piece*, a direction and its left normal, J = 0 in a box |r| ≤ reach, |e| ≤ width is a graph
e(r): ∂J/∂e > 0 in the box, and J has opposite signs at e = ±width. All functions are taken with
their derivatives at the middle of the box, and the rest is bounded by the amplitudes of their waves
(mathematics.md#regions-of-the-joint-plane).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import hypot

from rpr_solver.verify.claims import OpenError
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.fronts import BITS, ERROR, FRAME, ONE, TURN, Front, Jet, Point, Vector, product

_WIDER, _NORMAL = 1.5, 16
_FIRST_STEP, _LEAST_STEP, MOST_PIECES = 0.1, 2.0**-36, 6000
UNDECIDED = "parts of the singular curve's image are too near each other for intervals"


def small(vector: Vector) -> Vector:
    """A vector of small integers that has about the direction of one."""
    shift = max(max(map(abs, vector)).bit_length() - _NORMAL, 0)
    return vector[0] >> shift, vector[1] >> shift


def normal_of(vector: Vector) -> Vector:
    """A vector of small integers that is about normal to one, on its left."""
    x, y = small(vector)
    return -y, x


def chord(piece: Piece) -> Vector:
    """From the image of its start to that of its end."""
    (a, b), (c, d) = (point.image for point in piece.ends)
    return c - a, d - b


def piece_between(front: Front, start: Point, stop: Point) -> Piece | None:
    """The piece of J = 0 from one point to another, which is ahead of it; None if it is not proved."""
    alpha, theta = (start.alpha + stop.alpha) >> 1, (start.theta + stop.theta) >> 1
    across, up = (stop.alpha - start.alpha) / ONE, (stop.theta - start.theta) / ONE
    length = hypot(across, up)
    for last in (False, True):
        here = front.phases(alpha, theta)
        jet = front.singular.jet(here)
        size = hypot(jet[1], jet[2])
        if not size or not length:
            return None
        if not last:  # to the curve
            step = jet[0] / size
            alpha -= int(step * (jet[1] / size) * ONE)
            theta -= int(step * (jet[2] / size) * ONE)
    unit = (1 << FRAME) * (1 - 2**-18)
    frame = int(unit * jet[2] / size), int(-unit * jet[1] / size)
    reach = int(length * 0.51 * ONE) + 2 * (start.error + stop.error)
    return _proved(front, (alpha, theta), frame, reach, (start, stop))


def _framed(jet: Jet, frame: Vector) -> Jet:
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


def _proved(
    front: Front, middle: Vector, frame: Vector, reach: int, ends: tuple[Point, Point]
) -> Piece | None:
    """The piece between two points in the box about a middle, if it is a graph there."""
    here = front.phases(*middle)
    spend(120, BITS)
    value, along, slope, bend, twist, fold = _framed(front.singular.jet(here), frame)
    third = front.singular.norms[3]
    known = abs(value) + product(abs(along), reach) + product(product(abs(bend), reach), reach) // 2
    cube = product(product(third, reach), product(reach, reach)) // 6
    if slope <= 0:
        return None
    width = int(_WIDER * ((known + cube + ERROR) / slope) * ONE) + 2 * ends[0].error
    across = reach + width  # no less than the distance from the middle
    if across > ONE:
        return None
    square = product(across, across)
    rest = product(product(third, across), square) // 6
    other = product(abs(twist), product(reach, width)) + product(abs(fold), product(width, width)) // 2
    if slope * width >> BITS <= known + other + rest + 16 * ERROR:
        return None
    turn = product(third, square) // 2
    least = slope - product(abs(twist), reach) - product(abs(fold), width) - turn - 16 * ERROR
    if least <= 0:
        return None
    tilt = abs(along) + product(abs(bend), reach) + product(abs(twist), width) + turn + 16 * ERROR
    jets = tuple(leg.jet(here) for leg in front.legs)
    piece = Piece(front, ends, middle, frame, reach, width, (tilt << BITS) // least + 1, jets)
    (first, e), (last, d) = (piece.place(point.alpha, point.theta) for point in ends)
    room = [2 * point.error for point in ends]
    inside = all(
        abs(r) + more <= reach and abs(s) + more <= width
        for (r, s), more in zip(((first, e), (last, d)), room, strict=True)
    )
    return piece if inside and first + room[0] < last - room[1] else None


@dataclass(frozen=True, eq=False)
class Piece:
    """A piece of J = 0 between two points, with J > 0 on its left, and its image.

    Attributes:
        slant: a bound of |de/dr|.
        jets: the squared free legs at the middle of the box.
    """

    front: Front
    ends: tuple[Point, Point]
    middle: Vector
    frame: Vector
    reach: int
    width: int
    slant: int
    jets: tuple[Jet, ...]

    def place(self, alpha: int, theta: int) -> Vector:
        """r and e of two angles; their errors are at most doubled."""
        x, y = self.frame
        a, t = alpha - self.middle[0], theta - self.middle[1]
        square = x * x + y * y
        return ((a * x + t * y) << FRAME) // square, ((t * x - a * y) << FRAME) // square

    @cached_property
    def across(self) -> int:
        """No less than the distance of any of its points from the middle."""
        return self.reach + self.width

    @cached_property
    def halves(self) -> tuple[Piece, Piece]:
        """Two pieces of it.

        Raises:
            OpenError: they are too small.
        """
        first, last = (self.place(point.alpha, point.theta)[0] for point in self.ends)
        for part in (0.47, 0.56, 0.35):
            r = first + int((last - first) * part)
            x, y = self.frame
            alpha, theta = (z + (r * w >> FRAME) for z, w in zip(self.middle, (x, y), strict=True))
            point = self.front.point(alpha, theta, (-y, x))
            if point is None or abs(point.alpha - alpha) + abs(point.theta - theta) > 2 * self.width:
                continue
            parts = (
                piece_between(self.front, self.ends[0], point),
                piece_between(self.front, point, self.ends[1]),
            )
            if parts[0] is not None and parts[1] is not None and self.holds(point):
                return parts[0], parts[1]
        raise OpenError("pieces of the singular curve are too small for intervals")

    def holds(self, point: Point) -> bool:
        """Whether a point of J = 0 is in its box, so on the piece or beside its ends."""
        r, e = self.place(point.alpha, point.theta)
        return abs(r) + 2 * point.error <= self.reach and abs(e) + 2 * point.error <= self.width

    @cached_property
    def _framed(self) -> tuple[Jet, ...]:
        return tuple(_framed(jet, self.frame) for jet in self.jets)

    def along(self, normal: Vector) -> Vector:
        """The middle and the radius of the image in a direction, a vector of small integers; times this."""
        x, y = normal
        (c, r, e, rr, re, ee) = (x * a + y * b for a, b in zip(self._framed[0], self._framed[1], strict=True))
        h, w, d = self.reach, self.width, self.across
        first, second = (leg.norms[3] for leg in self.front.legs)
        cube = product(product(d, d), d)
        radius = abs(r) * h + abs(e) * w + ((abs(rr) * h >> BITS) * h + (abs(ee) * w >> BITS) * w) // 2
        radius += (abs(re) * h >> BITS) * w
        rest = product(abs(x) * first + abs(y) * second, cube) // 6
        return c, (radius >> BITS) + rest + (abs(x) + abs(y)) * 16 * ERROR + 8

    @cached_property
    def box(self) -> tuple[int, int, int, int]:
        """Least and greatest first, then second coordinates of the image."""
        (a, r), (b, s) = self.along((1, 0)), self.along((0, 1))
        return a - r, a + r, b - s, b + s

    @cached_property
    def cusps(self) -> frozenset[int]:
        """The cusps that may be on it."""
        found = set()
        for n, (alpha, theta, error) in enumerate(self.front.cusps):
            near = [
                x - TURN * ((x - y + TURN // 2) // TURN)
                for x, y in zip((alpha, theta), self.middle, strict=True)
            ]
            r, e = self.place(near[0], near[1])
            if abs(r) <= self.reach + 4 * error and abs(e) <= self.width + 4 * error:
                found.add(n)
        return frozenset(found)

    @cached_property
    def _direction(self) -> int:
        """Whose image is the tangent: that of the frame, 1, which vanishes at cusps, or its normal, 2."""
        return max((1, 2), key=lambda k: sum(abs(jet[k]) for jet in self._framed))

    @cached_property
    def _tangents(self) -> tuple[Vector, Vector]:
        """A tangent of the image: for both coordinates its value in the middle, and how far it changes.

        On J = 0 the images of all directions are on one line.
        """
        k = self._direction
        square = product(self.across, self.across)
        rows = []
        for jet, leg in zip(self._framed, self.front.legs, strict=True):
            along, aside = abs(jet[k + 2]), abs(jet[k + 3])
            change = product(along, self.reach) + product(aside, self.width)
            rows.append((jet[k], change + product(leg.norms[3], square) + 16 * ERROR))
        return rows[0], rows[1]

    @property
    def tangent(self) -> Vector:
        """A tangent of the image in the middle."""
        return self._tangents[0][0], self._tangents[1][0]

    @cached_property
    def heading(self) -> int:
        """Whether a piece without a cusp runs along its tangent (1) or against it (−1); 0 if that is open."""
        normal, (start, stop) = small(self.tangent), self.ends
        if self.cusps or not self.leans(normal):
            return 0
        way = sum(n * (y - x) for n, x, y in zip(normal, start.image, stop.image, strict=True))
        room = (abs(normal[0]) + abs(normal[1])) * (start.blur + stop.blur)
        return (way > room) - (way < -room)

    def leans(self, normal: Vector) -> bool:
        """Whether no tangent of the image is normal to a direction."""
        pairs = list(zip(normal, self._tangents, strict=True))
        return abs(sum(n * x for n, (x, _) in pairs)) > sum(abs(n) * change for n, (_, change) in pairs)

    def crosses(self, other: Piece) -> int:
        """The sign of the cross product of all tangents of this piece and of another; 0 if that is open."""
        return _cross(*self._tangents, *other._tangents)

    @cached_property
    def rotation(self) -> int:
        """The sense in which the tangent turns along the piece; 0 if that is open."""
        k = self._direction + 2
        slopes = []
        for jet, leg in zip(self._framed, self.front.legs, strict=True):
            rest = product(leg.norms[3], self.across) + 16 * ERROR
            slopes.append((jet[k], rest + product(abs(jet[k + 1]) + rest, self.slant)))
        return _cross(*self._tangents, *slopes)


def _cross(a: Vector, b: Vector, c: Vector, d: Vector) -> int:
    """The sign of a d − b c, each number being given with its error; 0 if that is open."""
    value = a[0] * d[0] - b[0] * c[0]
    change = a[1] * (abs(d[0]) + d[1]) + abs(a[0]) * d[1] + b[1] * (abs(c[0]) + c[1]) + abs(b[0]) * c[1]
    return (value > change) - (value < -change)


def is_simple(run: Sequence[Piece]) -> bool:
    """Whether the image of consecutive pieces is proved not to meet itself."""
    spend(10 * len(run), BITS)
    cusps = frozenset().union(*(piece.cusps for piece in run))
    normal = small(run[len(run) // 2].tangent)
    if len(cusps) > 1 or not all(piece.leans(normal) for piece in run):
        return False
    return not cusps or {piece.rotation for piece in run} in ({1}, {-1})


def simple_pairs(chain: Sequence[Piece]) -> list[Piece]:
    """The chain, cut so finely that no two neighbours meet but at their common end.

    Raises:
        OpenError: pieces get too small, or there are too many.
    """
    pieces = list(chain)
    while True:
        n = len(pieces)
        bad = {k for k in range(n) if not is_simple([pieces[k], pieces[(k + 1) % n]])}
        if n > 2 and not bad:
            return pieces
        if n > MOST_PIECES:
            raise OpenError(UNDECIDED)
        split = bad | {(k + 1) % n for k in bad} if n > 2 else set(range(n))
        pieces = [part for k, x in enumerate(pieces) for part in (x.halves if k in split else (x,))]


def traced(front: Front, start: Point) -> list[Piece]:
    """The component of J = 0 through a point, in pieces.

    Raises:
        OpenError: pieces get too small, or there are too many.
    """
    pieces: list[Piece] = []
    unit = (1 << FRAME) - 8
    here, step = start, _FIRST_STEP
    while len(pieces) < MOST_PIECES:
        spend(100, BITS)
        jet = front.singular.jet(front.phases(here.alpha, here.theta))
        size = hypot(jet[1], jet[2])
        if not size or step < _LEAST_STEP:
            raise OpenError("pieces of the singular curve are too small for intervals")
        ahead = jet[2] / size, -jet[1] / size
        last = _closing(start, here, ahead, step) if len(pieces) > 1 else None
        there = last or front.point(
            here.alpha + int(step * ahead[0] * ONE),
            here.theta + int(step * ahead[1] * ONE),
            (int(-ahead[1] * unit), int(ahead[0] * unit)),
        )
        piece = None if there is None else piece_between(front, here, there)
        if there is None or piece is None:
            step /= 2
            continue
        pieces.append(piece)
        if last is not None:
            return pieces
        here, step = there, min(step * 1.5, _FIRST_STEP)
    raise OpenError("the singular curve has too many pieces")


def _closing(start: Point, here: Point, ahead: tuple[float, float], step: float) -> Point | None:
    """The first point of a component, by full turns nearer, if it is less than a step ahead."""
    turns = round((here.alpha - start.alpha) / TURN), round((here.theta - start.theta) / TURN)
    point = start.turned(turns)
    x, y = (point.alpha - here.alpha) / ONE, (point.theta - here.theta) / ONE
    forward, aside = x * ahead[0] + y * ahead[1], y * ahead[0] - x * ahead[1]
    return point if 0 < forward <= 1.2 * step and abs(aside) <= step / 2 else None
