"""The closure equations and the sixth-degree form, against a solution of the equations by Cramer's rule."""

from fractions import Fraction

import mpmath as mp
import pytest
from flint import arb, ctx
from hypothesis import assume, example, given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.kinematics.closure import DEGREE, Closure, LinearSystem
from rpr_solver.model.slice_map import SliceMap
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


def solved(v: list[Vector], squares: list[arb]) -> tuple[arb, arb, arb]:
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
        determinant, x, y = solved(v, [ball_of(s) for s in squares])
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
            determinant, x, y = solved(sides(m, t), [ball_of(s) for s in squares])
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
