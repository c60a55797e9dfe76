"""Fibres of direct kinematics: poses that are known to be there, their multiplicities, and no others."""

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from math import hypot

import mpmath as mp
import pytest
from flint import arb, ctx
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator, SolverError
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.kinematics.closure import DEGREE, Closure
from rpr_solver.kinematics.fibre import Fibre, fibre
from rpr_solver.model.slice_map import SliceMap
from tests.support import constructed
from tests.support.constructed import TRIANGLE, WEST, Constructed, Pose, add, direction, dot
from tests.support.families import FAMILIES, family
from tests.support.strategies import examples, manipulators, rationals

HALVES = st.tuples(st.integers(-4, 4), st.integers(1, 4))
SQUARES = st.tuples(*[rationals(1, 900, (1, 2))] * 3)
ANY_MANIPULATOR = st.one_of(manipulators(size=9), st.sampled_from(sorted(FAMILIES)).map(family))


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


@given(ANY_MANIPULATOR, SQUARES)
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


@given(ANY_MANIPULATOR, SQUARES)
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


@given(manipulators(size=9, denominators=(1,)), SQUARES)
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
            with ctx.workprec(pose.bits):
                for ball, text in zip((pose.alpha, pose.theta), pose.texts, strict=False):
                    assert abs(ball - arb(text)) < abs(arb(text)) * arb(10) ** -28 + arb(10) ** -60


@pytest.mark.parametrize(("digits", "bits"), [(15, 50), (100, 333), (400, 1329)])
def test_every_text_has_the_digits_that_were_asked_for(digits: int, bits: int) -> None:
    at = constructed.ordinary()
    for pose in solved(at.manipulator, squares_at(at), digits).poses:
        assert pose.bits > bits
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
