"""Rising precision, at which balls decide a question.

A question is evaluated in balls at doubling precision until they decide it. Balls never err, but they may
leave a question open; whether two equal numbers differ is open at every precision. So each question has a
precision limit, beyond which it is decided by exact arithmetic or refused as
:class:`~rpr_solver.errors.Unproved`.

>>> decided(lambda bits: bits if bits > 300 else None, 128, 1 << 10, "a number larger than 300")
512
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from rpr_solver.errors import Unproved

S = TypeVar("S")
T = TypeVar("T")

GREATEST_BITS = 1 << 18
"""Nearly eight times the bits of 10,000 digits; a question still open here is most likely degenerate."""
LENGTH_BITS = 1 << 13
"""Two transitions that agree to 2,000 digits are presumably equal, which only a proof of equality decides."""
MATCH_BITS = 1 << 13
"""The limit for matching cusps; slices are solved again to a sixth as many digits, which takes long."""
TUBE_BITS = 1 << 12
"""The bits that a tube needs grow as its reach shrinks; a curve without a tube here has no direction."""
EVENT_BITS = 1 << 12
"""An event still open here is nearly always degenerate, and a number field decides it faster."""
EXACT_BITS = 1 << 14
"""A coordinate of an event that is still open here is most likely 0; a number field takes seconds."""
TIMES_BEFORE_EXACT = 8
"""Digits still open at this multiple of their own bits lie on a tie or at 0, which a number field decides."""


def precisions(start: int, limit: int, *, stop_at: int = 0) -> Iterator[int]:
    """The precisions to try: ``start`` doubled repeatedly up to ``limit``, with ``stop_at`` inserted.

    >>> list(precisions(100, 900)), list(precisions(100, 900, stop_at=150))
    ([100, 200, 400, 800], [100, 150, 300, 600])
    """
    bits = start
    while bits <= limit:
        yield bits
        bits = stop_at if bits < stop_at <= 2 * bits else 2 * bits


def decided_or_none(attempt: Callable[[int], T | None], start: int, limit: int) -> T | None:
    """As :func:`decided`, but None if the question is still open at ``limit``."""
    for bits in precisions(start, limit):
        answer = attempt(bits)
        if answer is not None:
            return answer
    return None


def all_decided(
    attempt: Callable[[S, int], T | None], items: Sequence[S], start: int, limit: int
) -> list[T] | None:
    """The answers of ``attempt(item, bits)`` for all items, or None if one stays undecided up to ``limit``.

    An item is not attempted again once it is decided; the precision never falls from one item to the next.
    """
    answers: list[T] = []

    def complete(bits: int) -> list[T] | None:
        for item in items[len(answers) :]:
            if (answer := attempt(item, bits)) is None:
                return None
            answers.append(answer)
        return answers

    return decided_or_none(complete, start, limit)


def decided(attempt: Callable[[int], T | None], start: int, limit: int, message: str) -> T:
    """Returns the first answer of ``attempt(bits)`` that is not None, at doubling precision.

    Raises:
        Unproved: the question is still open at ``limit``; ``message`` is the text of the error.
    """
    answer = decided_or_none(attempt, start, limit)
    if answer is None:
        raise Unproved(message)
    return answer
