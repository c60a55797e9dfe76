"""How much work a verification may do: operations are counted, so that the bound is the same everywhere.

A unit is at most some two microseconds of one core: a product of two short numbers, with what goes with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

UNITS_OF_A_CHARACTER = 80
LEAST_CHARACTERS = 100_000
"""A shorter document has the work of one of this length: about ten seconds."""
_SHORT_BITS, _SHIFT = 256, 20

_left: ContextVar[list[int] | None] = ContextVar("left", default=None)


class ExhaustedError(Exception):
    """A document needs more work than its length allows."""


@contextmanager
def bounded(units: int) -> Iterator[list[int]]:
    """Counts the work within, in the first entry of a list as what is left of it."""
    left = [units]
    token = _left.set(left)
    try:
        yield left
    finally:
        _left.reset(token)


def spend(products: int, bits: int = 0) -> None:
    """Counts products, or quotients, of numbers of some length.

    Raises:
        ExhaustedError: the work is used up.
    """
    left = _left.get()
    if left is None:
        return
    left[0] -= products if bits < _SHORT_BITS else products * (1 + (bits * bits >> _SHIFT))
    if left[0] < 0:
        raise ExhaustedError
