"""Ranges of lengths of the fixed leg."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from rpr_solver.errors import FieldProblem, InputError
from rpr_solver.exact.rationals import exact_str


def range_problems(start: Fraction, stop: Fraction | None, field: str) -> Iterator[FieldProblem]:
    """What is wrong with a range of lengths; ``stop`` None is no end."""
    if start < 0:
        yield FieldProblem(f"{field}.from", f"is {exact_str(start)}; a length is at least 0")
    if stop is not None and stop <= start:
        yield FieldProblem(f"{field}.to", f"is {exact_str(stop)}; it must exceed {exact_str(start)}")


def check_range(start: Fraction, stop: Fraction | None, field: str = "range") -> None:
    """Refuse what is no range of lengths.

    Raises:
        InputError: an end is negative, or there is nothing between.
    """
    for problem in range_problems(start, stop, field):
        raise InputError([problem])
