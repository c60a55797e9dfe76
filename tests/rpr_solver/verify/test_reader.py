"""The reader: each number has one text, each object each key once, and nothing is too long or too deep."""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import InputError
from rpr_solver.exact.decimals import round_fraction
from rpr_solver.exact.rationals import exact_str
from rpr_solver.verify.numbers import ball, exact, printed, square_of
from rpr_solver.verify.reader import (
    MAX_DEPTH,
    check_bounds,
    parsed,
    pointer_step,
)

RATIONALS = st.fractions(max_denominator=10**12)


@given(RATIONALS)
def test_an_exact_number_is_read_from_the_text_that_documents_have(x: Fraction) -> None:
    assert exact(exact_str(x), "/x") == x


@pytest.mark.parametrize(
    "text", ["", "+1", "01", "1.0", "1.", ".5", "-0", "1e3", "2/4", "1/2", "1/-3", "٣", " 1", "1 "]
)
def test_any_other_text_of_a_number_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"^/x: "):
        exact(text, "/x")


@given(RATIONALS.filter(bool), st.integers(15, 40))
def test_a_printed_decimal_holds_the_numbers_that_round_to_it(x: Fraction, digits: int) -> None:
    number = printed(digits)(round_fraction(x, digits), "/x")
    assert number.lower <= x <= number.upper
    unit = Fraction(10) ** number.place
    assert number.value == number.number * unit
    with ctx.workprec(512):
        assert number.rounds(ball(number.value)) is True
        for beyond in (number.lower - unit / 1000, number.upper + unit / 1000):
            assert number.rounds(ball(beyond)) is False
        assert number.rounds(ball(number.upper).union(ball(number.value))) is None
        assert number.rounds(ball(number.value + 360), 360) is True


def test_below_a_power_of_ten_less_rounds_to_it() -> None:
    number = printed(15)("1.00000000000000", "/x")
    assert (1 - number.lower) * 10 == number.upper - 1
    number = printed(15)("-1.00000000000000", "/x")
    assert (number.upper + 1) * 10 == -1 - number.lower


def test_a_printed_zero_is_exactly_zero() -> None:
    zero = printed(15)("0", "/x")
    assert (zero.rounds(arb(0)), zero.rounds(arb(0, 1)), zero.rounds(arb(1))) == (True, None, False)
    with pytest.raises(InputError):
        printed(15, zero=False)("0", "/x")


@pytest.mark.parametrize(
    "text", ["1.5", "1.5000000000000", "01.5000000000000", "1.50000000000000e+0", "15.0000000000000e-1"]
)
def test_a_decimal_of_another_form_is_refused(text: str) -> None:
    assert printed(15)("1.50000000000000", "/x").value == Fraction(3, 2)
    with pytest.raises(InputError):
        printed(15)(text, "/x")


def test_squares_are_those_of_lengths_or_under_a_root() -> None:
    assert square_of("3", "/x") == 9
    assert square_of("sqrt(2)", "/x") == 2
    for text in ("sqrt(4)", "sqrt(-2)", "-3", "sqrt(9/4)"):
        with pytest.raises(InputError):
            square_of(text, "/x")


@pytest.mark.parametrize(
    "text",
    ['{"a": 1, "a": 1}', "[1e999]", "[NaN]", "[-0]", "[12345678901234]", "{", '"' + "[" * 9, "[" * 99_999],
)
def test_what_is_no_strict_json_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"^document: "):
        parsed(text)


def test_a_document_is_bounded_in_depth_and_in_the_length_of_numbers() -> None:
    deep: object = {}
    for _ in range(MAX_DEPTH - 1):
        deep = {"a": deep}
    assert check_bounds({"a": []}) < 20
    check_bounds(deep)  # type: ignore[arg-type]
    for document in (
        {"a": deep},
        {"x": "9" * 2076},
        {"x": "0." + "1" * 9999},
        {"x": "\ud800"},
        {"\ud800": 1},
    ):
        with pytest.raises(InputError):
            check_bounds(document)  # type: ignore[arg-type]
    check_bounds({"digits": 10_000, "x": "9" * 50_000})
    with pytest.raises(InputError):
        check_bounds({"digits": 10_000, "x": "9" * 50_000}, most_digits=100)


@given(st.text(max_size=200))
def test_the_name_of_a_member_stays_in_one_line(name: str) -> None:
    assert pointer_step(name).isprintable()
