"""The reader: each number has one text, each object each key once."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import InputError
from rpr_solver.exact.decimals import round_fraction
from rpr_solver.exact.rationals import exact_str
from rpr_solver.verify.core.reader import (
    count,
    decimal,
    exact,
    integer,
    names_of_unread,
    parsed,
    polynomial,
    radicand,
    record,
    rows,
    short,
    short_positive,
    square_of,
    told,
    truth,
    unread,
    word,
)

FRACTIONS = st.fractions() | st.decimals(allow_nan=False, allow_infinity=False, places=12).map(Fraction)


@given(FRACTIONS)
def test_an_exact_number_is_read_as_the_solver_writes_it(x: Fraction) -> None:
    assert exact(exact_str(x), "/x") == x


@given(FRACTIONS, st.integers(15, 40), st.integers(-60, 60))
def test_a_decimal_is_read_as_the_solver_prints_it(x: Fraction, digits: int, place: int) -> None:
    x *= Fraction(10) ** place
    text = round_fraction(x, digits)
    printed = decimal(digits)(text, "/x")
    assert abs(printed.value - x) <= printed.half
    assert printed.is_zero == (x == 0)
    for other in (digits - 1, digits + 1):
        if x:
            with pytest.raises(InputError, match="significant digits"):
                decimal(other)(text, "/x")


@given(FRACTIONS, st.sampled_from(["0", " ", "+", "e0", ".", "_1", "\u0661", "/1", "-"]), st.booleans())
def test_another_spelling_is_refused(x: Fraction, more: str, before: bool) -> None:
    text = exact_str(x)
    other = more + text if before else text + more
    try:
        y = exact(other, "/x")
    except InputError:
        return
    assert exact_str(y) == other


@pytest.mark.parametrize(
    ("read", "wrong"),
    [
        (exact, ["-0", "1.", ".5", "1e3", "2/4", "1/2", "1/0", "0/3", "--1", "1 ", 1, 1.5, True, None, "x"]),
        (integer, ["-0", "01", "1.0", "+1", 1, "1e3", ""]),
        (short, ["1.5e-3", "01e-3", "1e3", "1e-0", "1e-03"]),
        (short_positive, ["0", "-1", "-1e-3"]),
        (count(0, 9), [-1, 10, 1.0, "1", True, None]),
        (truth, [0, 1, "true", None]),
        (word("a", "b"), ["c", "A", 1, None, ["a"]]),
        (square_of, ["sqrt(4)", "sqrt(2.25)", "sqrt(-2)", "sqrt()", "sqrt(2", "0", "-1"]),
        (radicand, ["sqrt(1)", "sqrt(-3)", "sqrt(1/2)", "3"]),
        (rows(count(), 1, 2), [[], [1, 2, 3], {"0": 1}, "12", [1, "2"]]),
        (decimal(3), ["1.2", "1.234", "0.0", "00.1", "12.3e1", "1.23e5.0", "-0", 1.23, "0.00000000123"]),
        (decimal(3, 0, 180, zero=False), ["0", "-1.00", "181"]),
    ],
)
def test_what_is_refused(read: Callable[[object, str], object], wrong: list[object]) -> None:
    for value in wrong:
        with pytest.raises(InputError, match=r"^/x"):
            read(value, "/x")


def test_an_object_has_its_members_and_no_others() -> None:
    read = record({"a": count()}, {"b": told(count()), "c": unread})
    assert dict(read({"b": 2, "a": 1}, "")) | {"b": 0} == {"a": 1, "b": 0}
    assert list(read({"b": 2, "a": 1}, "")) == ["a", "b"]
    assert names_of_unread(read({"a": 1, "b": 2, "c": {"d": 1}}, "")) == {"/b", "/c"}
    for value, named in (({}, "/a"), ({"a": 1, "x/y~": 2}, "/x~1y~0"), ({"a": 1, "b": "2"}, "/b"), ([], "")):
        with pytest.raises(InputError) as caught:
            read(value, "")
        assert caught.value.problems[0].field in (named, "document")
    with pytest.raises(TypeError):
        read({"a": 1}, "")["a"] = 2


@pytest.mark.parametrize(
    "text",
    ['{"a": 1, "a": 1}', '{"a": {"b": 1, "b": 2}}', "[1.0]", "[1e2]", "[-0]", "[NaN]", "{", "[" * 9999],
)
def test_json_that_may_be_read_in_two_ways_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        parsed(text)
    with pytest.raises(InputError):
        parsed(text.encode())


def test_bytes_and_texts_are_read_alike() -> None:
    value = {"a": [1, -2, "x\u00e9", None, True]}
    assert parsed(json.dumps(value)) == parsed(json.dumps(value).encode()) == value
    with pytest.raises(InputError):
        parsed(b"\xff")


def test_a_polynomial_has_as_many_coefficients_as_its_degree_says() -> None:
    read = polynomial("t", 1)
    form = {"variable": "t", "degree": 1, "coefficients": ["1", "-2"]}
    assert read(form, "")["coefficients"] == (1, -2)
    irrational = {"omega": "sqrt(3)", "omega_coefficients": ["0", "1"]}
    assert read({**form, **irrational}, "")["omega"] == 3
    for change in ({"omega": "sqrt(3)"}, {"coefficients": ["1"]}, {"degree": 2}, {"variable": "u"}):
        with pytest.raises(InputError):
            read({**form, **change}, "")
