"""Forms from their values on a circle, against the coefficients that the values were made of."""

import pytest
from flint import arb, arb_mat, ctx, fmpz
from hypothesis import given, settings
from hypothesis import strategies as st

from rpr_solver.exact.circle import Circle

BITS = 200


def values(circle: Circle, form: list[int]) -> list[arb]:
    return (arb_mat(1, len(form), [fmpz(x) for x in form]) * circle.monomials(len(form) - 1)).entries()


@given(
    st.lists(st.lists(st.integers(-(10**9), 10**9), min_size=1, max_size=30), min_size=1, max_size=2),
    st.integers(1, 4),
)
@settings(max_examples=40)
def test_coefficients_come_back_from_values(rows: list[list[int]], more: int) -> None:
    """Any degree, as many points as coefficients or more, one form or two."""
    with ctx.workprec(BITS):
        form, *others = rows
        second = [(others or [[1]])[0][0] + k for k in range(len(form))]
        circle = Circle(len(form) - 1 + more, BITS)
        back = circle.coefficients([values(circle, form), values(circle, second)], len(form) - 1)
        assert back is not None
        assert [[x.unique_fmpz() for x in row] for row in back] == [form, second]


@pytest.mark.parametrize("degree", [0, 1, 4, 7])
def test_values_that_are_of_no_such_form_are_noticed(degree: int) -> None:
    with ctx.workprec(BITS):
        circle = Circle(degree + 2, BITS)
        sampled = values(circle, list(range(1, degree + 2)))
        assert circle.coefficients([sampled], degree) is not None
        sampled[0] += arb(2) ** -100
        assert circle.coefficients([sampled], degree) is None


def test_radii_stay_near_the_working_precision() -> None:
    """Degree 64: coefficients of tan φ are sums of 2^56 times the values, and little more is lost."""
    with ctx.workprec(BITS):
        circle = Circle(66, BITS)
        assert all(x.rad() < arb(2) ** (10 - BITS) for x in _exponentials(circle))
        back = circle.coefficients([values(circle, [1] * 65)], 64)
        assert back is not None
        assert all(x.rad() < arb(2) ** (56 + 24 - BITS) for x in back[0])


def _exponentials(circle: Circle) -> list[arb]:
    table = circle.monomials(1)
    return [table[0, k] for k in range(circle.count)]
