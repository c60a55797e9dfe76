from __future__ import annotations

import json
import time
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import parse_exact
from service.schemas.document import MAX_DEPTH, JsonError, JsonNumber, parse_json

_digits = st.text("0123456789", min_size=1, max_size=60)
_numbers = st.builds(
    lambda sign, whole, part, exponent: sign + (whole.lstrip("0") or "0") + part + exponent,
    st.sampled_from(["", "-"]),
    _digits,
    st.one_of(st.just(""), _digits.map(lambda d: f".{d}")),
    st.one_of(
        st.just(""), st.integers(-99, 99).map(lambda e: f"e{e}"), st.integers(0, 99).map(lambda e: f"E+{e}")
    ),
)


@given(_numbers)
def test_every_json_number_survives_as_written(text: str) -> None:
    value = parse_json(f'{{"n": [{text}]}}'.encode())
    assert value == {"n": [text]}
    [number] = value["n"]  # type: ignore[index]
    assert type(number) is JsonNumber
    assert parse_exact(number, "n") == Fraction(text)


@given(
    st.recursive(
        st.none() | st.booleans() | st.text(),
        lambda x: st.lists(x) | st.dictionaries(st.text(), x),
        max_leaves=20,
    )
)
def test_everything_but_numbers_is_as_json_reads_it(value: object) -> None:
    assert parse_json(json.dumps(value).encode()) == value


@pytest.mark.parametrize(
    "number",
    ["9" * 250_000, "-" + "9" * 250_000, "1." + "0" * 250_000 + "1", "1e" + "9" * 250_000, "1" * 402],
)
def test_a_number_that_is_too_long_is_refused_by_its_length(number: str) -> None:
    begin = time.process_time()
    with pytest.raises(JsonError, match="max_number_digits is 400") as caught:
        parse_json(b'{"a": [1, {"b": %s}]}' % number.encode())
    assert time.process_time() - begin < 0.5
    assert caught.value.field == "a[1].b"
    assert caught.value.limit is not None
    assert parse_json(b"[%s]" % (b"9" * 400)) == ["9" * 400]
    assert parse_json(b'["%s"]' % number.encode()) == [number]


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (b"", "line 1"),
        (b"{", "line 1"),
        (b"{}{}", "Extra data"),
        (b'{"a": 01}', "line 1"),
        (b"\xff", "UTF-8"),
        (b'{"a": NaN}', "NaN"),
        (b'{"a": -Infinity}', "-Infinity"),
        (b'{"a": 1, "b": {"c": 2, "c": 3}}', "'c' is given twice"),
        (b"\xef\xbb\xbf{}", "BOM"),
        (b"[" * 500_000, "nested"),
        (b"[" * (MAX_DEPTH + 1) + b"]" * (MAX_DEPTH + 1), "nested"),
        (b'{"a":' * 60_000 + b"1" + b"}" * 60_000, "nested"),
    ],
)
def test_what_is_not_strict_json_is_refused(body: bytes, said: str) -> None:
    with pytest.raises(JsonError, match=said):
        parse_json(body)


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ('{"l1": [1, NaN]}', "l1[1]"),
        ('{"geometry": {"d1": -Infinity}, "l1": 1}', "geometry.d1"),
        ('{"geometry": {"d1": 1, "d1": 2}}', "geometry.d1"),
        ('{"a": [NaN], "b": 1, "a": 2}', "a"),
    ],
)
def test_what_is_refused_is_named(body: str, field: str) -> None:
    with pytest.raises(JsonError) as caught:
        parse_json(body.encode())
    assert caught.value.field == field


def test_the_greatest_depth_is_allowed() -> None:
    assert parse_json(b"[" * MAX_DEPTH + b"]" * MAX_DEPTH)
