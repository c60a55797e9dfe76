"""Lengths of slices, ranges and joint limits: exact, read and written; each fault names its place."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import InputError
from rpr_solver.model.lengths import (
    LengthRange,
    read_limits,
    slice_lengths,
)
from tests.support.strategies import examples, rationals


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
