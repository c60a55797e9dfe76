"""The closure equations, and fibres: poses that are known to be there, multiplicities, and no others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import hypot

import mpmath as mp
import pytest
from flint import arb, ctx
from hypothesis import assume, example, given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator, SolverError
from rpr_solver.exact.quadratic import QuadraticPoly, omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.fibre import Closure, Fibre, fibre
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


LARGER_SQUARES = st.tuples(*[rationals(1, 900, (1, 2))] * 3)


def solved(m: Manipulator, squares: Sequence[Fraction], digits: int = 20) -> Fibre:
    return fibre(Closure.of(SliceMap.of(m), squares), digits)


def squares_at(at: Constructed) -> list[Fraction]:
    m = at.manipulator
    base = ((Fraction(0), Fraction(0)), (m.a2x, Fraction(0)), (m.a3x, m.a3y))
    legs = [add(b, a, -1) for a, b in zip(base, at.pose.points, strict=True)]
    return [dot(leg, leg) for leg in legs]


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


def test_where_the_form_vanishes_nothing_is_claimed() -> None:
    """Of no manipulator that is let in does it vanish; should it, any α would do."""
    closure = Closure.of(SliceMap.of(EXAMPLES["innocenti"]), [Fraction(225)] * 3)
    vars(closure)["sextic"] = QuadraticPoly.rational([], closure.slice_map.radicand)
    with pytest.raises(SolverError, match="movable with all legs locked"):
        fibre(closure, 15)
