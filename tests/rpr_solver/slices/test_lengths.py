"""Lengths of the fixed leg: exact, positive, and each at fault named by its leg and place."""

from decimal import Decimal
from fractions import Fraction

import pytest

from rpr_solver import InputError
from rpr_solver.slices.lengths import slice_length, slice_lengths


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
