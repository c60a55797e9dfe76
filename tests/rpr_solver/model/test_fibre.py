"""The closure equations, and fibres: poses that are known to be there, multiplicities, and no others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from math import hypot

import mpmath as mp
import pytest
from flint import arb, ctx
from hypothesis import assume, example, given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator, SolverError
from rpr_solver.exact.quadratic import QuadraticPoly, omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.fibre import DEGREE, Closure, Fibre, LinearSystem, fibre
from rpr_solver.model.slice_map import SliceMap
from tests.support import constructed
from tests.support.constructed import TRIANGLE, WEST, Constructed, Pose, add, direction, dot
from tests.support.families import FAMILIES, family
from tests.support.strategies import examples, manipulators, rationals

BITS = 300
SQUARES = st.tuples(*[rationals(1, 400, (1, 2, 9))] * 3)
ANY_MANIPULATOR = st.one_of(manipulators(size=9), st.sampled_from(sorted(FAMILIES)).map(family))
Vector = tuple[arb, arb]


def corners(m: Manipulator) -> tuple[list[Vector], list[Vector]]:
    """The platform's corners and the base points as balls, in the user's unit."""
    p = (m.d1**2 + m.d3**2 - m.d2**2) / (2 * m.d1)
    h = ball_of(m.d3**2 - p**2).sqrt() * (1 if m.orientation == "ccw" else -1) if m.area16 else arb(0)
    platform = [(arb(0), arb(0)), (ball_of(m.d1), arb(0)), (ball_of(p), h)]
    return platform, [(arb(0), arb(0)), (ball_of(m.a2x), arb(0)), (ball_of(m.a3x), ball_of(m.a3y))]


def sides(m: Manipulator, t: Fraction) -> list[Vector]:
    """v₂ and v₃ at tan(α/2) = t: the legs are X, X + v₂ and X + v₃."""
    platform, base = corners(m)
    cos, sin = ball_of((1 - t * t) / (1 + t * t)), ball_of(2 * t / (1 + t * t))
    return [
        (cos * x - sin * y - ax, sin * x + cos * y - ay)
        for (x, y), (ax, ay) in zip(platform[1:], base[1:], strict=True)
    ]


def cramer(v: list[Vector], squares: list[arb]) -> tuple[arb, arb, arb]:
    """The determinant of the two linear equations, and it times X, by Cramer's rule."""
    (a, b), (c, d) = v
    e, f = ((s - squares[0] - x * x - y * y) / 2 for s, (x, y) in zip(squares[1:], v, strict=True))
    return a * d - b * c, e * d - b * f, a * f - e * c


def system_at(closure: Closure, t: Fraction) -> LinearSystem:
    cos, sin, one = (ball_of(x) for x in (1 - t * t, 2 * t, 1 + t * t))
    return closure.linear(cos, sin, one, omega_ball(closure.slice_map.radicand, BITS))


@given(ANY_MANIPULATOR, SQUARES, rationals(-5, 5, (1, 2, 3)))
@examples(40)
def test_the_linear_system_is_that_of_the_two_free_legs(
    m: Manipulator, squares: tuple[Fraction, ...], t: Fraction
) -> None:
    """Up to its weight, the scale, and the common denominator of cosine and sine."""
    closure = Closure.of(SliceMap.of(m), squares)
    with ctx.workprec(BITS):
        one, scale = ball_of(1 + t * t), closure.slice_map.scale_ball()
        v = sides(m, t)
        determinant, x, y = cramer(v, [ball_of(s) for s in squares])
        system = system_at(closure, t)
        for own, true in zip((system.first, system.second), v, strict=True):
            assert all((p - q * scale * one).contains(0) for p, q in zip(own, true, strict=True))
        assert (system.determinant - determinant * (scale * one) ** 2).contains(0)
        for own, numerator in zip(system.numerators, (x, y), strict=True):
            assert (own - numerator * scale**3 * one**2 * system.weight).contains(0)


