from fractions import Fraction

import pytest
from flint import arb, ctx, fmpz_poly
from hypothesis import given, settings
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, eliminate
from rpr_solver.exact.factors import exact_roots, norm_factors
from rpr_solver.exact.number_field import (
    Algebraic,
    Field,
    adjoin_real_roots,
    common_roots,
    evaluate,
    poly_gcd,
    poly_mod,
    squarefree_part,
)
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import bisected, real_roots


def field_of(coefficients: list[int], which: int = -1) -> Field:
    return Field.of_root(real_roots(QuadraticPoly.rational(coefficients))[which])


SQRT2 = field_of([-2, 0, 1])


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


def test_the_embedding_chooses_the_sign() -> None:
    assert field_of([-2, 0, 1], which=0).generator.sign == -1


def test_signs_of_numbers_closer_than_doubles_can_tell() -> None:
    x = SQRT2.generator
    close = Fraction(1414213562373095048801688724209698078569671875376948, 10**51)
    assert (SQRT2(close) - x).sign == -1
    assert (SQRT2(close + Fraction(1, 10**51)) - x).sign == 1


def test_polynomials_over_a_field() -> None:
    x, one, zero = SQRT2.generator, SQRT2(1), SQRT2(0)
    square = [x * x, x * -2, one]  # (t - sqrt 2)²
    assert len(squarefree_part(square)) == 2
    quotient, rest = poly_mod([SQRT2(-2), zero, one], [-x, one])
    assert rest == []
    assert (evaluate(quotient, zero) - x).is_zero
    assert len(poly_gcd(square, [SQRT2(-2), zero, one])) == 2


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
        assert evaluate([extension.field(c) for c in polynomial], extension.root).is_zero
        assert value(extension.lift(SQRT2.generator)) == pytest.approx(2**0.5)
        assert (extension.generator * extension.generator - 2).is_zero


def test_adjoining_a_root_with_irrational_coefficients() -> None:
    x = SQRT2.generator
    found = list(adjoin_real_roots(SQRT2, [-x, SQRT2(0), SQRT2(1)]))  # t² = sqrt 2
    assert [value(e.root) for e in found] == pytest.approx([-(2**0.25), 2**0.25])
    for extension in found:
        assert (extension.root * extension.root - extension.lift(x)).is_zero


def test_real_roots_are_decided_however_close() -> None:
    gap = 10**40
    # two real roots 1e-40 apart; and a pair that misses the real axis by as little
    close = fmpz_poly([-1, gap]) * fmpz_poly([0, 1]) * fmpz_poly([1, 0, 1])
    missed = fmpz_poly([1, 0, gap**2]) * fmpz_poly([-3, 1])
    assert len(real_roots(QuadraticPoly.rational(close))) == 2
    [root] = real_roots(QuadraticPoly.rational(missed))
    with ctx.workprec(100):
        assert root.refined(90).overlaps(arb(3))


def test_roots_over_a_quadratic_field() -> None:
    # x² − ω with ω = √2: the conjugate x² + √2 has no real root
    roots = real_roots(QuadraticPoly(fmpz_poly([0, 0, 1]), fmpz_poly([-1]), 2))
    assert [float(r.refined(60).mid()) for r in roots] == pytest.approx([-(2**0.25), 2**0.25])
    assert roots[1].refined(2000).rel_accuracy_bits() >= 2000


def test_a_wide_isolating_ball_is_refined_at_any_precision() -> None:
    """Evaluated at high precision only, the slope over this ball is too wide to exclude zero."""
    eliminant = eliminate(EXAMPLES["innocenti"])
    factors = norm_factors(eliminant.at(Fraction("14.98") * eliminant.slice_map.scale))
    for root in exact_roots(factors):
        assert root.root.refined(3466).rel_accuracy_bits() >= 3466


@given(
    st.lists(st.integers(-30, 30), min_size=1, max_size=6, unique=True),
    st.integers(1, 50),
    st.integers(-300, 300),
)
@settings(max_examples=40)
def test_bisection_finds_every_real_root(numbers: list[int], denominator: int, shift: int) -> None:
    """Clusters far from the unit circle, and pairs off the real axis beside them."""
    polynomial = fmpz_poly([4, 0, 1]) * fmpz_poly([shift**2 + 1, -2 * shift, 1])
    for number in numbers:
        polynomial *= fmpz_poly([-(number + denominator * shift), denominator])
    expected = sorted((number + denominator * shift) / denominator for number in numbers)
    exact = QuadraticPoly.rational(polynomial)
    found = (bisected(exact.ball(bits), bits) for bits in (256, 512, 1024, 2048))
    intervals = next(x for x in found if x is not None)
    assert len(intervals) == len(expected)
    with ctx.workprec(4096):
        truth = [arb(n + denominator * shift) / denominator for n in sorted(numbers)]
    assert all(x.overlaps(y) for x, y in zip(intervals, truth, strict=True))
    assert [float(r.refined(60).mid()) for r in real_roots(exact)] == pytest.approx(expected)


def test_a_cluster_far_out_is_not_lost() -> None:
    roots = real_roots(QuadraticPoly.rational([48390, -440, 1]))
    assert [float(r.refined(60).mid()) for r in roots] == pytest.approx([220 - 10**0.5, 220 + 10**0.5])


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


def test_forms_without_a_common_root_and_forms_that_are_zero() -> None:
    one, zero = SQRT2(1), SQRT2(0)
    assert common_roots([one, one], [-one, one], one) == []
    assert common_roots([one, zero], [one, one], one) == []
    assert common_roots([zero, zero], [zero], one) is None
