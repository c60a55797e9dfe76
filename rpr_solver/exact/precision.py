"""Rising precision: a question is put to balls of 2, 4, 8, … times the first precision until they decide it.

Balls never err, but they may leave a question open, and the answer to two equal numbers is "open" at every
precision. So each question has a limit. Beyond it the question goes another, exact way, or is refused as
:class:`~rpr_solver.errors.Unproved`.

>>> decided(lambda bits: bits if bits > 300 else None, 128, 1 << 10, "a number larger than 300")
512
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

from rpr_solver.errors import Unproved

T = TypeVar("T")

GREATEST_BITS = 1 << 18
"""Nearly eight times the bits of 10,000 digits: a question still open here is a coincidence, or badly put."""
LENGTH_BITS = 1 << 13
"""Two transitions that agree to 2,000 digits are taken to be one, and only a proof of equality is of use."""
MATCH_BITS = 1 << 13
"""A sixth of these bits are the digits to which a slice is solved anew, and more would take long."""
TUBE_BITS = 1 << 12
"""A tube needs few bits more than its reach is small; without one here, the curve has no direction."""
EVENT_BITS = 1 << 12
"""An event still open here is nearly always degenerate, and a number field settles it sooner."""
TIMES_BEFORE_EXACT = 8
"""Digits still open at so many times their own bits lie on a tie or at 0: a number field can show it."""


def precisions(start: int, limit: int, *, stop_at: int = 0) -> Iterator[int]:
    """The precisions to try: ``start`` doubled again and again up to ``limit``, with a stop at ``stop_at``.

    >>> list(precisions(100, 900)), list(precisions(100, 900, stop_at=150))
    ([100, 200, 400, 800], [100, 150, 300, 600])
    """
    bits = start
    while bits <= limit:
        yield bits
        bits = stop_at if bits < stop_at <= 2 * bits else 2 * bits


def decided_or_none(attempt: Callable[[int], T | None], start: int, limit: int) -> T | None:
    """As :func:`decided`, but None where the precisions up to ``limit`` leave the question open."""
    for bits in precisions(start, limit):
        answer = attempt(bits)
        if answer is not None:
            return answer
    return None


def decided(attempt: Callable[[int], T | None], start: int, limit: int, message: str) -> T:
    """Returns the first answer of ``attempt(bits)`` that is not None, at doubling precision.

    Raises:
        Unproved: there is none up to ``limit``; ``message`` says what could not be proved.
    """
    answer = decided_or_none(attempt, start, limit)
    if answer is None:
        raise Unproved(message)
    return answer
