from fractions import Fraction

import pytest
from flint import arb, fmpq_poly, nmod_poly
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver.errors import Unproved
from rpr_solver.exact.number_field import (
    Algebraic,
    BallRoot,
    Field,
    adjoin_real_roots,
    common_roots,
    evaluate,
    poly_gcd,
    poly_mod,
    poly_product,
    trimmed,
)
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import real_roots


def field_of(coefficients: list[int], which: int = -1) -> Field:
    return Field(real_roots(QuadraticPoly.rational(coefficients))[which])


SQRT2 = field_of([-2, 0, 1])


def test_a_root_is_refined_from_a_ball_in_which_the_slope_has_zeros() -> None:
    cubic = [SQRT2(c) for c in (100, -3, 0, 1)]
    root = BallRoot(cubic, arb(0, 1000))(128)
    assert root.rad() < 2**-100
    assert (root**3 - 3 * root + 100).contains(0)


def test_field_arithmetic_is_exact() -> None:
    x = SQRT2.generator
    assert (x * x - 2).is_zero
    assert ((x + 1) * (x + 1).inverse() - 1).is_zero
    assert (x - 1).sign == 1
    assert (x - 2).sign == -1
    assert (x * x - 2).sign == 0
    assert (x * x).rational == 2
    assert x.rational is None
    with pytest.raises(ZeroDivisionError):
        (x * x - 2).inverse()


def test_signs_of_numbers_closer_than_doubles_can_tell() -> None:
    x = SQRT2.generator
    close = Fraction(1414213562373095048801688724209698078569671875376948, 10**51)
    assert (SQRT2(close) - x).sign == -1
    assert (SQRT2(close + Fraction(1, 10**51)) - x).sign == 1


OCTIC = field_of([7, -40, 0, 9, 1, 0, -12, 0, 1])
COEFFICIENTS = st.lists(st.integers(-20, 20), min_size=1, max_size=4)


@st.composite
def polynomials(draw: st.DrawFn) -> list[Algebraic]:
    """Of degree 3 at most, over a field of degree 8, with denominators."""
    rows = draw(st.lists(COEFFICIENTS, min_size=1, max_size=4))
    return trimmed([OCTIC(fmpq_poly(row, draw(st.integers(1, 9)))) for row in rows])


@given(polynomials(), polynomials(), polynomials())
def test_the_greatest_common_divisor_of_multiples(
    a: list[Algebraic], b: list[Algebraic], shared: list[Algebraic]
) -> None:
    """What it divides it divides; and it is divided by what both share."""
    assume(a and b and shared)
    first, second = poly_product(a, shared), poly_product(b, shared)
    common = poly_gcd(first, second)
    assert all(poly_mod(x, common)[1] == [] for x in (first, second))
    assert poly_mod(common, shared)[1] == []
    assert (common[-1] - 1).is_zero
    if len(poly_gcd(a, b)) == 1:
        assert len(common) == len(shared)


def test_a_place_that_divides_a_leading_coefficient_proves_nothing() -> None:
    """Modulo p the forms (p t + 1)(t + 1) and (p t + 1)(t + 2) have no common root."""
    place = OCTIC.place
    assert place is not None
    p, root = place
    assert int(nmod_poly(OCTIC.root.polynomial.a, p)(root)) == 0
    shared = [OCTIC(1), OCTIC(p)]
    first, second = (poly_product(shared, [OCTIC(c), OCTIC(1)]) for c in (1, 2))
    assert len(poly_gcd(first, second)) == 2
    divided = [[c * OCTIC(Fraction(1, p)) for c in x] for x in (first, second)]
    assert len(poly_gcd(*divided)) == 2


def value(x: Algebraic) -> float:
    return float(x.ball(64).mid())


@pytest.mark.parametrize(
    ("polynomial", "expected"),
    [
        ([-3, 0, 1], [-(3**0.5), 3**0.5]),
        ([-8, 0, 1], [-(8**0.5), 8**0.5]),  # already in the field
        ([1, 0, 1], []),
        ([5, 1], [-5.0]),
    ],
)
def test_adjoining_real_roots(polynomial: list[int], expected: list[float]) -> None:
    found = list(adjoin_real_roots(SQRT2, [SQRT2(c) for c in polynomial]))
    assert [value(e.root) for e in found] == pytest.approx(expected)
    for extension in found:
        assert evaluate([extension.root.field(c) for c in polynomial], extension.root).is_zero
        assert value(extension.lift(SQRT2.generator)) == pytest.approx(2**0.5)
        assert (extension.generator * extension.generator - 2).is_zero


def test_common_roots_of_two_forms_with_what_they_carry() -> None:
    x = SQRT2.generator
    one, zero = SQRT2(1), SQRT2(0)
    # t² − √2 and (t² − √2)(t − 1), both with a zero at t = ∞
    first = [-x, zero, one, zero]
    second = [x, -x, -one, one, zero]
    roots = common_roots(first, second, x)
    assert roots is not None
    assert roots[0][0] is None
    assert (roots[0][1][0] - x).is_zero
    assert [value(t) for t, _ in roots if t] == pytest.approx([-(2**0.25), 2**0.25])
    for t, (lifted,) in roots:
        assert t is None or (t * t - lifted).is_zero


def test_a_root_is_adjoined_to_a_larger_field() -> None:
    """With a cubic over a field of degree 8, whose norm may have factors."""
    field = field_of([7, -3, 0, 5, -11, 2, 0, -4, 1])
    x = field.generator
    cubic = [x * x - 3, field(-5), x, field(2)]
    extensions = list(adjoin_real_roots(field, cubic))
    assert extensions
    for extension in extensions:
        assert evaluate([extension.lift(c) for c in cubic], extension.root).is_zero
        modulus = [extension.root.field(c) for c in field.modulus.coeffs()]
        assert evaluate(modulus, extension.generator).is_zero
        assert value(extension.generator) == pytest.approx(value(x))


def test_an_inverse_that_takes_too_long_is_refused() -> None:
    field = field_of([3, *[0] * 62, -5, 1])
    with pytest.raises(Unproved, match="degree 64"):
        field(fmpq_poly([10**3000 + k for k in range(64)])).inverse()
