"""Numbers of documents become floats and short texts of the same value."""

from __future__ import annotations

from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.errors import InputError
from rpr_solver.figures.words import exact, listed, number, short


@given(st.decimals(min_value=-(10**9), max_value=10**9, places=6))
def test_short_numbers_are_near(value: Decimal) -> None:
    text = short(str(value), 5).replace("−", "-")
    assert len(text) <= 16
    assert float(text) == pytest.approx(float(value), rel=1e-4)


def test_short_numbers_of_any_size() -> None:
    assert [short(x) for x in ("1e-400", "-12345678e400", "0", "0.00100", "99999.7", "2/3")] == [
        "1e−400", "−1.235e407", "0", "0.001", "100000", "0.6667",
    ]  # fmt: skip


def test_numbers() -> None:
    assert [number(x) for x in ("1/3", "sqrt(2)", "-4.5e1")] == [1 / 3, 2**0.5, -45.0]
    assert exact("426/25") == Decimal("17.04")
    with pytest.raises(InputError, match=r"1e400 is too large to be drawn"):
        number("1e400")


def test_enumerations() -> None:
    assert [listed(x) for x in (["A"], ["A", "B"], ["A", "B", "C"])] == ["A", "A and B", "A, B and C"]
