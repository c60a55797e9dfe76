from decimal import ROUND_DOWN, Inexact, localcontext
from fractions import Fraction
from math import floor

import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.exact.decimals import (
    angle_text,
    place_digits,
    round_ball,
    round_fraction,
    shorten,
    sorted_by_balls,
)

RATIONALS = st.fractions(max_denominator=10**12).filter(bool)
EXPONENTS = st.integers(-40, 40)


def rounded(x: Fraction, digits: int) -> tuple[Fraction, Fraction]:
    """The nearest number of ``digits`` digits, halves away from 0; and one unit of its last digit."""
    place = 0
    while abs(x) >= Fraction(10) ** (place + 1):
        place += 1
    while abs(x) < Fraction(10) ** place:
        place -= 1
    unit = Fraction(10) ** (place - digits + 1)
    size = floor(abs(x) / unit + Fraction(1, 2)) * unit
    return (size if x > 0 else -size), unit


def significant(text: str) -> str:
    return text.lstrip("-").partition("e")[0].replace(".", "").lstrip("0")


@given(RATIONALS, EXPONENTS, st.integers(1, 60))
def test_rationals_are_rounded_correctly(x: Fraction, exponent: int, digits: int) -> None:
    x *= Fraction(10) ** exponent
    text = round_fraction(x, digits)
    assert Fraction(text) == rounded(x, digits)[0]
    assert len(significant(text)) == digits


@given(RATIONALS, EXPONENTS, st.integers(1, 60))
def test_a_ball_is_rounded_as_the_number_in_it_or_not_at_all(x: Fraction, exponent: int, digits: int) -> None:
    x *= Fraction(10) ** exponent
    with ctx.workprec(400):
        text = round_ball(arb(x.numerator) / x.denominator, digits)
    if text is None:
        scaled = x / rounded(x, digits)[1]
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


@given(RATIONALS, EXPONENTS, st.integers(1, 20), st.integers(0, 20))
def test_shortening_is_rounding_once(x: Fraction, exponent: int, digits: int, more: int) -> None:
    x *= Fraction(10) ** exponent
    stored = round_fraction(x, digits + more)
    short = shorten(stored, digits)
    if short is None:
        assert significant(stored)[digits:].rstrip("0") == "5"
    else:
        assert short == round_fraction(x, digits)


@given(st.integers(1, 10**20), st.integers(0, 30), st.integers(-60, 60), st.booleans())
def test_only_a_tie_hides_the_truth(kept: int, zeros: int, exponent: int, negative: bool) -> None:
    digits, dropped = len(str(kept)), "5" + "0" * zeros
    sign = -1 if negative else 1
    tie = place_digits(f"{kept}{dropped}", exponent, negative=negative)
    assert shorten(tie, digits) is None
    for beside in (Fraction(1, 2), Fraction(3, 2)):
        x = Fraction(tie) + sign * (beside - 1) * Fraction(10) ** (exponent - digits - zeros)
        stored = round_fraction(x, digits + zeros + 2)
        assert shorten(stored, digits) == round_fraction(x, digits)


@given(RATIONALS, st.integers(1, 40))
def test_the_context_of_the_caller_does_not_matter(x: Fraction, digits: int) -> None:
    stored = round_fraction(x, digits + 1)
    texts = stored, shorten(stored, digits)
    with localcontext() as context:
        context.prec, context.rounding, context.Emax, context.Emin = 2, ROUND_DOWN, 3, -3
        context.traps[Inexact] = True
        assert (round_fraction(x, digits + 1), shorten(stored, digits)) == texts


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("-180.000", "180.000"),
        ("180.000", "180.000"),
        ("-179.999", "-179.999"),
        ("-18.0", "-18.0"),
        ("0", "0"),
    ],
)
def test_minus_180_is_180(text: str, printed: str) -> None:
    assert angle_text(text) == printed


def test_balls_are_sorted_one_by_one() -> None:
    wide = arb(1, 0.5)
    items = [(wide, arb(3)), (arb(2), arb(0)), (arb(1), arb(2)), (arb(-1), arb(9)), (wide, arb(1))]
    assert sorted_by_balls(range(5), lambda i: items[i]) == [3, 4, 2, 0, 1]
