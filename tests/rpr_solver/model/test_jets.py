"""Jets against central differences of the functions that they stand for, and the rules of derivation."""

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from math import comb

import mpmath as mp
import pytest
from flint import arb, ctx, fmpq_mpoly_ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import Manipulator
from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.slice_map import SliceMap
from tests.support.strategies import examples, manipulators, rationals

ORDER = 3
Function = Callable[[mp.mpf, mp.mpf], mp.mpf]
HEXAGON = Manipulator(*map(Fraction, (7, 3, 5, 4, 5, 6)), orientation="cw")
"""Small integers, and a height that is irrational."""
PLACES = [("0.7", "-1.9", 5), ("3.1", "0.02", 3), ("-2.2", "2.8", 11)]
TINY = mp.mpf(10) ** -12


def number(x: Fraction | int) -> mp.mpf:
    x = Fraction(x)
    return mp.mpf(x.numerator) / x.denominator


def squared_legs(m: Manipulator, leg: int, length: Fraction) -> tuple[Function, Function]:
    """The squared lengths of the free legs, in the order of their numbers, by the corners' coordinates."""
    p = number((m.d1**2 + m.d3**2 - m.d2**2) / (2 * m.d1))
    h = mp.sqrt(abs(number(m.d3**2) - p**2)) * (1 if m.orientation == "ccw" else -1)
    platform = [mp.mpc(0), mp.mpc(number(m.d1)), mp.mpc(p, h)]
    base = [mp.mpc(0), mp.mpc(number(m.a2x)), mp.mpc(number(m.a3x), number(m.a3y))]

    def square(other: int) -> Function:
        def value(alpha: mp.mpf, theta: mp.mpf) -> mp.mpf:
            joint = base[leg - 1] + number(length) * mp.expj(theta)
            vector = joint + mp.expj(alpha) * (platform[other] - platform[leg - 1]) - base[other]
            return vector.real**2 + vector.imag**2

        return value

    first, second = (square(i) for i in range(3) if i != leg - 1)
    return first, second


def difference(function: Function, place: tuple[mp.mpf, mp.mpf], i: int, j: int) -> mp.mpf:
    """∂α^i ∂θ^j by central differences of second order; the error is of the order of the step squared."""
    step = mp.mpf(10) ** -10

    def weight(n: int, k: int) -> int:
        return (-1) ** k * comb(n, k)

    total = mp.fsum(
        weight(i, k)
        * weight(j, m)
        * function(place[0] + step * (mp.mpf(i) / 2 - k), place[1] + step * (mp.mpf(j) / 2 - m))
        for k in range(i + 1)
        for m in range(j + 1)
    )
    return total / step ** (i + j)


def pose_at(slice_map: SliceMap, alpha: str, theta: str, length: Fraction) -> Pose[mp.mpf]:
    """In scaled units, over mpmath's numbers: a jet takes any ring."""
    a, t = mp.mpf(alpha), mp.mpf(theta)
    return Pose(
        mp.cos(a), mp.sin(a), mp.cos(t), mp.sin(t),
        number(length * slice_map.scale), mp.sqrt(slice_map.radicand),
    )  # fmt: skip


@pytest.mark.parametrize(("alpha", "theta", "length"), PLACES)
def test_the_jacobian_determinant_and_its_derivative_along_the_kernel(
    alpha: str, theta: str, length: int
) -> None:
    """J and E, and v·∇E after them, by differences of differences."""
    slice_map = SliceMap.of(HEXAGON)
    with mp.workdps(80):
        local = LocalMap.at(slice_map, pose_at(slice_map, alpha, theta, Fraction(length)), ORDER)
        f, g = (scaled(square, slice_map) for square in squared_legs(HEXAGON, 1, Fraction(length)))
        place = mp.mpf(alpha), mp.mpf(theta)

        def wedge(first: Function, second: Function) -> Function:
            def value(*at: mp.mpf) -> mp.mpf:
                (a, b), (c, d) = ((difference(x, at, 1, 0), difference(x, at, 0, 1)) for x in (first, second))
                return a * d - b * c

            return value

        j = wedge(f, g)
        for jet, leg in ((local.f, f), (local.g, g)):
            jets = [local.singularity()]
            functions = [j]
            for _ in range(2):
                jets.append(local.along(jet, jets[-1]))
                functions.append(wedge(leg, functions[-1]))
            assert [x.order for x in jets] == [2, 1, 0]
            for x, function in zip(jets, functions, strict=True):
                expected = function(*place)
                assert abs(x.value / expected - 1) < TINY


def scaled(square: Function, slice_map: SliceMap) -> Function:
    """f/2 in scaled units."""
    factor = number(slice_map.scale) ** 2 / 2
    return lambda *at: factor * square(*at)


# the rules, on polynomials, whose derivatives FLINT takes

X, Y = fmpq_mpoly_ctx.get(("x", "y"), "lex").gens()


# rings


@cache
def golden() -> Algebraic:
    return Field(real_roots(QuadraticPoly.rational([-1, -1, 1]))[1]).generator


@given(
    manipulators(size=9),
    rationals(-3, 3, (1, 2, 3)),
    rationals(-3, 3, (1, 2, 3)),
    rationals(1, 9, (1, 2)),
    st.sampled_from([1, 2, 3]),
)
@examples(20)
def test_balls_hold_what_a_number_field_has_exactly(
    m: Manipulator, t: Fraction, u: Fraction, length: Fraction, leg: int
) -> None:
    """The golden ratio stands for ω too: the closed formulas hold for any number there."""
    slice_map, field = SliceMap.of(m, leg), golden().field
    entries = [*map(field, (*trig(t), *trig(u), length)), golden()]
    in_field = LocalMap.at(slice_map, Pose(*entries), 4)
    with ctx.workprec(200):
        in_balls = LocalMap.at(slice_map, Pose(*(x.ball(200) for x in entries)), 4)
        for a, b in ((in_field.f, in_balls.f), (in_field.g, in_balls.g)):
            for x, ball in zip(sum(a.table, ()), sum(b.table, ()), strict=True):
                assert ball.overlaps(x.ball(200))
                assert x.is_zero or ball.rel_accuracy_bits() > 100 or abs(x.ball(200)) < arb(2) ** -90


def trig(t: Fraction) -> tuple[Fraction, Fraction]:
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
