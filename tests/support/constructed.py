"""Manipulators made round a pose, so that it is a cusp, or degenerate in one known way; all is rational.

A cusp comes from the Euler–Savary construction: the third base point is the centre of curvature of the path
of B3 while the other two legs keep their lengths. It knows nothing of J, E, half angles or elimination.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from rpr_solver import Manipulator
from rpr_solver.article.eliminant import Legs

Vector = tuple[Fraction, Fraction]
WEST: Vector = (Fraction(-1), Fraction(0))


def direction(n: int, d: int) -> Vector:
    """The unit vector whose half angle has the tangent n/d."""
    return Fraction(d * d - n * n, n * n + d * d), Fraction(2 * n * d, n * n + d * d)


def add(a: Vector, b: Vector, times: Fraction | int = 1) -> Vector:
    return a[0] + times * b[0], a[1] + times * b[1]


def dot(a: Vector, b: Vector) -> Fraction:
    return a[0] * b[0] + a[1] * b[1]


def turned(a: Vector, by: Vector) -> Vector:
    """By the angle of a unit vector."""
    return a[0] * by[0] - a[1] * by[1], a[0] * by[1] + a[1] * by[0]


def across(a: Vector) -> Vector:
    return -a[1], a[0]


@dataclass(frozen=True)
class Platform:
    """B2 = (d1, 0) and B3 = (p, h) seen from B1, with rational sides."""

    d1: int
    p: int
    h: int
    d2: int
    d3: int


TRIANGLE = Platform(14, 5, 12, 15, 13)
RIGHT = Platform(5, 0, 12, 13, 12)


@dataclass(frozen=True)
class Pose:
    """A pose of a platform; the angles of leg 1, which begins in the origin, and of B1B2 are unit vectors."""

    platform: Platform
    l1: Fraction
    theta: Vector
    alpha: Vector

    @property
    def points(self) -> tuple[Vector, Vector, Vector]:
        """B1, B2 and B3."""
        b1 = self.l1 * self.theta[0], self.l1 * self.theta[1]
        shape = (
            (Fraction(self.platform.d1), Fraction(0)),
            (Fraction(self.platform.p), Fraction(self.platform.h)),
        )
        b2, b3 = (add(b1, turned(x, self.alpha)) for x in shape)
        return b1, b2, b3

    @property
    def t(self) -> Fraction | None:
        """tan(α/2), None at 180°."""
        return _half_tangent(self.alpha)

    @property
    def u(self) -> Fraction | None:
        """tan(θ1/2), None at 180°."""
        return _half_tangent(self.theta)

    def manipulator(self, a2x: Fraction, a3: Vector) -> Manipulator:
        """The one with these base points."""
        shape = self.platform
        return Manipulator(a2x, *a3, Fraction(shape.d1), Fraction(shape.d2), Fraction(shape.d3))

    def on_axis(self, point: Vector, way: Vector) -> Fraction:
        """Where the line through a point meets the line A1A2."""
        return point[0] - point[1] * way[0] / way[1]

    def centre_of_curvature(self, a2x: Fraction) -> Vector:
        """Of the path of B3 while legs 1 and 2 turn about (0, 0) and (a2x, 0)."""
        b1, b2, b3 = self.points
        leg1, leg2 = b1, add(b2, (a2x, Fraction(0)), -1)
        # B1′ is across leg 1, and B2′ = B1′ + the side turned by 90° is across leg 2
        rate = -dot(leg2, across(add(b2, b1, -1))) / dot(leg2, across(leg1))
        v1 = across((rate * leg1[0], rate * leg1[1]))
        v2, v3 = (add(v1, across(add(b, b1, -1))) for b in (b2, b3))
        # B1″ = x leg 1 + y across it; B2″ and B3″ are B1″ less the side
        x = -dot(v1, v1) / dot(leg1, leg1)
        rest = dot(v2, v2) + x * dot(leg1, leg2) - dot(leg2, add(b2, b1, -1))
        y = -rest / dot(across(leg1), leg2)
        acceleration = add(add((x * leg1[0], x * leg1[1]), across(leg1), y), add(b3, b1, -1), -1)
        normal = across(v3)
        return add(b3, normal, dot(v3, v3) / dot(acceleration, normal))


def _half_tangent(x: Vector) -> Fraction | None:
    return None if x == WEST else x[1] / (1 + x[0])


@dataclass(frozen=True)
class Constructed:
    """A pose of a manipulator, and its name."""

    pose: Pose
    manipulator: Manipulator


def legs_of(at: Constructed) -> Legs:
    """Their vectors, for the article's equations."""
    m = at.manipulator
    base = ((Fraction(0), Fraction(0)), (m.a2x, Fraction(0)), (m.a3x, m.a3y))
    vectors = tuple(add(b, a, -1) for a, b in zip(base, at.pose.points, strict=True))
    return Legs(vectors, m.a2x, m.a3x, m.a3y)  # type: ignore[arg-type]


