"""What every document shares: the version of the solver and the range of digits."""

from __future__ import annotations

from rpr_solver.errors import InputError

SOLVER_VERSION = "2"
"""Part of every cache key: raised whenever an answer could change."""


DEFAULT_DIGITS = 90
MIN_DIGITS, MAX_DIGITS = 15, 10_000


def check_digits(digits: int) -> None:
    """Refuse a number of digits that is out of range.

    Raises:
        InputError: it is.
    """
    if not MIN_DIGITS <= digits <= MAX_DIGITS:
        raise InputError.of("digits", f"is {digits}; give {MIN_DIGITS} to {MAX_DIGITS}")
