"""What all questions and documents have in common: ranges of arguments, and the head of a document."""

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.contract import (
    CHECK_DIGITS,
    DEFAULT_DIGITS,
    MAX_DIGITS,
    MIN_DIGITS,
    MOST_CUSPS,
    MOST_POSES,
    SOLVER_VERSION,
    about_answer,
    check_digits,
    check_integer,
    check_leg,
    check_type,
    document_head,
    silent,
)
from rpr_solver.errors import InputError
from rpr_solver.model.fibre import DEGREE
from rpr_solver.slices.eliminant import DEGREE_U
from tests.support.strategies import examples


class Small(int):
    """An integer of a type of its own."""


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


@pytest.mark.parametrize("digits", [15, 10_000])
def test_the_ends_of_the_range_of_digits_are_in_it(digits: int) -> None:
    assert check_digits(digits) == digits
    outside = digits - 1 if digits == 15 else digits + 1
    assert problem(lambda: check_digits(outside))[0] == "digits"
    assert digits in (MIN_DIGITS, MAX_DIGITS)


def test_the_defaults_are_in_the_range() -> None:
    assert [check_digits(x) for x in (DEFAULT_DIGITS, CHECK_DIGITS)] == [90, 30]


@pytest.mark.parametrize("bad", [20.0, "20", True, None, Decimal(20), Fraction(20), [20]], ids=repr)
def test_only_integers_are_integers(bad: Any) -> None:
    field, message = problem(lambda: check_integer(bad, "count", "2 to 9", 2, 9))
    assert field == "count"
    assert message == f"{bad!r} is a {type(bad).__name__}, not an integer; give 2 to 9"
    assert problem(lambda: check_digits(bad))[0] == "digits"
    assert problem(lambda: check_leg(bad))[0] == "fixed_leg"


@pytest.mark.parametrize("outside", [1, 10])
def test_an_integer_out_of_range_is_refused(outside: int) -> None:
    message = problem(lambda: check_integer(outside, "count", "2 to 9", 2, 9))
    assert message == ("count", f"is {outside}; give 2 to 9")
    assert check_integer(10**9, "count", "2 or more", 2) == 10**9


def test_an_integer_of_another_type_becomes_an_int() -> None:
    for number in (check_integer(Small(20), "count", "any", 0), check_digits(Small(20)), check_leg(Small(2))):
        assert type(number) is int


@pytest.mark.parametrize("leg", range(-1, 6))
def test_there_are_three_legs(leg: int) -> None:
    if leg in (1, 2, 3):
        assert check_leg(leg) == leg
    else:
        bad = problem(lambda: check_leg(leg, "requirement.fixed_leg"))
        assert bad == ("requirement.fixed_leg", f"{leg} is not a leg; give 1, 2 or 3")


def test_an_instance_of_another_class_is_refused() -> None:
    check_type(Small(1), int, "x")
    bad = problem(lambda: check_type("1", int, "x"))
    assert bad == ("x", "'1' has type str; give one of type int")


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


def test_silence_takes_any_progress() -> None:
    assert silent(3, 4) is None  # type: ignore[func-returns-value]


def test_as_many_answers_as_the_equations_have_roots() -> None:
    assert (MOST_CUSPS, MOST_POSES) == (DEGREE_U, DEGREE)
