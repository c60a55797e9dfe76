from decimal import ROUND_HALF_UP, Context, Decimal
from fractions import Fraction

import pytest
from flint import arb, ctx
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver.exact.decimals import place_digits, round_ball, round_fraction, shorten

RATIONALS = st.fractions(max_denominator=10**12).filter(bool)
EXPONENTS = st.integers(-40, 40)


def rounded(x: Fraction, digits: int) -> Decimal:
    wide = Context(prec=400).divide(Decimal(x.numerator), Decimal(x.denominator))
    return Context(prec=digits, rounding=ROUND_HALF_UP).plus(wide)


@given(RATIONALS, EXPONENTS, st.integers(1, 60))
def test_rationals_are_rounded_correctly(x: Fraction, exponent: int, digits: int) -> None:
    x *= Fraction(10) ** exponent
    assert Decimal(round_fraction(x, digits)) == rounded(x, digits)


@given(RATIONALS, EXPONENTS, st.integers(1, 60))
def test_a_ball_is_rounded_as_the_number_in_it_or_not_at_all(x: Fraction, exponent: int, digits: int) -> None:
    x *= Fraction(10) ** exponent
    with ctx.workprec(400):
        text = round_ball(arb(x.numerator) / x.denominator, digits)
    if text is None:
        scaled = abs(x) * Fraction(10) ** (digits - 1 - rounded(x, digits).adjusted())
        assert (2 * scaled).denominator == 1 or (20 * scaled).denominator == 1
    else:
        assert text == round_fraction(x, digits)


def test_a_ball_too_wide_for_its_digits_is_not_rounded() -> None:
    with ctx.workprec(200):
        assert round_ball(arb("1.5 +/- 1e-9"), 9) is not None
        assert round_ball(arb("1.5 +/- 1e-9"), 12) is None
        assert round_ball(arb("0 +/- 1e-50"), 15) is None
        assert round_ball(arb("9.99999999 +/- 1e-20"), 3) == "10.0"
        assert round_ball(arb("nan"), 3) is None


def test_zero_is_zero() -> None:
    assert round_ball(arb(0), 20) == round_fraction(Fraction(0), 20) == "0"


@pytest.mark.parametrize(
    ("significant", "place", "text"),
    [("123", 2, "123"), ("123", 1, "12.3"), ("123", 3, "1.23e+3"), ("123", -1, "0.123"),
     ("123", -7, "0.000000123"), ("123", -8, "1.23e-8"), ("1", 0, "1"), ("5", -9, "5e-9")],
)  # fmt: skip
def test_digits_are_plain_where_they_can_be(significant: str, place: int, text: str) -> None:
    assert place_digits(significant, place, negative=False) == text
    assert place_digits(significant, place, negative=True) == "-" + text


@given(RATIONALS, EXPONENTS, st.integers(1, 20), st.integers(0, 20))
def test_shortening_is_rounding_once(x: Fraction, exponent: int, digits: int, more: int) -> None:
    x *= Fraction(10) ** exponent
    stored = round_fraction(x, digits + more)
    short = shorten(stored, digits)
    if short is None:
        assume(more > 0)
        assert stored.partition("e")[0].rstrip("0").endswith("5")
    else:
        assert short == round_fraction(x, digits)
