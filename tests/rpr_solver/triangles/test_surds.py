from decimal import Decimal
from fractions import Fraction
from math import isclose, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import InputError
from rpr_solver.triangles import Surd, parse_surd
from tests.support.strategies import rationals

SURDS = st.builds(
    lambda q, r: Surd.root(r) * q,
    rationals(-30, 30, (1, 4, 7, 100)),
    rationals(0, 30, (1, 3, 10)),
)


@pytest.mark.parametrize(
    ("text", "canonical"),
    [
        ("17.04", "17.04"),
        ("1/2", "0.5"),
        ("sqrt(3)", "sqrt(3)"),
        ("5*sqrt(3)/2", "sqrt(18.75)"),
        ("-5*sqrt(3)/2", "-sqrt(18.75)"),
        ("4*sqrt(4)", "8"),
        ("1/2*sqrt(0.5)", "sqrt(0.125)"),
        ("sqrt(9/4)", "1.5"),
        ("sqrt(1/3)/1.5", "sqrt(4/27)"),
        ("+2.5e1*sqrt(2)", "sqrt(1250)"),
        ("0*sqrt(3)", "0"),
        ("sqrt(0)", "0"),
        (" 3*sqrt(2) ", "sqrt(18)"),
        (7, "7"),
        (Decimal("1.50"), "1.5"),
        (Fraction(1, 3), "1/3"),
        (Surd.root(5), "sqrt(5)"),
    ],
)
def test_a_number_has_one_canonical_text(text: object, canonical: str) -> None:
    assert str(parse_surd(text, "x")) == canonical  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        ("3√2", 'write "3*sqrt(2)"'),
        ("5·√3", 'write "5*sqrt(3)"'),
        ("2sqrt(3)", 'write "2*sqrt(3)"'),
        ("sqrt 3", 'write "sqrt(3)"'),
        ("sqrt(3)*5/2", 'write "5/2*sqrt(3)"'),
        ("(1/2)*sqrt(3)", 'write "1/2*sqrt(3)"'),
        ("3^(1/2)", 'write "sqrt(3)"'),
        ("math.sqrt(3)", 'write "sqrt(3)"'),
        (r"5\sqrt{3}", 'write "5*sqrt(3)"'),
        ("5 * sqrt(3) / 2", 'write "5*sqrt(3)/2"'),
        ("1+sqrt(2)", "no sum or product of roots"),
        ("sqrt(3)/2/3", '"5*sqrt(3)/2"'),
        ("sqrt(sqrt(2))", "write a decimal"),
        ("sqrt()", "write a decimal"),
        ("five", "write a decimal"),
        ("nan", "write a decimal"),
        ("5,5*sqrt(3)", 'write a decimal point, "5.5"'),
        ("5,5", 'write a decimal point, "5.5"'),
        ("sqrt(-3)", "give a number ≥ 0 under the root"),
        ("sqrt(3)/0", "is divided by 0"),
        ("", "write a decimal"),
        (1.5, 'write "1.5"'),
        (True, "not an exact number"),
        (None, "not an exact number"),
        ("9" * 401, "more than 400 digits"),
        ("sqrt(" + "9" * 1601 + ")", "more than 1600 digits"),
        ("s" * 10**6, "characters"),
    ],
)
def test_what_is_no_number_is_refused_with_what_to_write(text: object, advice: str) -> None:
    with pytest.raises(InputError, match=r"^d1: ") as caught:
        parse_surd(text, "d1")  # type: ignore[arg-type]
    assert advice in str(caught.value)
    assert len(str(caught.value)) < 300


@given(SURDS, SURDS)
def test_order_and_products_are_those_of_the_numbers(x: Surd, y: Surd) -> None:
    a, b = (z.sign * sqrt(z.square) for z in (x, y))
    if not isclose(a, b, rel_tol=1e-9, abs_tol=1e-9):
        assert (x < y) == (a < b)
    assert (x == y) == (x <= y <= x)
    product = x * y
    assert isclose(product.sign * sqrt(product.square), a * b, rel_tol=1e-9, abs_tol=1e-9)


def test_numbers_that_differ_in_the_last_of_a_thousand_digits_are_told_apart() -> None:
    root, near = parse_surd("sqrt(2)", "x"), Surd.root(2 + Fraction(1, 10**1000))
    assert root < near
    assert root != near
    assert root * root == Surd.of(2)
