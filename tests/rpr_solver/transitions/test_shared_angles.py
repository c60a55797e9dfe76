"""Angles at which two forms vanish for every v: divided out with all their powers, and returned."""

import pytest

from rpr_solver.exact.biform import OMEGA, BiForm, T, U
from rpr_solver.transitions.shared_angles import SharedAngles

FIRST, SECOND = T * U + OMEGA, T**2 + U**2 * OMEGA - 3


def form(p: object, degree_t: int, degree_u: int) -> BiForm:
    return BiForm.of(p, 2, degree_t, degree_u)  # type: ignore[arg-type]


@pytest.mark.parametrize("angle", [T, T - 5, T - OMEGA, T**2 - OMEGA])
def test_a_shared_angle_is_divided_out_with_its_powers(angle: object) -> None:
    degree = int(angle.degrees()[0])  # type: ignore[attr-defined]
    first, second = form(FIRST * angle**2, 1 + 2 * degree, 1), form(SECOND * angle, 2 + degree, 2)  # type: ignore[operator]
    shared = SharedAngles.of(first, second)
    assert shared is not None
    assert (shared.first.degree_t, shared.second.degree_t) == (1, 2)
    assert shared.first.quotient(form(FIRST, 1, 1)).degree_t == 0
    assert shared.second.quotient(form(SECOND, 2, 2)).degree_t == 0
    assert shared.angles.quotient(form(angle, degree, 0)).degree_t == 0


def test_a_half_turn_is_an_angle_too() -> None:
    shared = SharedAngles.of(form(FIRST, 3, 1), form(SECOND, 3, 2))
    assert shared is not None
    assert (shared.first.degree_t, shared.second.degree_t) == (1, 2)
    assert (shared.angles.degree_t, shared.angles.zeros_at_infinity) == (1, 1)


def test_forms_that_share_no_angle() -> None:
    assert SharedAngles.of(form(FIRST * (T - 1), 2, 1), form(SECOND, 2, 2)) is None
    assert SharedAngles.of(form(FIRST, 2, 1), form(SECOND, 2, 2)) is None
