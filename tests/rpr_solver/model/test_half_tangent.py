"""Angles by half tangents against mpmath's, and common roots of forms against roots that were put in."""

from math import prod

import mpmath as mp
import pytest
from flint import arb, ctx, fmpz_poly
from hypothesis import assume, example, given
from hypothesis import strategies as st

from rpr_solver.model.jets import HalfTangent, common_root

RATIOS = st.tuples(st.integers(-50, 50), st.integers(-50, 50)).filter(any)
FACTORS = st.lists(RATIOS, max_size=4)
QUADRATICS = st.lists(st.tuples(*[st.integers(-9, 9)] * 3).filter(any), max_size=1)


def half_tangent(n: int, d: int) -> HalfTangent:
    return HalfTangent(arb(n), arb(d))


def angle(n: int, d: int) -> mp.mpf:
    """2 atan(n/d) in degrees, in (−180, 180]."""
    return mp.degrees(2 * mp.atan(mp.mpf(n) / d)) if d else mp.mpf(180)


@pytest.mark.parametrize("side", [1, -1])
def test_degrees_are_sharp_on_both_sides_of_the_half_turn(side: int) -> None:
    """Where the tangent itself would be a ball without end, and where it is tiny."""
    with ctx.workprec(300), mp.workdps(60):
        near = HalfTangent(arb(side), arb(10) ** -40).degrees()
        gap = mp.mpf((180 - side * near).str(20, radius=False))
        assert abs(gap * mp.mpf(10) ** 40 / mp.degrees(2) - 1) < 1e-15
        tiny = HalfTangent(arb(10) ** -40, arb(side)).degrees()
        assert abs(mp.mpf(tiny.str(20, radius=False)) * side * mp.mpf(10) ** 40 / mp.degrees(2) - 1) < 1e-15


# common roots


def form(roots: list[tuple[int, int]], others: list[tuple[int, ...]]) -> list[arb]:
    """Ascending coefficients of Π (d t − n) and other factors; a root (n, 0) lowers the degree by one."""
    p = prod(
        [fmpz_poly([-n, d]) for n, d in roots] + [fmpz_poly(list(c)) for c in others], start=fmpz_poly([1])
    )
    degree = len(roots) + 2 * len(others)
    return [arb(p[k]) for k in range(degree + 1)]


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
