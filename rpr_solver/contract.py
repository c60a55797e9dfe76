"""Common to all documents and questions: version, head, ranges, defaults, progress, checks of arguments."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import inf
from numbers import Integral
from typing import Any, Protocol

from rpr_solver.errors import InputError, shown

SOLVER_VERSION = "8"
"""The version of the solver's answers, in every document and cache key; raised whenever an answer changes."""

DEFAULT_DIGITS = 90
"""The default number of significant digits of printed numbers."""
CHECK_DIGITS = 30
"""The default number of significant digits of the lengths and examples of a check."""
MIN_DIGITS, MAX_DIGITS = 15, 10_000
"""The least and the greatest number of significant digits of a request."""

FEW_SLICES = 4
"""For so many slices Q is computed at their lengths alone: each is a sixth of the work for all lengths."""

MOST_CUSPS = 24
"""No slice has more cusps than the eliminant Q has roots."""
MOST_POSES = 6
"""No joint vector has more poses."""

FIXED_LEGS = (1, 2, 3)
LEGS = ("l1", "l2", "l3")
"""The legs by number, and the names of their lengths."""

LENGTHS = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
"""The names of a geometry's lengths."""

PATH_DIGITS = 15
"""The default number of significant digits of a path."""
DEFAULT_SAMPLES = 101
"""The default number of samples of a path."""
LEAST_SAMPLES, MOST_SAMPLES = 2, 10_001

DEFAULT_TOLERANCE = Fraction(1, 1000)
"""The default deviation of a drawn curve, relative to the picture."""
FINEST_TOLERANCE, COARSEST_TOLERANCE = Fraction(1, 10**6), Fraction(1, 10)
"""The least and the greatest tolerance of a request."""


def check_digits(digits: int) -> int:
    """Returns a number of significant digits as an ``int``.

    Raises:
        InputError: naming ``digits``: not an integer, or out of range.
    """
    return check_integer(digits, "digits", f"{MIN_DIGITS} to {MAX_DIGITS}", MIN_DIGITS, MAX_DIGITS)


def check_leg(fixed_leg: int, field: str = "fixed_leg") -> int:
    """Returns the number of a leg as an ``int``.

    Raises:
        InputError: naming ``field``: not 1, 2 or 3.
    """
    if isinstance(fixed_leg, bool) or not isinstance(fixed_leg, Integral) or fixed_leg not in FIXED_LEGS:
        raise InputError.of(field, f"{shown(fixed_leg)} is not a leg; give 1, 2 or 3")
    return int(fixed_leg)


def check_integer(value: int, field: str, expected: str, least: int, most: float = inf) -> int:
    """Returns an integer of any type, except ``bool``, as an ``int``.

    Raises:
        InputError: naming ``field``: not an integer, or out of range; the message says what is ``expected``.
    """
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise InputError.of(
            field, f"{shown(value)} is a {type(value).__name__}, not an integer; give {expected}"
        )
    if not least <= value <= most:
        raise InputError.of(field, f"is {shown(value)}; give {expected}")
    return int(value)


def check_type(value: object, kind: type, field: str) -> None:
    """Checks that a value is an instance of a class.

    Raises:
        InputError: naming ``field``: not an instance of ``kind``.
    """
    if not isinstance(value, kind):
        raise InputError.of(
            field, f"{shown(value)} has type {type(value).__name__}; give one of type {kind.__name__}"
        )


def letter(cusp: int) -> str:
    """The letter of a cusp in pictures: A, B, …, X.

    >>> letter(1), letter(24)
    ('A', 'X')
    """
    return chr(ord("A") + cusp - 1)


def number_of(cusp: int | str, count: int = MOST_CUSPS) -> int:
    """The number of a cusp that is given by its number from 1 or its letter.

    Raises:
        InputError: naming ``cusp``: there is no such cusp among ``count``.

    >>> number_of("B", 6), number_of(2, 6), number_of("2", 6)
    (2, 2, 2)
    """
    if not count:
        raise InputError.of("cusp", "this slice has no cusps")
    expected = f"1 to {count}, or A to {letter(count)}"
    if isinstance(cusp, str):
        text = cusp.strip().upper()
        number = next((k for k in range(1, count + 1) if text in (str(k), letter(k))), None)
        if number is None:
            raise InputError.of("cusp", f"{shown(cusp)} names no cusp; give {expected}")
        return number
    if isinstance(cusp, int) and count < cusp <= MOST_CUSPS:
        raise InputError.of("cusp", f"is {cusp} ({letter(cusp)}); give {expected}")
    return check_integer(cusp, "cusp", expected, 1, count)


Progress = Callable[[int, int], None]
"""A callback ``progress(done, total)``; ``total`` may grow."""


def silent(_done: int, _total: int) -> None:
    """A progress callback that does nothing."""


class Identified(Protocol):
    """The part of a manipulator's interface that a document's head needs."""

    def identity_json(self) -> dict[str, Any]:
        """The geometry and its hash."""


def document_head(manipulator: Identified, digits: int, fixed_leg: int | None = None) -> dict[str, Any]:
    """The first members of every document: the manipulator, the fixed leg, digits and solver version."""
    leg = {} if fixed_leg is None else {"fixed_leg": fixed_leg}
    return {**manipulator.identity_json(), **leg, **about_answer(digits)}


def about_answer(digits: int) -> dict[str, Any]:
    """The digits and the solver version of an answer."""
    return {"digits": digits, "solver_version": SOLVER_VERSION}
