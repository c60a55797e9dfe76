"""Ranges of lengths: what is in them, how they are read, named and written; the intervals of a document."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.errors import InputError
from rpr_solver.slices.length_range import LengthRange, intervals_json
from tests.support.strategies import examples, rationals

LENGTHS = rationals(0, 20, (1, 4, 3))


@given(LENGTHS, st.one_of(st.none(), LENGTHS), LENGTHS)
@examples(60)
def test_a_range_holds_its_ends_and_what_is_between(
    start: Fraction, stop: Fraction | None, length: Fraction
) -> None:
    if stop is not None and stop <= start:
        with pytest.raises(InputError) as caught:
            LengthRange.of(start, stop)
        assert [p.field for p in caught.value.problems] == ["stop"]
        return
    span = LengthRange.of(start, stop)
    assert (length in span) == (start <= length and not (stop is not None and length > stop))
    assert start in span
    assert stop is None or stop in span


@given(LENGTHS, st.one_of(st.none(), rationals(21, 40, (1, 4, 3))))
@examples(30)
def test_a_range_survives_its_document(start: Fraction, stop: Fraction | None) -> None:
    span = LengthRange(start, stop)
    document = span.to_json()
    assert LengthRange.of(document["from"], document["to"]) == span
    assert list(document) == ["from", "to"]


def test_without_ends_it_is_all_lengths() -> None:
    span = LengthRange.of(None, None)
    assert span == LengthRange() == LengthRange(Fraction(0), None)
    assert span.to_json() == {"from": "0", "to": None}
    assert Fraction(10) ** 30 in span
    assert str(span) == "from 0"
    assert str(LengthRange.of("20.50", "64/3")) == "from 20.5 to 64/3"


@pytest.mark.parametrize(
    ("ends", "fields"),
    [
        ((-1, None), {"start": "is -1; a length is at least 0"}),
        ((None, 0), {"stop": "is 0; it must exceed 0"}),
        (("7/2", "3.5"), {"stop": "is 3.5; it must exceed 3.5"}),
        ((-1, "-5/4"), {"start": "is -1; a length is at least 0", "stop": "is -1.25; it must exceed -1"}),
    ],
)
def test_each_bad_end_is_named_with_its_value(ends: tuple[object, object], fields: dict[str, str]) -> None:
    for names in (("start", "stop"), ("l2.min", "l2.max")):
        with pytest.raises(InputError) as caught:
            LengthRange.of(*ends, names)  # type: ignore[arg-type]
        own = dict(zip(("start", "stop"), names, strict=True))
        assert {p.field: p.message for p in caught.value.problems} == {
            own[field]: message for field, message in fields.items()
        }


def test_both_ends_are_read_before_anything_is_said() -> None:
    with pytest.raises(InputError) as caught:
        LengthRange.of(1.5, "x")  # type: ignore[arg-type]
    assert [p.field for p in caught.value.problems] == ["start", "stop"]


def test_intervals_lie_between_neighbouring_ends() -> None:
    assert intervals_json(["0", "1.5", None], [4, 6]) == [
        {"from": "0", "to": "1.5", "count": 4},
        {"from": "1.5", "to": None, "count": 6},
    ]
    assert intervals_json(["2", "3"], [0]) == [{"from": "2", "to": "3", "count": 0}]
