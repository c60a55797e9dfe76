"""Reading the lengths of slices: exact and positive."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from functools import partial

from rpr_solver.exact.rationals import Exact, one_or_more, parse_all, parse_positive

_positive = partial(parse_positive, expected="a slice needs a leg length > 0 (at 0 its angle is undefined)")


def slice_length(length: Exact, fixed_leg: int) -> Fraction:
    """The length of a slice's fixed leg, in the user's unit.

    Raises:
        InputError: naming the leg: the length is not an exact number, or not positive.
    """
    return _positive(length, f"l{fixed_leg}")


def slice_lengths(lengths: Exact | Iterable[Exact], fixed_leg: int) -> list[Fraction]:
    """As :func:`slice_length`, for one length or several.

    Raises:
        InputError: naming the leg and the place of each length at fault.
    """
    return list(parse_all(one_or_more(lengths, f"l{fixed_leg}"), _positive).values())
