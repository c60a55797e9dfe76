from fractions import Fraction
from typing import Any

import mpmath as mp
from flint import arb, ctx
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver.triangles import Geometry, Surd, UserFrame, read_geometry
from tests.support.triangle_oracle import corners_of
from tests.support.triangle_spellings import geometries

ANGLES = st.integers(-314, 314).map(lambda n: n / 100)


def number(surd: Surd) -> Any:
    """A surd in mpmath, at its precision."""
    return surd.sign * mp.sqrt(mp.mpf(surd.square.numerator) / surd.square.denominator)


def legs_of(geometry: Geometry, alpha: float, b1: complex) -> list[Any]:
    """The lengths of the legs of a pose in the article's frame."""
    base, platform = corners_of(geometry)
    z = mp.expj(alpha)
    return [abs(b1 + z * m - a) for m, a in zip(platform, base, strict=True)]


@given(geometries(), ANGLES, ANGLES, ANGLES)
def test_the_legs_are_as_long_in_the_users_frame(
    geometry: Geometry, alpha: float, x: float, y: float
) -> None:
    frame = UserFrame.of(geometry)
    assert (frame is None) == (geometry.base.points is None and geometry.platform.points is None)
    assume(frame is not None)
    assert frame is not None
    with mp.workdps(30):
        u, v, c, s = frame.pose(mp.cos(alpha), mp.sin(alpha), mp.mpf(x), mp.mpf(y), number)
        turn, origin = mp.mpc(c, s), mp.mpc(u, v)
        own = corners_of(geometry)
        corners = [
            own[n] if points is None else tuple(mp.mpc(number(p), number(q)) for p, q in points)
            for n, points in enumerate((geometry.base.points, geometry.platform.points))
        ]
        legs = [abs(origin + turn * b - a) for a, b in zip(*corners, strict=True)]
        assert abs(abs(turn) - 1) < 1e-25
        assert all(
            abs(p - q) < 1e-20 for p, q in zip(legs, legs_of(geometry, alpha, mp.mpc(x, y)), strict=True)
        )


def test_the_map_is_exact_over_the_rationals() -> None:
    base = {"points": [[1, 1], [4, 5], [-3, 4]]}
    platform = {"points": [["1/2", 2], ["1/2", 1], ["3/2", 2]]}
    frame = UserFrame.of(read_geometry({"base": base, "platform": platform}))
    assert frame is not None

    def rational(surd: Surd) -> Fraction:
        assert surd.rational is not None
        return surd.rational

    # at α = 0 and B1 = A1 the platform's frame is turned from (0, -1) to (3/5, 4/5)
    pose = frame.pose(Fraction(1), Fraction(0), Fraction(0), Fraction(0), rational)
    x, y, cos, sin = pose
    assert (cos, sin) == (Fraction(-4, 5), Fraction(3, 5))
    assert (x + cos / 2 - sin * 2, y + sin / 2 + cos * 2) == (1, 1)


def test_balls_hold_the_pose() -> None:
    base = {"points": [["sqrt(2)", 0], [0, "sqrt(2)"], [0, 0]]}
    frame = UserFrame.of(read_geometry({"base": base, "platform": {"sides": [3, 4, 5]}}))
    assert frame is not None
    with ctx.workprec(200):
        x, y, cos, sin = frame.pose(arb(1), arb(0), arb(2), arb(0), Surd.ball)
        assert x.overlaps(arb(0))
        assert y.overlaps(arb(2).sqrt())
        assert (cos + sin).overlaps(arb(0))
        assert y.rad() < arb("1e-50")
