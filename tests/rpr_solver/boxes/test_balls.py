"""Balls in doubles hold what FLINT's balls hold, on every operation and at extreme numbers."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan

import numpy as np
import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.boxes import Balls, Combinations

FINITE = st.floats(allow_nan=False, allow_infinity=False)
ORDINARY = st.floats(-1e3, 1e3)
RADII = st.floats(0, 10) | st.floats(0, 1e-300) | st.just(0.0)
SHARES = st.floats(-1, 1)
Ball = tuple[float, float, float]
"""A midpoint, a radius, and the place of a number in the ball as a share of the radius."""
BALLS = st.tuples(ORDINARY | FINITE, RADII, SHARES)
PLAIN = st.tuples(ORDINARY, RADII, SHARES)


@pytest.fixture(autouse=True)
def _precise() -> object:
    with ctx.workprec(3000), np.errstate(all="ignore"):
        yield


def balls(*parts: Ball) -> Balls:
    return Balls(np.array([x for x, _, _ in parts]), np.array([r for _, r, _ in parts]))


def number(ball: Ball) -> arb:
    """A number of a ball, exactly."""
    mid, radius, share = map(arb, ball)
    return mid + radius * share


def held(x: arb, found: Balls) -> bool:
    """Whether a number is in the only ball of an array, or this stands for all numbers."""
    mid, radius = float(found.mid.ravel()[0]), float(found.rad.ravel()[0])
    if not np.isfinite(mid) or not np.isfinite(radius):
        return True
    return bool(abs(x - arb(mid)) <= arb(radius))


OPERATIONS: list[Callable[[Balls | arb, Balls | arb], Balls | arb]] = [
    lambda x, y: x + y,
    lambda x, y: x - y,
    lambda x, y: x * y,
]


@pytest.mark.parametrize("operation", OPERATIONS)
@given(first=BALLS, second=BALLS)
def test_sums_and_products_hold_all_results(
    operation: Callable[[Balls | arb, Balls | arb], Balls | arb], first: Ball, second: Ball
) -> None:
    exact = operation(number(first), number(second))
    assert held(exact, operation(balls(first), balls(second)))  # type: ignore[arg-type]


@given(first=BALLS, second=BALLS)
def test_quotients_hold_all_results(first: Ball, second: Ball) -> None:
    divisor = number(second)
    if divisor.contains(0):
        return
    assert held(number(first) / divisor, balls(first) / balls(second))


@given(ball=BALLS)
def test_sines_and_cosines_hold_all_results(ball: Ball) -> None:
    sin, cos = balls(ball).sin_cos()
    exact = number(ball).sin_cos()
    assert held(exact[0], sin)
    assert held(exact[1], cos)


@given(parts=st.lists(BALLS, min_size=1, max_size=12))
def test_sums_along_an_axis_hold_all_results(parts: list[Ball]) -> None:
    exact = sum((number(x) for x in parts), arb(0))
    assert held(exact, balls(*parts).sum(0))


@given(terms=st.lists(st.tuples(PLAIN, PLAIN), min_size=1, max_size=12))
def test_combinations_hold_all_results(terms: list[tuple[Ball, Ball]]) -> None:
    coefficients = [arb(mid, radius) for (mid, radius, _), _ in terms]
    found = Combinations([coefficients]).of(Balls.stacked([balls(x) for _, x in terms]))
    exact = sum((number(c) * number(x) for c, x in terms), arb(0))
    assert held(exact, found)


def test_sines_and_cosines_of_numpy_are_as_exact_as_is_assumed() -> None:
    draw = np.random.default_rng(1)
    sizes = [draw.uniform(-x, x, 4000) for x in (1e-9, 1.0, 10.0, 1e4, 1e9, 1e300)]
    near = np.array([k * np.pi / 2 + d for k in range(-40, 40) for d in (-1e-15, 0, 1e-15)])
    points = np.concatenate([*sizes, near])
    with ctx.workprec(1200):
        for x, sin, cos in zip(points.tolist(), np.sin(points), np.cos(points), strict=True):
            exact = arb(x).sin_cos()
            assert abs(arb(float(sin)) - exact[0]) < arb(2) ** -50
            assert abs(arb(float(cos)) - exact[1]) < arb(2) ** -50


def test_doubles_are_those_of_ieee_754() -> None:
    least = np.array([5e-324])
    assert ((least * 1.0) > 0).all(), "results are flushed to zero"
    assert (least / 2 * 2 == 0).all()
    x = np.array([1 + 2.0**-30])
    assert (x * x - (1 + 2.0**-29) == 0).all(), "products are fused with sums"


@pytest.mark.parametrize("mid", [0.0, 1.0, inf, nan])
@pytest.mark.parametrize("rad", [inf, nan])
def test_no_operation_makes_something_of_a_ball_of_all_numbers(mid: float, rad: float) -> None:
    every, one = Balls(np.array([mid]), np.array([rad])), Balls.exact(np.array([1.0]))
    zero = Balls.exact(np.array([0.0]))
    combined = Combinations([[arb(1), arb(0)]])
    results = [every + one, one - every, every * one, zero * every, every / one, one / every]
    results += [*every.sin_cos(), Balls.stacked([every, one]).sum(0)]
    results.append(combined.of(Balls.stacked([every, one])))
    for found in results:
        assert not found.excludes_zero.any()
        assert found.holds([1e300]).all()


@given(first=FINITE, second=FINITE)
def test_an_overflow_excludes_nothing(first: float, second: float) -> None:
    x, y = Balls.exact(np.array([first])), Balls.exact(np.array([second]))
    combined = Combinations([[arb(1e308), arb(1e308)]]).of(Balls.stacked([x, y]))
    for found in (x * y, x + y, combined):
        assert np.isfinite(found.mid).all() or not found.excludes_zero.any()


@pytest.mark.parametrize("operation", [*OPERATIONS, lambda x, y: x / y])
@given(first=st.floats(0.5, 1e3), second=st.floats(0.5, 1e3))
def test_bounds_are_no_wider_than_a_few_roundings(
    operation: Callable[[Balls, Balls], Balls], first: float, second: float
) -> None:
    """Wider ones would be true as well, and would decide nothing."""
    found = operation(balls((first, 0, 0)), balls((second, 0, 0)))
    assert found.rad[0] <= 4 * 2.0**-52 * max(first, second, abs(found.mid[0]))


@given(angle=st.floats(-400, 400))
def test_bounds_of_sines_and_cosines_are_narrow(angle: float) -> None:
    assert max(part.rad[0] for part in balls((angle, 0, 0)).sin_cos()) <= 2.0**-48
