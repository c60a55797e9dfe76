"""What all documents share: head, version, range of digits, progress; and the checks of arguments."""

from __future__ import annotations

from collections.abc import Callable
from numbers import Integral
from typing import Any, Protocol

from rpr_solver.errors import InputError, shown

SOLVER_VERSION = "2"
"""The version of the solver's answers, in every document and every cache key; raised whenever one changes."""

DEFAULT_DIGITS = 90
"""The significant digits of every printed number, unless others are asked for."""
CHECK_DIGITS = 30
"""The digits of a check, which proves a count: those of its lengths and examples."""
MIN_DIGITS, MAX_DIGITS = 15, 10_000
"""The least and the greatest number of significant digits that can be asked for."""


def check_digits(digits: int) -> int:
    """A number of significant digits, as an ``int``.

    Raises:
        InputError: naming ``digits``: no integer, or out of range.
    """
    number = check_integer(digits, "digits", f"{MIN_DIGITS} to {MAX_DIGITS}")
    if not MIN_DIGITS <= number <= MAX_DIGITS:
        raise InputError.of("digits", f"is {number}; give {MIN_DIGITS} to {MAX_DIGITS}")
    return number


def check_leg(fixed_leg: int, field: str = "fixed_leg") -> int:
    """The number of a leg, as an ``int``.

    Raises:
        InputError: naming ``field``: neither 1, 2 nor 3.
    """
    if isinstance(fixed_leg, bool) or not isinstance(fixed_leg, Integral) or fixed_leg not in (1, 2, 3):
        raise InputError.of(field, f"{shown(fixed_leg)} is not a leg; give 1, 2 or 3")
    return int(fixed_leg)


def check_integer(value: int, field: str, expected: str) -> int:
    """Any kind of integer as an ``int``; ``True`` is none.

    Raises:
        InputError: naming ``field``.
    """
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise InputError.of(
            field, f"{shown(value)} is a {type(value).__name__}, not an integer; give {expected}"
        )
    return int(value)


def check_type(value: object, kind: type, field: str) -> None:
    """Refuse what is not an instance of a class.

    Raises:
        InputError: naming ``field``.
    """
    if not isinstance(value, kind):
        raise InputError.of(field, f"{shown(value)} is a {type(value).__name__}; give a {kind.__name__}")


Progress = Callable[[int, int], None]
"""A callback ``progress(done, total)``: steps done, and their number, which may grow."""


def silent(_done: int, _total: int) -> None:
    """The progress of a caller who asked for none."""


class Identified(Protocol):
    """A manipulator, as far as a document's head is concerned."""

    def identity_json(self) -> dict[str, Any]:
        """The geometry and its hash."""
        ...


def document_head(manipulator: Identified, digits: int, fixed_leg: int | None = None) -> dict[str, Any]:
    """What a document begins with: about which manipulator and leg it is, and how it was computed."""
    leg = {} if fixed_leg is None else {"fixed_leg": fixed_leg}
    return {**manipulator.identity_json(), **leg, **about_answer(digits)}


def about_answer(digits: int) -> dict[str, Any]:
    """How an answer was computed."""
    return {"digits": digits, "solver_version": SOLVER_VERSION}
