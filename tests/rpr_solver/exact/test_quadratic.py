"""A + ω B in one variable, against evaluation in the number field ℚ(ω)."""

import pytest
from flint import arb, ctx, fmpz_poly
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver.exact.modular import primes
from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.exact.quadratic import DivisionError, Form, QuadraticPoly, omega_ball
from rpr_solver.exact.real_roots import real_roots

FIELDS = {1: Field.rationals()} | {
    r: Field(real_roots(QuadraticPoly.rational([-r, 0, 1]))[-1]) for r in (2, 3, 12, 1009)
}
coefficients = st.lists(st.integers(-50, 50), max_size=5).map(fmpz_poly)


@st.composite
def polynomials(draw: st.DrawFn, count: int) -> list[QuadraticPoly]:
    """Several polynomials over one ring ℤ[ω]."""
    radicand = draw(st.sampled_from(sorted(FIELDS)))
    nothing = st.just(fmpz_poly([]))
    parts = [(draw(coefficients), draw(nothing if radicand == 1 else coefficients)) for _ in range(count)]
    return [QuadraticPoly(a, b, radicand) for a, b in parts]


def omega(radicand: int) -> Algebraic:
    field = FIELDS[radicand]
    return field(1) if radicand == 1 else field.generator


def value(p: QuadraticPoly, x: int) -> Algebraic:
    """At x + 2 ω, which is irrational unless the field is ℚ."""
    w = omega(p.radicand)
    return p(w * 2 + x, w)


def equal(x: Algebraic, y: Algebraic) -> bool:
    return (x - y).is_zero


@given(polynomials(2), st.integers(-5, 5))
def test_evaluation_is_a_ring_map(pair: list[QuadraticPoly], x: int) -> None:
    p, q = pair
    assert equal(value(p + q, x), value(p, x) + value(q, x))
    assert equal(value(p - q, x), value(p, x) - value(q, x))
    assert equal(value(p * q, x), value(p, x) * value(q, x))
    assert equal(value(p * -7, x), value(p, x) * -7)


@given(polynomials(1))
def test_the_norm_is_the_product_with_the_conjugate(single: list[QuadraticPoly]) -> None:
    [p] = single
    square = p * p.conjugate
    assert not square.b
    assert square.a == (p.norm if p.b else p.norm**2)
    assert p.conjugate.conjugate == p


@given(polynomials(2))
def test_a_product_divided_by_a_factor(pair: list[QuadraticPoly]) -> None:
    p, q = pair
    assume(not q.is_zero)
    assert (p * q).quotient(q) in (p.primitive(), p.primitive() * -1)
    if q.a:
        assert (p * QuadraticPoly.rational(q.a, q.radicand)) / q.a == p


@given(polynomials(2))
def test_a_remainder_is_refused(pair: list[QuadraticPoly]) -> None:
    p, q = pair
    assume(q.norm.degree() > 0)
    with pytest.raises(DivisionError):
        (p * q + QuadraticPoly.rational([1], q.radicand)).quotient(q)


@given(polynomials(2), st.integers(0, 3))
def test_a_residue_is_a_ring_map(pair: list[QuadraticPoly], which: int) -> None:
    p, q = pair
    generator = primes(p.radicand)
    prime, root = [next(generator) for _ in range(which + 1)][-1]
    for w in (root, -root % prime) if p.radicand != 1 else (root,):
        assert (p * q).residue(prime, w) == p.residue(prime, w) * q.residue(prime, w)
        assert (p + q).residue(prime, w) == p.residue(prime, w) + q.residue(prime, w)


@given(polynomials(1), st.integers(-5, 5))
def test_a_ball_holds_the_value(single: list[QuadraticPoly], x: int) -> None:
    [p] = single
    ball = p.ball(100)
    with ctx.workprec(100):
        at_x = ball(arb(x) + 2 * omega_ball(p.radicand, 100))
    assert at_x.overlaps(value(p, x).ball(200))
    assert p.ball(100) is ball
    assert p.conjugate.ball(100) is not ball


@given(polynomials(1))
def test_the_1_norm_bounds_the_coefficients(single: list[QuadraticPoly]) -> None:
    [p] = single
    with ctx.workprec(64):
        for sign in (1, -1):
            w = sign * omega_ball(p.radicand, 64)
            total = sum((abs(p.coefficient(k, w)) for k in range(p.degree + 1)), arb(0))
            assert total <= p.norm1()


def test_a_lower_degree_is_a_zero_at_infinity() -> None:
    line = Form(QuadraticPoly(fmpz_poly([1, 2]), fmpz_poly([3]), 2), 3)
    plane = Form(QuadraticPoly.rational([5, 0, 1], 2), 2)
    assert (line.zeros_at_infinity, plane.zeros_at_infinity) == (2, 0)
    product = line * plane
    assert (product.degree, product.zeros_at_infinity) == (5, 2)
    assert product.quotient(plane) == line
    assert product.quotient(line) == plane