@given(ANY_MANIPULATOR, SQUARES)
@example(family("congruent"), (Fraction(25), Fraction(25), Fraction(25)))
@examples(40)
def test_the_form_vanishes_where_the_solution_has_the_length_of_leg_1(
    m: Manipulator, squares: tuple[Fraction, ...]
) -> None:
    """It is (1 + t²)³ (|det X|² − det² L1²) times one number, at seven t, which determine it."""
    closure = Closure.of(SliceMap.of(m), squares)
    form = closure.sextic
    assume(not form.is_zero)
    with ctx.workprec(BITS):
        omega = omega_ball(closure.slice_map.radicand, BITS)
        pairs = []
        for t in (Fraction(n, 3) for n in (-7, -4, -1, 0, 2, 5, 11)):
            determinant, x, y = cramer(sides(m, t), [ball_of(s) for s in squares])
            defect = x * x + y * y - determinant * determinant * ball_of(squares[0])
            pairs.append((form(ball_of(t), omega), defect * ball_of((1 + t * t) ** 3)))
        own, true = max(pairs, key=lambda pair: abs(pair[0]).mid())
        assert not own.contains(0)
        assert all((a * true - b * own).contains(0) for a, b in pairs)
        assert all(a.rad() < abs(own) * arb(2) ** -200 for a, _ in pairs)


@pytest.mark.parametrize("name", ["innocenti", "zein-flat"])
@pytest.mark.parametrize("alpha", [180, 90, -60])
def test_the_pose_of_a_joint_vector_is_a_root(name: str, alpha: int) -> None:
    """With B1 = (3, 4); at α = 180° the root is at infinity, so the degree falls."""
    m = EXAMPLES[name]
    with mp.workdps(60):
        squares = [Fraction(int(mp.nint(x * 10**40)), 10**40) for x in squared_legs(m, alpha)]
        form = Closure.of(SliceMap.of(m), squares).sextic
        coefficients = [
            mp.mpf(int(form.a[k])) + mp.sqrt(form.radicand) * mp.mpf(int(form.b[k]))
            for k in range(DEGREE + 1)
        ]
        sin, cos = mp.sin(mp.radians(alpha) / 2), mp.cos(mp.radians(alpha) / 2)
        terms = [c * sin**k * cos ** (DEGREE - k) for k, c in enumerate(coefficients)]
        assert abs(mp.fsum(terms)) < mp.mpf(10) ** -35 * max(map(abs, coefficients))
        assert max(map(abs, terms)) > 0


def squared_legs(m: Manipulator, alpha: int) -> list[mp.mpf]:
    """From the corners, at B1 = (3, 4)."""

    def number(x: Fraction) -> mp.mpf:
        return mp.mpf(x.numerator) / x.denominator

    p = number((m.d1**2 + m.d3**2 - m.d2**2) / (2 * m.d1))
    turn, b1 = mp.expj(mp.radians(alpha)), mp.mpc(3, 4)
    b3 = mp.mpc(p, mp.sqrt(abs(number(m.d3**2) - p**2)))
    legs = b1, b1 + number(m.d1) * turn - number(m.a2x), b1 + b3 * turn - mp.mpc(number(m.a3x), number(m.a3y))
    return [x.real**2 + x.imag**2 for x in legs]


def test_at_a_half_turn_the_degree_falls_exactly() -> None:
    """A flat manipulator with all on one line: four poses coalesce at α = 180°, θ1 = 0."""
    m = family("both flat")
    b1 = Fraction(3)
    squares = [b1**2, (b1 - 7 - 20) ** 2, (b1 - 16 - 6) ** 2]
    form = Closure.of(SliceMap.of(m), squares).sextic
    assert form.degree == 2
    other = Closure.of(SliceMap.of(m), [x + 1 for x in squares]).sextic
    assert other.degree > 2


