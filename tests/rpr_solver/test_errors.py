"""The tree of errors, the text of an error, and values as messages quote them."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.errors import FieldProblem, InputError, SolverError, Unproved, shown
from rpr_solver.exact.quadratic import DivisionError
from tests.support.strategies import examples

PROBLEMS = st.lists(
    st.builds(FieldProblem, st.sampled_from(["l2", "geometry.d3"]), st.sampled_from(["is 0", "is wrong"])),
    min_size=1,
)


def test_bad_input_is_a_value_error_and_no_failure_of_the_solver() -> None:
    assert issubclass(InputError, ValueError)
    assert not issubclass(InputError, SolverError)
    assert not issubclass(SolverError, ValueError)


def test_what_is_undecided_or_contradictory_is_a_failure_of_the_solver() -> None:
    assert issubclass(Unproved, SolverError)
    assert issubclass(DivisionError, SolverError)
    assert not issubclass(DivisionError, Unproved)


@given(PROBLEMS)
@examples(20)
def test_an_error_names_every_field_in_one_line(problems: Sequence[FieldProblem]) -> None:
    error = InputError(problems)
    assert error.problems == tuple(problems)
    assert str(error).split("; ") == [f"{p.field}: {p.message}" for p in problems]
    assert "\n" not in str(error)


@pytest.mark.parametrize("value", [1.5, "ten", None, "x" * 38, ["l1"]], ids=lambda x: str(x)[:4])
def test_a_short_value_is_quoted_whole(value: object) -> None:
    assert shown(value) == repr(value)
