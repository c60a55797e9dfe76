"""Conversions of exact numbers of any size."""

from __future__ import annotations

import time
from fractions import Fraction
from math import isfinite

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.errors import InputError
from rpr_solver.exact.numerals import (
    check_doubles,
    digit_count,
    double,
    fraction,
    integer,
    integer_text,
)
from rpr_solver.exact.rationals import exact_str, parse_exact

INTEGERS = st.builds(
    lambda sign, lead, digits: sign * (lead * 10**digits + 7),
    st.sampled_from([-1, 1]),
    st.integers(1),
    st.integers(1, 6000),
)
TEXTS = st.from_regex(
    r"\A[+-]?([0-9]{1,9}(\.[0-9]{0,9})?|\.[0-9]{1,9})([eE][+-]?[0-9]{1,3})?\Z|\A[+-]?[0-9]{1,9}/[1-9][0-9]{0,8}\Z"
)


@given(INTEGERS)
def test_integers_of_any_length_are_read_and_written(x: int) -> None:
    text = integer_text(x)
    assert integer(text) == x
    assert text[-1] == "7"
    assert len(text.lstrip("-")) == digit_count(text)


@given(INTEGERS, INTEGERS)
def test_the_text_of_a_fraction_gives_it_back(x: int, y: int) -> None:
    exact = Fraction(x, abs(y))
    assert fraction(exact_str(exact)) == exact
    assert fraction(f"1.{'3' * 9000}e-5000") * 10**14000 == integer("1" + "3" * 9000)


@given(TEXTS)
def test_digits_are_counted_as_the_limit_counts_them(text: str) -> None:
    """A number with at most so many digits is never refused."""
    count = digit_count(text)
    exact = parse_exact(text, "x", max_digits=2000)
    parts = max(len(str(abs(exact.numerator))), len(str(exact.denominator)))
    assert count >= parts
    if "/" not in text:  # a quotient, and a decimal with a factor of 10, may have a common divisor
        assert count <= parts + max(text.count("0"), 400)
    assert parse_exact(text, "x", max_digits=count) == exact


@pytest.mark.parametrize(
    "text", ["", " ", "x", "1x", "1.2.3", "--1", "1e", "1e+", "e5", ".", "1/2/3", "1/-2", "/", "٣", "1_000"]
)
def test_no_digits_are_counted_in_what_is_no_number(text: str) -> None:
    assert digit_count(text) == 0
    with pytest.raises(InputError):
        parse_exact(text, "x")


HOSTILE = {
    "zeros before a digit": "1." + "0" * 1_000_000 + "1",
    "zeros before a letter": "1." + "0" * 1_000_000 + "x",
    "zeros before the point": "0" * 1_000_000 + ".x",
    "a long exponent": "1e" + "0" * 1_000_000 + "9",
    "slashes": "/" * 1_000_000,
    "signs": "+" * 1_000_000,
    "spaces": " " * 1_000_000 + "x",
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_hostile_texts_take_linear_time(text: str) -> None:
    begin = time.process_time()
    digit_count(text)
    with pytest.raises(InputError):
        parse_exact(text, "x")
    assert time.process_time() - begin < 1


@given(st.fractions(), st.integers(-500, 500))
def test_what_doubles_hold_is_neither_infinite_nor_lost(x: Fraction, exponent: int) -> None:
    length = x * Fraction(10) ** exponent
    if length and not Fraction(1, 10**150) <= abs(length) <= 10**150:
        with pytest.raises(InputError, match=r"^geometry\.d1: is .*1e-150 to 1e150"):
            check_doubles({"geometry.d1": length}, "margins")
    else:
        check_doubles({"geometry.d1": length}, "margins")
        assert isfinite(double(length) ** 2)
        assert bool(double(length) ** 2) == bool(length)