@given(ANY_MANIPULATOR, SQUARES, st.sampled_from([Fraction(3), Fraction(1, 7), Fraction(10) ** 12]))
@examples(20)
def test_the_form_does_not_depend_on_the_unit(
    m: Manipulator, squares: tuple[Fraction, ...], unit: Fraction
) -> None:
    names = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
    larger = Manipulator(*(getattr(m, name) * unit for name in names), orientation=m.orientation)
    own = Closure.of(SliceMap.of(m), squares)
    scaled = Closure.of(SliceMap.of(larger), [s * unit**2 for s in squares])
    assert scaled.sextic == own.sextic


def test_the_common_denominator_clears_all_squares() -> None:
    closure = Closure(SliceMap.of(EXAMPLES["zein-flat"]), (Fraction(1, 4), Fraction(5, 6), Fraction(7)))
    assert closure.denominator == 12
    whole = Closure.of(SliceMap.of(EXAMPLES["innocenti"]), [Fraction(1)] * 3)
    assert whole.squares == (SliceMap.of(EXAMPLES["innocenti"]).scale ** 2,) * 3


HALVES = st.tuples(st.integers(-4, 4), st.integers(1, 4))
LARGER_SQUARES = st.tuples(*[rationals(1, 900, (1, 2))] * 3)


def solved(m: Manipulator, squares: Sequence[Fraction], digits: int = 20) -> Fibre:
    return fibre(Closure.of(SliceMap.of(m), squares), digits)


def squares_at(at: Constructed) -> list[Fraction]:
    m = at.manipulator
    base = ((Fraction(0), Fraction(0)), (m.a2x, Fraction(0)), (m.a3x, m.a3y))
    legs = [add(b, a, -1) for a, b in zip(base, at.pose.points, strict=True)]
    return [dot(leg, leg) for leg in legs]


def numbers(texts: Sequence[str]) -> list[mp.mpf]:
    return [mp.mpf(text) for text in texts]


def degrees(x: Sequence[Fraction]) -> mp.mpf:
    return mp.degrees(mp.atan2(*(mp.mpf(c.numerator) / c.denominator for c in reversed(x))))


def multiplicity(at: Constructed) -> int:
    """That of the constructed pose; 0 if it is not in the fibre."""
    alpha, theta = degrees(at.pose.alpha), degrees(at.pose.theta)
    found = [
        pose.multiplicity
        for pose in solved(at.manipulator, squares_at(at)).poses
        if max(abs(mp.mpf(t) - x) for t, x in zip(pose.texts, (alpha, theta), strict=False)) < 1e-12
    ]
    assert len(found) < 2
    return sum(found)


@pytest.mark.parametrize(
    ("construct", "expected"),
    [
        (constructed.ordinary, 1),
        (constructed.fold, 2),
        (constructed.legs_1_and_3_in_line, 2),
        (constructed.legs_2_and_3_in_line, 2),
        (constructed.lines_meet_in_b1, 2),
        (constructed.lines_meet_in_b3, 2),
        (constructed.cusp, 3),
        (lambda: constructed.cusp(Pose(TRIANGLE, Fraction(10), direction(1, 3), WEST), Fraction(25)), 3),
        (lambda: constructed.cusp(Pose(TRIANGLE, Fraction(10), WEST, direction(1, 3)), Fraction(25)), 3),
    ],
)
def test_as_many_poses_coalesce_as_were_made_to(construct: Callable[[], Constructed], expected: int) -> None:
    assert multiplicity(construct()) == expected


@given(HALVES, HALVES, st.integers(3, 30), st.tuples(*[st.integers(-25, 25)] * 3))
@examples(30)
def test_a_pose_is_found_again_with_its_coordinates(
    alpha: tuple[int, int], theta: tuple[int, int], l1: int, base: tuple[int, int, int]
) -> None:
    pose = Pose(TRIANGLE, Fraction(l1), direction(*theta), direction(*alpha))
    a2x, a3x, a3y = map(Fraction, base)
    assume(a2x or a3x or a3y)
    try:
        at = Constructed(pose, pose.manipulator(a2x, (a3x, a3y)))
    except ValueError:
        assume(False)
        raise
    squares = squares_at(at)
    assume(all(squares))
    answer = solved(at.manipulator, squares)
    assume(answer.circle_at is None)
    expected = [
        degrees(pose.alpha),
        *(degrees(add(b, a, -1)) for a, b in zip(((0, 0), (a2x, 0), (a3x, a3y)), pose.points, strict=True)),
        *(mp.mpf(x.numerator) / x.denominator for x in pose.points[0]),
    ]
    near = [
        texts
        for texts in (x.texts for x in answer.poses)
        if max(abs(a - b) for a, b in zip(numbers(texts), expected, strict=True)) < 1e-9
    ]
    assert len(near) == 1


