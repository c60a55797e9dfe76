"""What all questions and documents have in common: ranges of arguments, and the head of a document."""

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.contract import (
    SOLVER_VERSION,
    about_answer,
    check_digits,
    check_integer,
    check_leg,
    document_head,
)
from rpr_solver.errors import InputError
from tests.support.strategies import examples


class Known:
    """All that a head needs of a manipulator."""

    def identity_json(self) -> dict[str, Any]:
        return {"geometry": {"d1": "1"}, "geometry_hash": "abc"}


def problem(call: Callable[[], object]) -> tuple[str, str]:
    """The field and the message of the only problem."""
    with pytest.raises(InputError) as caught:
        call()
    [one] = caught.value.problems
    return one.field, one.message


@given(st.integers(-20, 10_020))
@examples(60)
def test_digits_from_15_to_10000_are_taken_and_others_are_told_the_range(digits: int) -> None:
    if 15 <= digits <= 10_000:
        assert check_digits(digits) == digits
    else:
        assert problem(lambda: check_digits(digits)) == ("digits", f"is {digits}; give 15 to 10000")


@pytest.mark.parametrize("bad", [20.0, "20", True, None, Decimal(20), Fraction(20), [20]], ids=repr)
def test_only_integers_are_integers(bad: Any) -> None:
    field, message = problem(lambda: check_integer(bad, "count", "2 to 9", 2, 9))
    assert field == "count"
    assert message == f"{bad!r} is a {type(bad).__name__}, not an integer; give 2 to 9"
    assert problem(lambda: check_digits(bad))[0] == "digits"
    assert problem(lambda: check_leg(bad))[0] == "fixed_leg"


@pytest.mark.parametrize("leg", range(-1, 6))
def test_there_are_three_legs(leg: int) -> None:
    if leg in (1, 2, 3):
        assert check_leg(leg) == leg
    else:
        bad = problem(lambda: check_leg(leg, "requirement.fixed_leg"))
        assert bad == ("requirement.fixed_leg", f"{leg} is not a leg; give 1, 2 or 3")


def test_a_document_begins_with_the_manipulator_the_leg_the_digits_and_the_version() -> None:
    head = document_head(Known(), 30, 2)
    assert list(head.items()) == [
        ("geometry", {"d1": "1"}),
        ("geometry_hash", "abc"),
        ("fixed_leg", 2),
        ("digits", 30),
        ("solver_version", SOLVER_VERSION),
    ]
    without = document_head(Known(), 30)
    assert "fixed_leg" not in without
    assert {**without, "fixed_leg": 2} == head
    assert about_answer(17) == {"digits": 17, "solver_version": SOLVER_VERSION}
