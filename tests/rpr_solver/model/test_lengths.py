"""Lengths of slices, ranges and joint limits: exact, read and written; each fault names its place."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import InputError
from rpr_solver.model.lengths import (
    LengthRange,
    intervals_json,
    limits_json,
    read_limits,
    slice_length,
    slice_lengths,
)
from tests.support.strategies import examples, rationals


@pytest.mark.parametrize("spelling", ["17.04", "426/25", Decimal("17.040"), Fraction(426, 25)])
def test_a_length_is_exact(spelling: str | Decimal | Fraction) -> None:
    assert slice_length(spelling, 1) == Fraction(426, 25)
    assert slice_lengths(spelling, 1) == [Fraction(426, 25)]


def test_lengths_stay_in_their_order_and_may_repeat() -> None:
    assert slice_lengths(iter(["3", 1, "3"]), 2) == [3, 1, 3]
    assert slice_lengths([], 2) == []


@pytest.mark.parametrize("bad", ["0", -1, "-1/7", "x", None, 2.5])
def test_a_bad_length_is_named_by_the_leg(bad: object) -> None:
    with pytest.raises(InputError) as caught:
        slice_length(bad, 3)  # type: ignore[arg-type]
    assert [p.field for p in caught.value.problems] == ["l3"]


def test_every_bad_length_is_named_with_its_place() -> None:
    with pytest.raises(InputError) as caught:
        slice_lengths([0, 5, "x", "7", "-2"], 2)
    assert [p.field for p in caught.value.problems] == ["l2[0]", "l2[2]", "l2[4]"]
    assert "a slice needs a leg length > 0" in caught.value.problems[0].message
    with pytest.raises(InputError) as caught:
        slice_lengths("0", 2)
    assert [p.field for p in caught.value.problems] == ["l2"]


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


def test_legs_are_given_by_number_or_by_name() -> None:
    by_number = read_limits({2: ("5", None), 3: (None, "20.5")}, "limits")
    assert by_number == read_limits({"l3": (None, "20.5"), "l2": (5, None)}, "limits")
    assert by_number == {2: (Fraction(5), None), 3: (None, Fraction(41, 2))}
    assert limits_json(by_number) == {"l2": {"min": "5", "max": None}, "l3": {"min": None, "max": "20.5"}}


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"l2": (5, 4)}, "limits.l2.max: is 4; it must exceed 5"),
        ({"l2": (-1, 4)}, "limits.l2.min: is -1"),
        ({"l2": 5}, "limits.l2: is 5; give"),
        ({"l4": (1, 2)}, "limits: 'l4' is not a leg"),
        ({1: (1, 2)}, "limits.l1: is the fixed leg"),
        ([(1, 2)], "limits: is .*its keys are the free legs"),
    ],
)
def test_what_is_at_fault_is_named(limits: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_limits(limits, "limits", 1)  # type: ignore[arg-type]


def test_limits_of_the_fixed_leg_may_be_one_length() -> None:
    assert read_limits({"l2": ("27.0", 27)}, "limits", held=2) == {2: (Fraction(27), Fraction(27))}
    assert read_limits({"l2": (0, 27)}, "limits", held=2) == {2: (Fraction(0), Fraction(27))}
    for limits in ({"l2": (0, 0)}, {"l2": (28, 27)}, {"l3": (27, 27)}):
        with pytest.raises(InputError, match="it must exceed"):
            read_limits(limits, "limits", held=2)