_POSE = Pose(TRIANGLE, Fraction(10), direction(1, 3), direction(-1, 2))
_A2X = Fraction(20)


def cusp(pose: Pose = _POSE, a2x: Fraction = _A2X) -> Constructed:
    """Three poses coalesce."""
    return Constructed(pose, pose.manipulator(a2x, pose.centre_of_curvature(a2x)))


def fold() -> Constructed:
    """Singular, but A3 is elsewhere on the line of leg 3: only two poses coalesce."""
    centre, b3 = _POSE.centre_of_curvature(_A2X), _POSE.points[2]
    return Constructed(_POSE, _POSE.manipulator(_A2X, add(centre, add(centre, b3, -1), Fraction(1, 2))))


def ordinary() -> Constructed:
    """Not singular."""
    a3 = add(_POSE.centre_of_curvature(_A2X), across(_POSE.points[2]))
    return Constructed(_POSE, _POSE.manipulator(_A2X, a3))


def leg_2_closed() -> Constructed:
    """B2 is on the line A1A2, and A2 is there."""
    pose = Pose(RIGHT, Fraction(5), direction(1, 2), direction(-1, 2))
    assert pose.points[1] == (6, 0)
    return Constructed(pose, pose.manipulator(Fraction(6), (Fraction(-7), Fraction(2))))


def leg_3_closed() -> Constructed:
    """A3 is in B3."""
    return Constructed(_POSE, _POSE.manipulator(_A2X, _POSE.points[2]))


def _stretched() -> Pose:
    """B1B3 is in the line of leg 1."""
    theta = direction(1, 3)
    beta = (Fraction(TRIANGLE.p, TRIANGLE.d3), Fraction(-TRIANGLE.h, TRIANGLE.d3))
    return Pose(TRIANGLE, Fraction(10), theta, turned(theta, beta))


def legs_1_and_3_in_line() -> Constructed:
    """With B1B3: k2 = k4 = 0."""
    pose = _stretched()
    return Constructed(pose, pose.manipulator(_A2X, (30 * pose.theta[0], 30 * pose.theta[1])))


def legs_2_and_3_in_line() -> Constructed:
    """With B2B3: k1 = k3 = 0."""
    _, b2, b3 = _POSE.points
    way = add(b3, b2, -1)
    return Constructed(_POSE, _POSE.manipulator(_POSE.on_axis(b2, way), add(b3, way, 2)))


def lines_meet_in_b1() -> Constructed:
    """k2 = k5 = 0."""
    b1, b2, b3 = _POSE.points
    return Constructed(
        _POSE, _POSE.manipulator(_POSE.on_axis(b1, add(b2, b1, -1)), add(b3, add(b3, b1, -1), Fraction(3, 2)))
    )


def lines_meet_in_b3(*, folded: bool = False) -> Constructed:
    """k1 = k4 = 0, with |A1B3| = L1 + d3, or L1 − d3."""
    pose = _stretched()
    if folded:
        pose = Pose(pose.platform, Fraction(20), pose.theta, turned(pose.alpha, WEST))
    _, b2, b3 = pose.points
    a3 = (Fraction(-4), Fraction(9))
    return Constructed(pose, pose.manipulator(pose.on_axis(b2, add(b3, b2, -1)), a3))


def legs_along_both_sides() -> Constructed:
    """Legs 1 and 3 with B1B3, and leg 2 along B1B2: k2 = k4 = k5 = 0."""
    pose = _stretched()
    b1, b2, _ = pose.points
    a3 = (30 * pose.theta[0], 30 * pose.theta[1])
    return Constructed(pose, pose.manipulator(pose.on_axis(b1, add(b2, b1, -1)), a3))
