"""Angles by half tangents against mpmath's, and common roots of forms against roots that were put in."""

from fractions import Fraction
from math import prod

import mpmath as mp
import pytest
from flint import arb, ctx, fmpz_poly
from hypothesis import assume, example, given
from hypothesis import strategies as st

from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.jets import HalfTangent, common_root, pose_of

RATIOS = st.tuples(st.integers(-50, 50), st.integers(-50, 50)).filter(any)
FACTORS = st.lists(RATIOS, max_size=4)
QUADRATICS = st.lists(st.tuples(*[st.integers(-9, 9)] * 3).filter(any), max_size=1)


def half_tangent(n: int, d: int) -> HalfTangent:
    return HalfTangent(arb(n), arb(d))


def angle(n: int, d: int) -> mp.mpf:
    """2 atan(n/d) in degrees, in (−180, 180]."""
    return mp.degrees(2 * mp.atan(mp.mpf(n) / d)) if d else mp.mpf(180)


@given(RATIOS)
@example((3, 0))
@example((0, -2))
def test_cosine_and_sine(ratio: tuple[int, int]) -> None:
    n, d = ratio
    cos, sin = half_tangent(n, d).cos_sin()
    for value, numerator in ((cos, d * d - n * n), (sin, 2 * n * d)):
        assert value.overlaps(ball_of(Fraction(numerator, n * n + d * d)))
        assert value.rad() < 1e-13


@given(RATIOS, st.sampled_from([0, 180]))
@example((1, 0), 0)
@example((-1, 0), 0)
@example((0, -1), 0)
@example((7, -7), 180)
def test_degrees_lie_above_minus_180_and_up_to_180(ratio: tuple[int, int], offset: int) -> None:
    with ctx.workprec(200), mp.workdps(60):
        degrees = half_tangent(*ratio).degrees(offset)
        middle = mp.mpf(degrees.str(50, radius=False))
        assert abs(middle - offset - angle(*ratio)) < mp.mpf(10) ** -45
        assert degrees.rad() < 1e-50


@pytest.mark.parametrize("side", [1, -1])
def test_degrees_are_sharp_on_both_sides_of_the_half_turn(side: int) -> None:
    """Where the tangent itself would be a ball without end, and where it is tiny."""
    with ctx.workprec(300), mp.workdps(60):
        near = HalfTangent(arb(side), arb(10) ** -40).degrees()
        gap = mp.mpf((180 - side * near).str(20, radius=False))
        assert abs(gap * mp.mpf(10) ** 40 / mp.degrees(2) - 1) < 1e-15
        tiny = HalfTangent(arb(10) ** -40, arb(side)).degrees()
        assert abs(mp.mpf(tiny.str(20, radius=False)) * side * mp.mpf(10) ** 40 / mp.degrees(2) - 1) < 1e-15


@given(st.fractions(-20, 20, max_denominator=20), st.fractions(0, 1, max_denominator=100))
def test_a_ball_s_degrees_hold_those_of_its_numbers(n: Fraction, reach: Fraction) -> None:
    """Balls round n/1 with |n| below, above and across 1."""
    ball = arb(ball_of(n).mid(), ball_of(reach).upper())
    degrees = HalfTangent(ball, arb(1)).degrees()
    for x in (n - reach, n, n + reach):
        exact = arb(str(mp.nstr(angle(x.numerator, x.denominator), 15)))
        assert not degrees.is_finite() or degrees.overlaps(arb(exact.mid(), 1e-10))


def test_a_pose_has_the_angles_of_its_half_tangents() -> None:
    """α by 1/2 and θ by 2/−3, each with its own place."""
    pose = pose_of(half_tangent(1, 2), half_tangent(2, -3), arb(7), arb(11))
    expected = (Fraction(3, 5), Fraction(4, 5), Fraction(5, 13), Fraction(-12, 13), Fraction(7), Fraction(11))
    balls = (pose.cos_alpha, pose.sin_alpha, pose.cos_theta, pose.sin_theta, pose.length, pose.omega)
    assert [x.overlaps(ball_of(y)) for x, y in zip(balls, expected, strict=True)] == [True] * 6
    assert all(x.rad() < 1e-12 for x in balls)


# common roots


def form(roots: list[tuple[int, int]], others: list[tuple[int, ...]]) -> list[arb]:
    """Ascending coefficients of Π (d t − n) and other factors; a root (n, 0) lowers the degree by one."""
    p = prod(
        [fmpz_poly([-n, d]) for n, d in roots] + [fmpz_poly(list(c)) for c in others], start=fmpz_poly([1])
    )
    degree = len(roots) + 2 * len(others)
    return [arb(p[k]) for k in range(degree + 1)]


def same(x: tuple[int, int], y: tuple[int, int]) -> bool:
    return x[0] * y[1] == x[1] * y[0]


def shares_a_root(j: list[arb], e: list[arb]) -> bool:
    """Apart from t = ∞."""
    p, q = (fmpz_poly([int(c.unique_fmpz()) for c in form]) for form in (j, e))
    return bool(p.gcd(q).degree() > 0)


@given(RATIOS, FACTORS, FACTORS, QUADRATICS, QUADRATICS)
@example((1, 0), [(0, 1), (2, 1)], [(1, 1), (3, 1)], [], [])
@example((0, 1), [(1, 0), (2, 1)], [(1, 1), (3, 1)], [], [])
@example((0, 1), [(5, 1)], [(1, 0)], [(1, 0, 1)], [(2, 0, 1)])
def test_the_one_common_root_is_found_at_infinity_too(
    root: tuple[int, int],
    first: list[tuple[int, int]],
    second: list[tuple[int, int]],
    a: list[tuple[int, ...]],
    b: list[tuple[int, ...]],
) -> None:
    j, e = form([root, *first], a), form([root, *second], b)
    rest_j, rest_e = form(first, a), form(second, b)
    assume(len(j) > 2 or len(e) > 2)
    assume(not shares_a_root(rest_j, rest_e))
    assume(rest_j[-1] != 0 or rest_e[-1] != 0)
    with ctx.workprec(300):
        t = common_root(j, e)
        assert t is not None
        assert (t.numerator * root[1] - t.denominator * root[0]).contains(0)
        assert not (t.numerator.contains(0) and t.denominator.contains(0))


@given(RATIOS, RATIOS, FACTORS, FACTORS)
@example((1, 0), (1, 0), [(2, 1)], [(3, 1)])
@example((1, 0), (4, 1), [(2, 1)], [(3, 1)])
def test_of_two_common_roots_none_is_taken(
    one: tuple[int, int], other: tuple[int, int], first: list[tuple[int, int]], second: list[tuple[int, int]]
) -> None:
    with ctx.workprec(300):
        assert common_root(form([one, other, *first], []), form([one, other, *second], [])) is None


def test_wide_coefficients_leave_the_root_open() -> None:
    """(t − 2)(t − 3) and (t − 2)(t + 5): the root is 16/8, as long as 8 is told from 0."""
    j, e = form([(2, 1), (3, 1)], []), form([(2, 1), (-5, 1)], [])
    sharp = common_root([arb(c.mid(), 0.01) for c in j], e)
    assert sharp is not None
    ratio = sharp.numerator / sharp.denominator
    assert ratio.contains(2)
    assert ratio.rad() < 0.5
    assert common_root([arb(c.mid(), 9) for c in j], [arb(c.mid(), 9) for c in e]) is None
