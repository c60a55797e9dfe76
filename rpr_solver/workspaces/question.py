"""What is asked of a workspace: its orientations and joint limits. It loads nothing that computes."""

from __future__ import annotations

from fractions import Fraction

from rpr_solver.errors import InputError
from rpr_solver.exact.rationals import Exact, exact_str, parse_exact
from rpr_solver.model.lengths import Bounds, ExactLimits, read_limits

_GREATEST_TURN = 360
"""Degrees: an orientation is at most one turn from 0."""
_MOST_ORIENTATIONS = 2000


def workspace_limits(limits: ExactLimits) -> dict[int, Bounds]:
    """The limits of legs, by their numbers.

    Raises:
        InputError: naming ``limits``: they are invalid, or no leg has a greatest length.

    >>> workspace_limits({"l1": (None, 3)})
    {1: (None, Fraction(3, 1))}
    """
    found = read_limits(limits, "limits")
    if all(high is None for _, high in found.values()):
        raise InputError.of("limits", "bound no region; give at least one leg a greatest length")
    return dict(sorted(found.items()))


def orientation(phi: Exact, field: str = "phi") -> Fraction:
    """An orientation in degrees, exact.

    Raises:
        InputError: naming ``field``.
    """
    turn = parse_exact(phi, field)
    if abs(turn) > _GREATEST_TURN:
        most = _GREATEST_TURN
        raise InputError.of(field, f"is {exact_str(turn)}; give degrees from -{most} to {most}")
    return turn


def orientations(start: Fraction, stop: Fraction, step: Fraction) -> list[Fraction]:
    """The orientations of a sweep.

    Raises:
        InputError: naming ``step`` or ``stop``.
    """
    if step <= 0:
        raise InputError.of("step", f"is {exact_str(step)}; a step must be > 0")
    if stop < start:
        raise InputError.of("stop", f"is {exact_str(stop)}; it must be at least {exact_str(start)}")
    count = int((stop - start) // step) + 1
    if count > _MOST_ORIENTATIONS:
        raise InputError.of("step", f"gives {count} orientations; at most {_MOST_ORIENTATIONS} are computed")
    return [start + k * step for k in range(count)]