@given(ANY_MANIPULATOR, LARGER_SQUARES)
@examples(30)
def test_every_pose_has_the_given_legs(m: Manipulator, squares: tuple[Fraction, ...]) -> None:
    answer = solved(m, squares)
    side = (m.d1**2 + m.d3**2 - m.d2**2) / (2 * m.d1)
    with mp.workdps(30):
        p = mp.mpf(side.numerator) / side.denominator
        height = mp.sqrt(max(_number(m.d3**2) - p**2, 0)) * (1 if m.orientation == "ccw" else -1)
        shape = [mp.mpc(0), mp.mpc(_number(m.d1)), mp.mpc(p, height)]
        base = [mp.mpc(0), mp.mpc(_number(m.a2x)), mp.mpc(_number(m.a3x), _number(m.a3y))]
        size = 1 + max(map(abs, [*shape, *base])) + mp.sqrt(_number(max(squares)))
        for pose in answer.poses:
            alpha, *thetas, x, y = numbers(pose.texts)
            turn = mp.expjpi(alpha / 180)
            for corner, foot, square, theta in zip(shape, base, squares, thetas, strict=True):
                leg = mp.mpc(x, y) + corner * turn - foot
                expected = mp.sqrt(_number(square)) * mp.expjpi(theta / 180)
                assert abs(leg - expected) < mp.mpf(10) ** -17 * size


def _number(x: Fraction) -> mp.mpf:
    return mp.mpf(x.numerator) / x.denominator


@given(ANY_MANIPULATOR, LARGER_SQUARES)
@examples(30)
def test_multiplicities_leave_an_even_number_of_poses_that_are_not_real(
    m: Manipulator, squares: tuple[Fraction, ...]
) -> None:
    """And the factors of the form have the degree 6 together."""
    answer = solved(m, squares)
    assert sum(degree * times for degree, times in answer.factors) == DEGREE
    missing = DEGREE - sum(pose.multiplicity for pose in answer.poses)
    if answer.circle_at is None:
        assert missing >= 0
        assert missing % 2 == 0


@given(manipulators(size=9, denominators=(1,)), LARGER_SQUARES)
@examples(20)
def test_as_many_simple_poses_as_the_form_has_real_roots(
    m: Manipulator, squares: tuple[Fraction, ...]
) -> None:
    """mpmath finds all complex roots."""
    closure = Closure.of(SliceMap.of(m), squares)
    form, answer = closure.sextic, fibre(closure, 15)
    assume(answer.method == "balls")
    with mp.workdps(60):
        coefficients = [
            mp.mpf(int(form.a[k])) + mp.sqrt(form.radicand) * mp.mpf(int(form.b[k])) for k in range(7)
        ]
        roots = mp.polyroots(coefficients[::-1], maxsteps=400, extraprec=400)
        real = sorted(2 * mp.atan(r.real) for r in roots if abs(r.imag) < 1e-25 * (1 + abs(r)))
    own = [float(pose.texts[0]) for pose in answer.poses]
    assert len(real) == len(own)
    assert all(abs(float(mp.degrees(x)) - y) < 1e-9 for x, y in zip(real, own, strict=True))


