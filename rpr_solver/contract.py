"""What every document shares: its head, the version of the solver, the range of digits, and its progress."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from rpr_solver.errors import InputError

SOLVER_VERSION = "2"
"""Part of every cache key: raised whenever an answer could change."""

DEFAULT_DIGITS = 90
CHECK_DIGITS = 30
"""The digits of a check, which proves a count: those of its lengths and examples."""
MIN_DIGITS, MAX_DIGITS = 15, 10_000


def check_digits(digits: int) -> None:
    """Refuse a number of digits that is out of range.

    Raises:
        InputError: it is.
    """
    if not MIN_DIGITS <= digits <= MAX_DIGITS:
        raise InputError.of("digits", f"is {digits}; give {MIN_DIGITS} to {MAX_DIGITS}")


Progress = Callable[[int, int], None]
"""Told the steps done and their number, which may grow."""


def silent(_done: int, _total: int) -> None:
    """The progress of a caller who asked for none."""


class Identified(Protocol):
    """A manipulator, as far as a document's head is concerned."""

    def identity_json(self) -> dict[str, object]:
        """The geometry and its hash."""
        ...


def document_head(manipulator: Identified, digits: int, fixed_leg: int | None = None) -> dict[str, object]:
    """What a document begins with: about which manipulator and leg it is, and how it was computed."""
    leg = {} if fixed_leg is None else {"fixed_leg": fixed_leg}
    return {**manipulator.identity_json(), **leg, **about_answer(digits)}


def about_answer(digits: int) -> dict[str, object]:
    """How an answer was computed."""
    return {"digits": digits, "solver_version": SOLVER_VERSION}
