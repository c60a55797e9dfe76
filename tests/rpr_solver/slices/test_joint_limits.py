"""Joint limits: read by number or name, and refused by the place at fault."""

from fractions import Fraction

import pytest

from rpr_solver import InputError
from rpr_solver.slices.joint_limits import limits_json, read_limits


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