def test_poses_come_in_the_order_of_alpha_and_theta() -> None:
    answer = solved(EXAMPLES["innocenti"], [Fraction(x) ** 2 for x in ("14.98", "15", "12")])
    alphas = [float(pose.texts[0]) for pose in answer.poses]
    assert len(alphas) == 6
    assert alphas == sorted(alphas)
    pairs = solved(family("congruent, mirrored"), [Fraction(x**2) for x in (25, 26, 27)])
    both = [(float(pose.texts[0]), float(pose.texts[1])) for pose in pairs.poses]
    assert both == sorted(both)
    assert any(a[0] == b[0] for a, b in pairwise(both))


def test_balls_hold_the_angles_that_are_printed() -> None:
    for at in (constructed.cusp(), constructed.ordinary()):
        for pose in solved(at.manipulator, squares_at(at), 30).poses:
            with ctx.workprec(200):
                for ball, text in zip((pose.alpha, pose.theta), pose.texts, strict=False):
                    assert abs(ball - arb(text)) < abs(arb(text)) * arb(10) ** -28 + arb(10) ** -60


@pytest.mark.parametrize("digits", [15, 100, 400])
def test_every_text_has_the_digits_that_were_asked_for(digits: int) -> None:
    at = constructed.ordinary()
    for pose in solved(at.manipulator, squares_at(at), digits).poses:
        for text in pose.texts:
            significant = text.partition("e")[0].lstrip("-0.").replace(".", "")
            assert text == "0" or len(significant) == digits


def test_congruent_triangles_with_equal_legs_have_a_circle() -> None:
    equal = [Fraction(25)] * 3
    assert solved(family("congruent"), equal).circle_at == 0
    assert solved(Manipulator(-30, 0, -40, 30, 50, 40), equal).circle_at == 180
    for m in (family("similar"), family("congruent, mirrored")):
        assert solved(m, equal).circle_at is None
    assert solved(family("congruent"), [Fraction(25), Fraction(26), Fraction(27)]).circle_at is None


def test_two_poses_with_one_alpha_share_its_multiplicity() -> None:
    """Both triangles flat, on one line: at α = 0 leg 1 may point up or down, by symmetry alike."""
    m = family("both flat")
    b1 = (Fraction(6), Fraction(8))
    base, shape = (0, m.a2x, m.a3x), (0, m.d1, Fraction(16))
    squares = [(b1[0] + s - a) ** 2 + b1[1] ** 2 for a, s in zip(base, shape, strict=True)]
    answer = solved(m, squares)
    at_zero = [pose for pose in answer.poses if pose.texts[0] == "0"]
    assert [pose.texts[4:] for pose in at_zero] == [
        ("6.0000000000000000000", "-8.0000000000000000000"),
        ("6.0000000000000000000", "8.0000000000000000000"),
    ]
    assert {pose.multiplicity for pose in at_zero} == {1}
    assert hypot(6, 8) ** 2 == squares[0]


def test_two_singular_poses_with_one_alpha_have_two_each() -> None:
    """Flat and similar: the leg lines of a pose with α = 0 meet in one point, whatever B1."""
    answer = solved(Manipulator(20, 6, 0, 10, 7, 3), [Fraction(x) for x in (100, 80, 73)])
    at_zero = [(pose.texts[1][:7], pose.multiplicity) for pose in answer.poses if pose.texts[0] == "0"]
    assert at_zero == [("-53.130", 2), ("53.1301", 2)]


def test_no_real_pose_is_no_error() -> None:
    answer = solved(EXAMPLES["innocenti"], [Fraction(225), Fraction(40_000), Fraction(1)])
    assert (answer.poses, answer.circle_at) == ((), None)


def test_where_the_form_vanishes_nothing_is_claimed() -> None:
    """Of no manipulator that is let in does it vanish; should it, any α would do."""
    closure = Closure.of(SliceMap.of(EXAMPLES["innocenti"]), [Fraction(225)] * 3)
    vars(closure)["sextic"] = QuadraticPoly.rational([], closure.slice_map.radicand)
    with pytest.raises(SolverError, match="movable with all legs locked"):
        fibre(closure, 15)
