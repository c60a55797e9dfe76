from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, InputError, cusp_table, exact_str, parse_exact
from rpr_solver.exact.rationals import rational_sqrt, short_between
from tests.support.strategies import rationals


@pytest.mark.parametrize(
    "text", ["17.04", "17.040", "1.704e1", "1704E-2", "426/25", "852/50", "+17.04", " 17.04 "]
)
def test_every_way_of_writing_a_number_is_the_same_number(text: str) -> None:
    assert parse_exact(text, "d1") == Fraction(426, 25)


def test_a_decimal_keeps_what_was_written() -> None:
    assert parse_exact(Decimal("0.1"), "x") == Fraction(1, 10)
    assert parse_exact(".5", "x") == parse_exact("5.e-1", "x") == Fraction(1, 2)
    assert parse_exact("-0", "x") == 0


def test_numbers_that_python_does_not_print_are_written_out() -> None:
    """Python converts no integer of more than 4300 digits."""
    many = 10**5000 + 1
    assert parse_exact(exact_str(Fraction(1, 2**17000)), "x", max_digits=20000) == Fraction(1, 2**17000)
    assert exact_str(Fraction(-many, 3)) == f"-1{'0' * 4999}1/3"
    with pytest.raises(InputError, match="needs a leg length > 0"):
        cusp_table(EXAMPLES["innocenti"], Fraction(-many))
    with pytest.raises(InputError, match="digits: is an int of more than 4300 digits; give 15 to 10000"):
        cusp_table(EXAMPLES["innocenti"], 1, digits=many)


@pytest.mark.parametrize(
    ("value", "says"),
    [
        (17.04, "float"),
        (True, "bool"),
        (None, "NoneType"),
        ("", "not a finite number"),
        (".", "not a finite number"),
        ("nan", "not a finite number"),
        (Decimal("Infinity"), "not a finite number"),
        ("1/0", "denominator 0"),
        ("1/-2", "not a finite number"),
        ("١٢", "not a finite number"),
        ("1e999999999", "more than 400 digits"),
        ("1e-5000", "more than 400 digits"),
        ("9" * 401, "more than 400 digits"),
        ("1/" + "9" * 401, "more than 400 digits"),
        pytest.param(10**5000, "more than 400 digits", id="huge integer"),
        pytest.param("1" * 100_000, "more than 400 digits", id="huge text"),
    ],
)
def test_what_is_no_exact_number_is_refused_by_name(value: object, says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        parse_exact(value, "geometry.d1")  # type: ignore[arg-type]
    assert [p.field for p in caught.value.problems] == ["geometry.d1"]
    assert len(str(caught.value)) < 200


def test_the_limit_on_digits_is_exact() -> None:
    assert parse_exact("9" * 400, "x") == 10**400 - 1
    assert parse_exact("1e-399", "x") == Fraction(1, 10**399)


@given(st.fractions())
def test_the_canonical_text_reads_back(x: Fraction) -> None:
    assert parse_exact(exact_str(x), "x") == x


@given(st.decimals(allow_nan=False, allow_infinity=False, places=12))
def test_decimals_have_a_plain_canonical_text(x: Decimal) -> None:
    text = exact_str(Fraction(x))
    assert "/" not in text
    assert "e" not in text
    assert Decimal(text) == x


@given(rationals(0, 30, (1, 2, 3, 7)), st.sampled_from([1, 2, Fraction(1, 3)]))
@example(Fraction(0), 2)
def test_square_roots_of_rationals(x: Fraction, factor: Fraction) -> None:
    assert rational_sqrt(x * x) == x
    assert rational_sqrt(x * x * factor) == (x if factor == 1 or x == 0 else None)


def test_what_has_no_rational_root() -> None:
    for x in (Fraction(4, 3), Fraction(3, 4)):
        assert rational_sqrt(x) is None


@given(st.fractions(0, 1000), st.fractions(0, 1000, max_denominator=10**30).filter(bool))
def test_a_short_decimal_between(low: Fraction, gap: Fraction) -> None:
    x = short_between(low, low + gap)
    assert low < x < low + gap
    assert x.denominator == 1 or gap * 10 ** len(exact_str(x).partition(".")[2]) < 40
